"""The loop for real arms: run on the simulated one, and on stand-ins for the makers' libraries.

The stand-ins take what the libraries take, in the order in which they take it, and check it.
"""

import runpy
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest
from guard.judge import EXCESS, worst_use

import leadthrough as lt

DEMOS = Path(__file__).parents[3] / "python" / "demos"
UR_START = np.array([0.0, -1.4, 1.6, -1.8, -1.5, 0.0]) + 0.05
FRANKA_START = np.array([0.0, -0.5, 0.0, -2.0, 0.0, 1.6, 0.7]) - 0.05


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def run_loop(monkeypatch, *words):
    monkeypatch.setattr(sys, "argv", ["32_guarded_playback.py", *words])
    monkeypatch.syspath_prepend(str(DEMOS))
    return runpy.run_path(str(DEMOS / "32_guarded_playback.py"))


class URControl:
    """RTDEControlInterface of ur_rtde."""

    def __init__(self, host, frequency=-1.0):
        assert (host, frequency) == ("192.168.0.5", 500.0)
        self.period = 1.0 / frequency
        self.sent, self.begun, self.sending, self.ended = [], 0, False, []
        URControl.last = self

    def initPeriod(self):  # noqa: N802
        assert not self.sending
        self.begun += 1
        return self.begun

    def servoJ(self, q, *numbers):  # noqa: N802
        speed, acceleration, time, lookahead_time, gain = numbers
        assert not self.ended and not self.sending
        assert isinstance(q, list) and len(q) == 6 and all(type(each) is float for each in q)
        assert speed == acceleration == 0.0 and time == self.period
        assert 0.03 <= lookahead_time <= 0.2 and 100.0 <= gain <= 2000.0
        self.sending = True
        self.sent.append(q)
        return True

    def waitPeriod(self, begun):  # noqa: N802
        assert self.sending and begun == self.begun
        self.sending = False

    def servoStop(self, a=10.0):  # noqa: N802
        assert a == 10.0
        self.ended.append("servoStop")

    def stopScript(self):  # noqa: N802
        assert self.ended == ["servoStop"]
        self.ended.append("stopScript")


class Panda:
    """Panda of panda_py, with its context and its controller."""

    def __init__(self, hostname):
        assert hostname == "172.16.0.2"
        self.q = FRANKA_START
        self.sent, self.speeds, self.state = [], [], "new"
        Panda.last = self

    def start_controller(self, controller):
        assert isinstance(controller, JointPosition) and self.state == "new"
        self.state = "controlled"

    def create_context(self, frequency):
        assert frequency == 1000.0
        return self

    def __enter__(self):
        assert self.state == "controlled"
        self.state = "open"
        return self

    def __exit__(self, *_):
        self.state = "left"

    def ok(self):
        self.waited = True
        return True

    def stop_controller(self):
        assert self.state == "left"
        self.state = "stopped"


class JointPosition:
    """The controller of panda_py."""

    def set_control(self, position, velocity):
        panda = Panda.last
        assert panda.state == "open" and panda.waited
        assert position.shape == velocity.shape == (7,)
        panda.waited = False
        panda.sent.append(position.copy())
        panda.speeds.append(velocity.copy())


def assert_kept(name, start, sent, rate):
    """From where the arm was, inside all limits, clear, and at rest in the end."""
    arm = lt.Arm.load(name)
    rows = np.concatenate([start[None], sent])
    assert worst_use(rows, arm.limits, rate) <= 1.0 + EXCESS
    assert arm.check(rows, [lt.Box((2.0, 2.0, 0.05), (0.9, 0.0, -0.1))]).ok
    assert np.array_equal(rows[-1], rows[-2])
    assert np.abs(np.ptp(rows, axis=0)).min() > 0.1


def test_the_loop_runs_on_the_simulated_arm(monkeypatch, capsys):
    ended = run_loop(monkeypatch)
    assert ended["guard"].safe and not ended["guard"].state.qd.any()
    assert ended["robot"].largest_error < 0.005
    said = capsys.readouterr().out
    assert "at rest: True; certified: True" in said
    assert "speed 0.00" in said and "speed 0.50" in said and "braking" in said


def run_on_ur(monkeypatch, interface):
    control, receive = ModuleType("rtde_control"), ModuleType("rtde_receive")
    control.RTDEControlInterface = interface
    receive.RTDEReceiveInterface = lambda _: SimpleNamespace(getActualQ=UR_START.tolist)
    monkeypatch.setitem(sys.modules, "rtde_control", control)
    monkeypatch.setitem(sys.modules, "rtde_receive", receive)
    run_loop(monkeypatch, "ur", "192.168.0.5")


def test_the_calls_are_those_of_ur_rtde(monkeypatch):
    run_on_ur(monkeypatch, URControl)
    robot = URControl.last
    assert robot.ended == ["servoStop", "stopScript"]
    assert len(robot.sent) == 1000
    assert_kept("ur3", UR_START, np.array(robot.sent), 500.0)


def test_the_calls_are_those_of_panda_py(monkeypatch):
    made = ModuleType("panda_py")
    made.Panda, made.controllers = Panda, SimpleNamespace(JointPosition=JointPosition)
    monkeypatch.setitem(sys.modules, "panda_py", made)
    run_loop(monkeypatch, "franka", "172.16.0.2")
    robot = Panda.last
    assert robot.state == "stopped"
    speeds = np.array(robot.speeds)
    mean = 0.5 * (speeds[1:] + speeds[:-1])
    assert np.allclose(np.diff(robot.sent, axis=0) * 1000.0, mean, atol=2e-3)
    assert_kept("panda", FRANKA_START, np.array(robot.sent), 1000.0)


def test_the_robot_is_closed_where_the_connection_is_lost(monkeypatch):
    class Lost(URControl):
        def servoJ(self, q, *rest):  # noqa: N802
            if len(self.sent) == 20:
                raise RuntimeError("connection lost")
            return super().servoJ(q, *rest)

    with pytest.raises(RuntimeError, match="connection lost"):
        run_on_ur(monkeypatch, Lost)
    assert URControl.last.ended == ["servoStop", "stopScript"]
