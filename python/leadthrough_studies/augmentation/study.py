"""A policy from three demonstrations, from a thousand episodes of ours, by noise and by shifting.

A person demonstrates three reaches of a Panda. Data sets made of them train the same network, with
as many gradient updates. The policy then reaches 500 goals drawn from a region, the same ones for
all, by chunks that `lt.guard.Chunks` follows on a simulated arm. Success is a tip within 2 cm of
the goal after 6 s, at rest, without a contact on the way. Every training has demonstrations,
episodes and weights of its own. Needs the extra `policies`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough_studies.augmentation.episodes import DATA_SETS, GOALS, demonstrations
from leadthrough_studies.augmentation.policy import Policy, reach
from leadthrough_studies.augmentation.report import report
from leadthrough_studies.study import Row, Study, Task


@dataclass(frozen=True)
class AugmentationConfig:
    """The configuration of the study.

    Attributes:
        data: names of the data sets.
        episodes: of each data set but the demonstrations.
        calls: of the training, 50 gradient updates each.
        goals: that each policy reaches for.
        trainings: of each data set.
        seed: of demonstrations, episodes, weights and goals.
    """

    data: tuple[str, ...] = tuple(DATA_SETS)
    episodes: int = 1000
    calls: int = 400
    goals: int = 500
    trainings: int = 3
    seed: int = 0


def configure(quick: bool, seed: int) -> AugmentationConfig:
    """The full configuration, or one short training of each data set on few episodes."""
    if quick:
        return AugmentationConfig(episodes=100, calls=40, goals=20, trainings=1, seed=seed)
    return AugmentationConfig(seed=seed)


def tasks(config: AugmentationConfig) -> list[Task]:
    """A task for every training."""
    return [
        Task(
            train,
            {
                "data": data,
                "training": training,
                "episodes": config.episodes,
                "calls": config.calls,
                "goals": config.goals,
                "seed": config.seed,
            },
        )
        for training in range(config.trainings)
        for data in config.data
    ]


def train(
    *, data: str, training: int, episodes: int, calls: int, goals: int, seed: int
) -> list[Row]:
    """A row for each goal."""
    check.package("sklearn.neural_network", extra="policies")  # before episodes are made in vain
    arm = Arm.load("panda")
    own = int(np.random.default_rng([seed, training]).integers(2**31))
    shown = demonstrations(arm, np.random.default_rng(own))
    made = DATA_SETS[data](arm, shown, episodes, own)
    policy = Policy(arm, made, calls, own)
    wanted = np.random.default_rng(seed).uniform(GOALS.lower, GOALS.upper, (goals, 3))
    labels = {"data": data, "training": training, "episodes": len(made)}
    return [labels | {"goal": goal.round(4).tolist()} | reach(arm, policy, goal) for goal in wanted]


STUDY = Study(configure, tasks, report)
