"""A hand pushes a compliant arm off its path: from then on the skill goes where the hand wants it.

Writes pushed.html: python python/demos/47_correct_by_push.py [FOLDER]
Needs the extra `simulation`.
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt

folder = Path(sys.argv[1] if len(sys.argv) > 1 else ".")
arm = lt.Arm.load("panda")
home, away = np.array([-0.5, -0.4, 0.0, -2.1, 0.0, 1.7, 0.7]), [1.1, 0.3, 0, 0.2, 0, 0, 0]
way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
times = np.linspace(0.0, 3.0, 101)
shown = lt.JointTrajectory(times, home + np.outer(way, away), joint_names=arm.joint_names)
skill = lt.DMP().fit([arm.poses(shown)])


def tip(q):
    return arm.forward_kinematics(q)[0]


def run(skill, pushes=()):
    """The simulated arm, soft in its joints, plays the skill; where it was pushed to."""
    motion = lt.keep_timing(arm.follow(skill.generate()), arm.limits, rate=1000.0)
    play = lt.guard.Playback(motion, arm.limits, rate=1000.0)
    real = lt.simulation.SimulatedArm(
        arm,
        motion.positions[0],
        controller=lt.simulation.JointImpedance(),
        disturbances=lt.simulation.Disturbances(pushes=pushes),
    )
    guard = lt.Guard(arm, rate=1000.0)
    guard.admit(real.q[None], state=real.q)
    while not play.done:
        guard.admit(play.next(measured=real.q)[None])
        real.step(guard.next())
    return play.push


push = run(skill, [lt.simulation.Push(1.2, (0.0, 0.0, 60.0), 0.5)])
wanted = tip(push.measured)
corrected = skill.corrected(tip(push.commanded), wanted)
print(f"pushed {1e3 * np.linalg.norm(wanted - tip(push.commanded)):.0f} mm at {push.time:.2f} s")
for name, each in {"before": skill, "corrected": corrected}.items():
    gap = np.linalg.norm(each.generate().positions - wanted, axis=1).min()
    print(f"{name}: {1e3 * gap:.1f} mm from where the hand held the tip")
before = [lt.Demonstration(skill.generate(), "before")]
lt.show.view(arm, corrected.generate(), demonstrations=before, html=folder / "pushed.html")
print(f"wrote {folder / 'pushed.html'}")
