"""Random queries of a skill on an arm: the same answers anywhere, a certificate that travels."""

import json
from dataclasses import replace

import numpy as np
import pytest
from cli.command_line import facts
from refusals import refused

import leadthrough as lt
from leadthrough.errors import InvalidInput
from leadthrough.shapes import RandomObstacle
from leadthrough.tasks import Execution
from leadthrough.validation import SamplingPlan, TargetRegion

SPHERE = lt.Sphere(0.06, (0.45, 0.15, 0.55))
WORLD = RandomObstacle(SPHERE, (0.05, 0.15, 0.05))
RUNS = 24


@pytest.fixture(scope="module")
def goals(reach):
    return TargetRegion.around(reach.generate().positions[-1], (0.3, 0.3, 0.1), turn=0.2)


@pytest.fixture(scope="module")
def validation(reach, panda, goals):
    return lt.validate(reach, panda, [WORLD], goals=goals, plan=SamplingPlan(RUNS, seed=3))


def test_each_query_ends_in_success_or_with_a_cause(validation, goals):
    certificate = validation.certificate
    assert certificate.runs == RUNS == certificate.successes + sum(certificate.causes.values())
    assert 0 < certificate.successes < RUNS
    asked = certificate.goals
    assert all(asked.contains((goal[:3], goal[3:])) for goal in validation.goals)
    assert (asked.upper == goals.upper).all()
    assert np.ptp(validation.goals[:, :3], axis=0).min() > 0.15
    assert certificate.interval.lower < certificate.fraction < certificate.interval.upper
    assert validation.nearest.cause in certificate.causes
    assert validation.nearest.detail
    assert "queries succeed" in str(validation)


def test_processes_find_the_same_and_go_on_where_they_were(
    reach, panda, goals, validation, tmp_path
):
    asked = {"scene": [WORLD], "goals": goals, "plan": SamplingPlan(RUNS, seed=3)}
    found = lt.validate(reach, panda, **asked, execution=Execution("local:1", tmp_path))
    assert found.certificate.to_settings() == validation.certificate.to_settings()
    assert (found.goals == validation.goals).all()
    again = lt.validate(reach, panda, **asked, execution=Execution(out=tmp_path))
    assert again.certificate.to_settings() == found.certificate.to_settings()
    states = [each["state"] for each in json.loads((tmp_path / "manifest.json").read_text())]
    assert states == ["known", "known"]


def test_it_stops_as_soon_as_the_interval_is_narrow(reach, panda):
    found = lt.validate(reach, panda, plan=SamplingPlan(width=0.35)).certificate
    assert found.runs == 20
    assert found.interval.method == "confidence sequence"
    assert found.interval.upper - found.interval.lower <= 0.35


def test_the_certificate_travels_with_the_skill(reach, validation, tmp_path):
    certificate = validation.certificate
    certified = reach.certified(certificate)
    certified.save(tmp_path / "skill.npz")
    loaded = lt.load_skill(tmp_path / "skill.npz")
    assert loaded.certificate.to_settings() == certificate.to_settings()
    assert (loaded.generate().positions == reach.generate().positions).all()
    assert reach.certificate is None
    assert replace(certified, duration=2.0).certificate is None


def test_the_certificate_knows_its_queries(validation):
    certificate = validation.certificate
    middle = {"start": certificate.starts.middle, "goal": certificate.goals.middle}
    world = [SPHERE.at((0.45, 0.25, 0.55))]
    assert certificate.outside(**middle, obstacles=world, robot=certificate.scene.robot) == ()
    assert "start outside" in certificate.outside(
        start=certificate.starts.middle + 0.1, goal=middle["goal"], obstacles=world
    )[0]  # fmt: skip
    far = [SPHERE.at((0.45, 0.85, 0.55))]
    for others in ([], far, world * 2, [lt.Sphere(0.07, world[0].position)]):
        assert certificate.outside(**middle, obstacles=others) == ("other obstacles",)
    assert "another arm" in certificate.outside(**middle, obstacles=world, robot="ur3")[0]


def test_wrong_regions_are_refused(reach, panda):
    with pytest.raises(InvalidInput, match="goals: expected 3 coordinates"):
        lt.validate(reach, panda, goals=TargetRegion([0.0], [1.0]))
    refused("goal", lt.validate, reach, panda, goals=TargetRegion.around([400.0, 0.0, 300.0], 10.0))
    refused("upper", TargetRegion, [1.0], [0.0])


def test_the_command_writes_a_report_and_a_certified_skill(reach, tmp_path):
    skill, out = tmp_path / "reach.npz", tmp_path / "out"
    reach.save(skill)
    words = ("validate", skill, "--robot", "panda", "--goals", "0.02,0.02,0.02", "--runs", 4)
    found = facts(*words, "--random-obstacle", "sphere:0.03@0.1,0.6,0.6~0.1,0,0.1", "--out", out,
                  "--certify", skill)  # fmt: skip
    assert found["succeeded"] == found["queries"] == 4
    assert "<svg" in (out / "report.html").read_text()
    written = json.loads((out / "results.json").read_text())
    assert written["certificate"]["successes"] == 4
    asked = ("plan", skill, "--robot", "panda", "-o", tmp_path / "m.json")
    box = ("--obstacle", "sphere:0.03@0.12,0.6,0.6")
    assert facts(*asked, *box, "--move-goal", "0.01,0,0")["certificate"].startswith("inside: ")
    outside = facts(*asked, "--move-goal", "0.05,0,0")["certificate"]
    assert "goal outside" in outside and "other obstacles" in outside
    # Finished queries are reused; four are too few for the required rate.
    facts(*words, "--random-obstacle", "sphere:0.03@0.1,0.6,0.6~0.1,0,0.1", "--out", out,
          "--required", 0.9, code=1)  # fmt: skip


def test_each_motion_is_simulated_too_if_asked(reach, panda):
    wild = lt.simulation.ComputedTorque(frequency=2000.0)  # rad/s, at a rate of 1 kHz
    found = lt.validate(reach, panda, plan=SamplingPlan(1), rate=100.0, controller=wild)
    (cause,) = found.certificate.causes
    assert cause.startswith("simulation: ")
