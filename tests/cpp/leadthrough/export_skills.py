"""Exported skills, and the motions that Python makes of them: `export_skills.py FOLDER`.

The tests of `skill.hpp` and `guard.hpp` compare their own motions with these, to the bit.
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from leadthrough.io import npz
from leadthrough_studies.example import reaches

FOLDER = Path(sys.argv[1])
TIMES = np.linspace(0.0, 2.0, 201)
RISE = lt.trajectories.minimum_jerk_time_scaling(TIMES / 2.0)
REST = np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8])  # rad, of the Panda
TURN = np.array([0.5, 0.3, -0.4, 0.2, 0.6, -0.3, 0.8])
STEPS = [0.001, 0.0007, 0.02, 0.3] * 10  # s, beyond the end too


def write(name, skill, **expected):
    skill.export(FOLDER / f"{name}.npz")
    npz.write_tables(FOLDER / f"{name}_expected.npz", "expected", expected)


def stepped_dmp(skill, start, goal, duration):
    """Positions, velocities and, of poses, orientations and angular velocities after steps."""
    state = skill.begin(start=start, goal=goal, duration=duration)
    names = ["position", "velocity"]
    if skill.orientation is not None:
        names += ["orientation", "angular_velocity"]
    rows = {name: [] for name in names}
    for dt in STEPS:
        state = skill.step(state, dt)
        for name in names:
            rows[name].append(getattr(state, name))
    flat = {"start": start, "goal": goal}
    ends = {key: np.hstack(value) for key, value in flat.items() if value is not None}
    return {"steps": STEPS, "duration": duration, **ends, **rows}


def path(*columns):
    return lt.Trajectory(
        TIMES, np.column_stack([column * np.ones_like(RISE) for column in columns])
    )


def write_dmps():
    names = lt.Arm.load("panda").joint_names
    joints = lt.JointTrajectory(TIMES, REST + np.outer(RISE, TURN), joint_names=names)
    skill = lt.DMP(weights=20).fit([joints])
    write("joints", skill, **stepped_dmp(skill, None, None, skill.duration))
    flat = lt.DMP(weights=20).fit([path(RISE, np.sin(3.0 * RISE))])
    write("points", flat, **stepped_dmp(flat, [0.1, -0.1], [1.3, 0.4], 1.7))
    turns = np.column_stack([2.0 * RISE, np.sin(3.0 * RISE), -RISE])
    poses = lt.PoseTrajectory(TIMES, turns * 0.1, lt.rotations.exp(turns))
    skill = lt.DMP(weights=20).fit([poses])
    goal = lt.rotations.exp(np.array([[0.5, 1.0, -2.0]]))[0]
    write("poses", skill, **stepped_dmp(skill, [0.0, 0.01, 0.0], ([0.3, 0.1, 0.0], goal), 3.0))


def write_promps():
    joints = [f"joint{i}" for i in range(1, 7)]
    shown = [each.motion for each in reaches(joints, seed=0)]
    skill = lt.ProMP().fit(shown)
    motion = skill.generate()
    derivatives = {"velocity": motion.velocities, "acceleration": motion.accelerations}
    write("promp", skill, times=motion.times, position=motion.positions, **derivatives)
    angle = np.pi * TIMES
    cycle = lt.ProMP(basis="rhythmic").fit([path(np.cos(angle), np.sin(angle))])
    motion = cycle.generate()
    write("rhythmic", cycle, times=motion.times, position=motion.positions)


def write_policies():
    bends = [path(RISE + 0.02 * k, np.sin(3.0 * RISE), 0.1 * RISE) for k in range(2)]
    angle = 2.0 * np.pi * RISE
    circle = [path(np.cos(angle), np.sin(angle))]
    for name, shown in (("open", bends), ("closed", circle)):
        policy = lt.FastMarching(resolution=0.04).fit(shown).policy_to()
        point = shown[0].positions[20] + 0.05
        points = [point]
        for _ in range(200):
            points.append(policy.step(points[-1], 0.01))
        write(name, policy, dt=0.01, position=points, velocity=policy(np.array(points)))


def write_guarded():
    arm = lt.Arm.load("panda")
    guard = lt.Guard(arm, [lt.Sphere(0.1, position=[0.3, 0.4, 0.4])], rate=100.0)
    wave = np.sin(np.linspace(0.0, 1.0, 30)) ** 3
    chunk = REST + 0.05 * np.outer(wave, np.ones(7))
    admission = guard.admit(chunk, state=REST)
    assert admission.verdict == "allowed", admission
    states = [guard.next() for _ in range(guard.remaining)]
    limits = {
        name: getattr(arm.limits, name)
        for name in ("lower", "upper", "velocity", "acceleration", "jerk")
    }
    rows = {name: [getattr(each, name) for each in states] for name in ("q", "qd", "qdd")}
    tables = {"q0": REST, "chunk": chunk, "rate": 100.0, **limits, **rows}
    npz.write_tables(FOLDER / "guarded.npz", "expected", tables)


FOLDER.mkdir(parents=True, exist_ok=True)
write_dmps()
write_promps()
write_policies()
write_guarded()
