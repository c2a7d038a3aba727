"""A small policy of the real lerobot package, whose chunks come late, on a simulated arm.

Three demonstrations become episodes (`lt.augment`), which LeRobot's own reader reads; its ACT is
trained on them as a policy of states. Then it moves a simulated Panda to goals that it has not
seen. Each chunk arrives some time after its observation and passes a pipeline of LeRobot's with
`ChunkStep`, once a millisecond; beside it the actions as they come, each held for its period. Run
by ./do lerobot, which writes lerobot-results/figures.json.
"""

from __future__ import annotations

import json
import sys
import time
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import lerobot
import numpy as np
import torch
from lerobot.policies.act.configuration_act import ACTConfig
from lerobot.policies.act.modeling_act import ACTPolicy
from lerobot.policies.factory import make_pre_post_processors
from lerobot.processor.pipeline import DataProcessorPipeline

import leadthrough as lt
from leadthrough.guard import CommandedState
from leadthrough.guard.lerobot import ChunkStep
from leadthrough.simulation import SimulatedArm

try:
    from lerobot.datasets.utils import dataset_to_policy_features
except ImportError:  # since 0.6
    from lerobot.utils.feature_utils import dataset_to_policy_features
from lerobot.datasets.lerobot_dataset import LeRobotDataset

RATE, LOOP = 30, 1000  # Hz, of the policy's actions and of the arm
CHUNK = 45  # actions
EPISODES, LEFT_OUT = 200, 10
FRAMES, STEPS, BATCH = 5000, 4000, 64  # of the training
DELAYS = (0.0, 0.15, 0.8)  # s from an observation to its chunk
DURATION = 4.0  # s
REACHED = 0.03  # m
STATE, GOAL, ACTION = "observation.state", "observation.environment_state", "action"
HOME = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7])


class Task(NamedTuple):
    """A reach, and the time in s from an observation to its chunk."""

    goal: Any
    start: Any
    delay: float


def main(folder: Path) -> int:
    """Prints a line and writes a row for each method and delay; 0 if ours keeps all limits."""
    warnings.simplefilter("ignore")
    torch.manual_seed(0)
    torch.set_num_threads(1)
    arm = lt.Arm.load("panda")
    data = folder / "episodes"
    if not data.exists():
        made = lt.augment(_skill(arm), arm, episodes=EPISODES, out=data, goals=_goals(arm))
        print(made)
    steps = [i / RATE for i in range(CHUNK)]
    episodes = LeRobotDataset("local/reach", root=data, delta_timestamps={ACTION: steps})
    print(f"lerobot {lerobot.__version__} reads {episodes.num_episodes} episodes")
    policy = _trained(episodes)
    goals, starts = _ends(episodes)
    rows = []
    for delay in DELAYS:
        for method in (_as_they_come, _through_a_chunk_step):
            runs = [
                _run(arm, policy, Task(goal, start, delay), method)
                for goal, start in zip(goals, starts, strict=True)
            ]
            rows.append({"method": method.__name__.strip("_"), "delay": delay, **_summary(runs)})
            print(rows[-1])
    (folder / "figures.json").write_text(
        json.dumps({"lerobot": lerobot.__version__, "rows": rows}, indent=2)
    )
    ours = [row for row in rows if row["method"] == "through_a_chunk_step"]
    return int(any(row["largest_use"] > 1.0 + 1e-6 for row in ours))


def _skill(arm: lt.Arm) -> Any:
    phase = np.linspace(0.0, 1.0, 51)
    rise = lt.trajectories.minimum_jerk_time_scaling(phase)[:, None]
    turn = np.array([0.6, 0.4, 0.0, 0.3, 0.0, 0.1, 0.2])
    shown = [
        lt.JointTrajectory(3.0 * phase, HOME + rise * (turn + more), joint_names=arm.joint_names)
        for more in (-0.05, 0.0, 0.05)
    ]
    return lt.DMP().fit([arm.poses(each) for each in shown])


def _goals(arm: lt.Arm) -> Any:
    middle = _skill(arm).generate().positions[-1]
    return lt.validation.TargetRegion.around(middle, (0.12, 0.12, 0.08))


def _trained(episodes: Any) -> tuple[Any, Any, Any]:
    """The policy, and what LeRobot does before and after it."""
    features = dataset_to_policy_features(episodes.meta.features)
    config = ACTConfig(
        input_features={name: features[name] for name in (STATE, GOAL)},
        output_features={ACTION: features[ACTION]},
        chunk_size=CHUNK,
        n_action_steps=CHUNK,
        dim_model=64,
        n_heads=4,
        dim_feedforward=256,
        n_encoder_layers=2,
        use_vae=False,
        device="cpu",
    )
    policy = ACTPolicy(config)
    before, after = make_pre_post_processors(config, dataset_stats=episodes.meta.stats)
    policy.train()
    optimizer = torch.optim.AdamW(policy.parameters(), lr=1e-3)
    frames = _frames(episodes)
    for step in range(STEPS):
        some = torch.randint(len(frames[ACTION]), (BATCH,))
        loss, _ = policy.forward(before({name: rows[some] for name, rows in frames.items()}))
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        if step % 500 == 0:
            print(f"step {step}: loss {loss.item():.3f}")
    policy.eval()
    return policy, before, after


def _frames(episodes: Any) -> dict[str, Any]:
    """Some frames of the episodes to train on, as LeRobot reads them, with the actions ahead."""
    known = int(episodes.meta.episodes["dataset_from_index"][EPISODES - LEFT_OUT])
    some = [episodes[int(i)] for i in torch.randperm(known)[:FRAMES]]
    names = (STATE, GOAL, ACTION, f"{ACTION}_is_pad")
    return {name: torch.stack([frame[name] for frame in some]) for name in names}


def _ends(episodes: Any) -> tuple[Any, Any]:
    """Goals and first joints of the episodes that were left out."""
    about = episodes.meta.episodes
    first = [int(i) for i in about["dataset_from_index"][EPISODES - LEFT_OUT :]]
    rows = [episodes.hf_dataset[i] for i in first]
    return [np.array(row[GOAL]) for row in rows], [np.array(row[STATE]) for row in rows]


def _run(arm: lt.Arm, policy: Any, task: Task, method: Any) -> dict[str, Any]:
    """One reach, with an observation half a second after the last chunk was asked for."""
    robot = SimulatedArm(arm, task.start, rate=LOOP)
    follow = method(arm, robot)
    asked, waiting, sent, calls = -1.0, None, [np.array(task.start)], []
    for _ in range(round(DURATION * LOOP)):
        if waiting is None and robot.time >= asked + 0.5:
            asked = robot.time
            waiting = asked, _chunk(policy, robot.q, task.goal)
        chunk = None
        if waiting is not None and robot.time >= waiting[0] + task.delay:
            chunk, waiting = waiting, None
        begin = time.perf_counter()
        command = follow(chunk)
        calls.append(time.perf_counter() - begin)
        sent.append(np.array(command.q))
        robot.step(command)
    tip = arm.forward_kinematics(robot.q)[0]
    q = np.array(sent)
    limits = (arm.limits.velocity, arm.limits.acceleration, 7.0 / 6.0 * arm.limits.jerk)
    uses = [np.abs(np.diff(q, k, axis=0)) * LOOP**k / limits[k - 1] for k in (1, 2, 3)]
    return {
        "missed": float(np.linalg.norm(tip - task.goal[:3])),
        "uses": [float(use.max()) for use in uses],
        "p99": float(np.quantile(calls, 0.99)),
    }


def _chunk(policy: Any, q: Any, goal: Any) -> Any:
    """Actions (n, joints) for an observation."""
    network, before, after = policy
    seen = {STATE: torch.tensor(q, dtype=torch.float32), GOAL: torch.tensor(goal).float()}
    with torch.no_grad():
        return after(network.predict_action_chunk(before(seen)))[0].numpy().astype(float)


def _through_a_chunk_step(arm: lt.Arm, robot: Any) -> Any:
    chunks = lt.guard.Chunks(lt.Guard(arm, rate=float(LOOP)), rate=float(RATE))
    step = ChunkStep(chunks, unit="radians", clock=lambda: robot.time)
    pipeline = DataProcessorPipeline(
        steps=[step], to_transition=lambda data: data, to_output=lambda data: data
    )
    keys = [f"{name}.pos" for name in arm.joint_names]

    def follow(chunk: Any) -> Any:
        pipeline(
            {
                "observation": dict(zip(keys, robot.q, strict=True)),
                "action": None if chunk is None else dict(zip(keys, chunk[1].T, strict=True)),
                "complementary_data": {} if chunk is None else {"observed_at": chunk[0]},
            }
        )
        return chunks.guard.state

    return follow


def _as_they_come(arm: lt.Arm, robot: Any) -> Any:
    """Each action as a command for its period, from the first one of a chunk when that arrives."""
    now: dict[str, Any] = {"chunk": None, "came": 0.0}
    still = np.zeros(len(arm.joint_names))

    def follow(chunk: Any) -> Any:
        if chunk is not None:
            now.update(chunk=chunk[1], came=robot.time)
        if now["chunk"] is None:
            return CommandedState(robot.q, still, still)
        number = min(int((robot.time - now["came"]) * RATE), len(now["chunk"]) - 1)
        q = np.clip(now["chunk"][number], arm.limits.lower, arm.limits.upper)
        return CommandedState(q, still, still)

    return follow


def _summary(runs: list[dict[str, Any]]) -> dict[str, float]:
    missed = [run["missed"] for run in runs]
    return {
        "reached": sum(each < REACHED for each in missed) / len(runs),
        "median_missed_mm": 1e3 * float(np.median(missed)),
        "largest_use": max(max(run["uses"]) for run in runs),
        "p99_call_us": 1e6 * max(run["p99"] for run in runs),
    }


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
