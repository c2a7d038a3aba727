"""Arms that take a command every period: simulated, from Universal Robots, and from Franka.

Each has `rate`, Hz; `q`, where its joints are; `send`, which waits for the period to end;
`report`, what it knows of its errors; and `close`. The simulated one is what the tests run. The two
others have not been run on hardware: the tests look at their calls only. Keep the emergency stop at
hand, and begin with a low speed.
"""

import numpy as np


class Simulated:
    """An arm in MuJoCo (extra `simulation`)."""

    rate = 1000.0

    def __init__(self, arm, q, obstacles=()):
        from leadthrough.simulation import SimulatedArm

        self._arm = SimulatedArm(arm, q, obstacles, rate=self.rate)
        self.largest_error = 0.0

    @property
    def q(self):
        return self._arm.q

    @property
    def report(self):
        return f"off by at most {1e3 * self.largest_error:.2f} mrad"

    def send(self, state):
        error = state.q - self._arm.step(state)
        self.largest_error = max(self.largest_error, float(np.abs(error).max()))

    def close(self):
        """Nothing to close."""


class UniversalRobot:
    """A UR arm, by ur_rtde (pip install ur-rtde). Not run on hardware."""

    report = "errors are not measured"

    def __init__(self, host, rate=500.0):  # a CB3 takes 125 commands per second
        from rtde_control import RTDEControlInterface
        from rtde_receive import RTDEReceiveInterface

        self.rate = rate
        self._receive = RTDEReceiveInterface(host)
        self._control = RTDEControlInterface(host, rate)
        self._begun = self._control.initPeriod()

    @property
    def q(self):
        return np.array(self._receive.getActualQ())

    def send(self, state):
        # Speed and acceleration are not used by servoJ; 0.03 s ahead and gain 2000 lag the least.
        self._control.servoJ(state.q.tolist(), 0.0, 0.0, 1.0 / self.rate, 0.03, 2000.0)
        self._control.waitPeriod(self._begun)
        self._begun = self._control.initPeriod()

    def close(self):
        self._control.servoStop()
        self._control.stopScript()


class Franka:
    """A Panda or FR3, by panda_py (pip install panda-python). Not run on hardware."""

    rate = 1000.0
    report = "errors are not measured"

    def __init__(self, host):
        import panda_py
        from panda_py import controllers

        self._panda = panda_py.Panda(host)
        self._follower = controllers.JointPosition()
        self._panda.start_controller(self._follower)
        self._context = self._panda.create_context(frequency=self.rate)
        self._context.__enter__()

    @property
    def q(self):
        return np.array(self._panda.q)

    def send(self, state):
        if not self._context.ok():  # waits for the period to end
            raise RuntimeError("the robot has stopped")
        self._follower.set_control(state.q, state.qd)

    def close(self):
        self._context.__exit__(None, None, None)
        self._panda.stop_controller()


def connect(kind, host, arm, q, obstacles):
    """An arm by its kind: "simulated" (which begins at q, among obstacles), "ur" or "franka"."""
    if kind == "simulated":
        return Simulated(arm, q, obstacles)
    return {"ur": UniversalRobot, "franka": Franka}[kind](host)
