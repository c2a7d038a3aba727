"""Guarded playback on an arm: pause, resume, speed override and stop.

Writes sent.json and sent.png: python python/demos/32_guarded_playback.py [FOLDER]
Needs the extra `simulation`.
On hardware, where it has not been run: 32_guarded_playback.py ur HOST, or franka HOST
"""

import sys
from pathlib import Path

import numpy as np

import leadthrough as lt
from real_arms import connect

kind, host = sys.argv[1:] if len(sys.argv) == 3 else ("simulated", "")
folder = Path(sys.argv[1] if len(sys.argv) == 2 else ".")
arm = lt.Arm.load("ur3" if kind == "ur" else "panda")
home = [0.0, -1.4, 1.6, -1.8, -1.5, 0.0] if kind == "ur" else [0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7]
table = lt.Box((2.0, 2.0, 0.05), (0.9, 0.0, -0.1))

# Half of the limits: the rest is for pausing, resuming and changing the speed on the path.
slower = {name: 0.5 * getattr(arm.limits, name) for name in ("velocity", "acceleration", "jerk")}
limits = lt.arm.JointLimits(**{**vars(arm.limits), **slower})
way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 101))
motion = lt.retime(home + np.outer(way, np.full(len(home), 0.9)), limits)

robot = connect(kind, host, arm, np.array(home) - 0.1, [table])
guard = lt.Guard(arm, [table], rate=robot.rate)
whole = lt.connect(robot.q, motion, lt.Arm.load(arm.robot.name, limits=limits), [table])
play = lt.guard.Playback(whole, arm.limits, rate=robot.rate)
answer = guard.admit(robot.q[None], state=robot.q)
sent, stopped = [guard.state], False
asked = {0.2: play.pause, 0.8: play.resume, 1.6: guard.stop}  # by a person
try:
    for tick in range(int(2.0 * robot.rate)):
        time = tick / robot.rate
        play.speed = 1.0 if time < 1.2 else 0.5
        answer = asked.get(time, lambda: None)() or answer
        stopped = stopped or answer.verdict == "braking"  # asked for, or the guard has refused
        if not stopped and not play.done:
            answer = guard.admit(play.next()[None])
        sent.append(guard.next())
        robot.send(guard.state)
        if tick % int(0.25 * robot.rate) == 0:
            print(f"{time:.2f} s: speed {play.speed_now:.2f} at {play.time:.2f} s, {answer}")
finally:
    robot.close()
print(f"at rest: {not guard.state.qd.any()}; certified: {guard.safe}; {robot.report}")
times = np.arange(len(sent)) / robot.rate
states = [[getattr(state, part) for state in sent] for part in ("q", "qd", "qdd")]
done = lt.JointTrajectory(times, *states, joint_names=arm.joint_names)
lt.write_motion(done, folder / "sent.json")
figure = done.plot()
for time, act in {**asked, 1.2: "half speed"}.items():
    figure.axes[0].axvline(time, color="0.5", linestyle=":")
    figure.axes[0].text(time, -2.4, f" {getattr(act, '__name__', act)}")
figure.savefig(folder / "sent.png", dpi=120)
print(f"wrote {folder / 'sent.json'} and {folder / 'sent.png'}")
