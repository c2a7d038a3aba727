"""An arm in simulation that takes a command every period, as a real one does."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

import leadthrough._core as core
from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array, ShortRepr
from leadthrough.guard import CommandedState
from leadthrough.shapes import SceneLike, as_scene
from leadthrough.simulation.controllers import ComputedTorque, Controller, Law, Moment, Motion
from leadthrough.simulation.drives import RUNAWAY, Disturbances, RunawayError, drives_of
from leadthrough.simulation.model import LINK, plant

# Rate of a mode times the step: a joint let go then errs by at most 2 % of its displacement.
MAX_CHANGE = 0.2
_MAX_STEPS = 50  # a period; faster loops are unstable by their controller's period
_ROUNDING = 1e-6  # steps: rates of default gains are multiples of the bound
_ALONG = 11  # fractions of the path, for gains that change along it


# With the mass matrix M, stiffness K and damping D of all dampers, each mode of M^-1 K has a
# natural frequency w and a damping rate d. It changes at the rate w, or where it is overdamped at
# that of its slower pole, d/2 - sqrt(d^2/4 - w^2). The faster pole is of the drives' dampers, which
# act at the end of a step and so are stable at any. Damping that the controller computes is held
# for a period, and counts with its full rate.
def steps_per_period(
    law: Law, q: Float64Array, mass: Float64Array, damping: Float64Array, *, period: float
) -> int:
    """The least number of steps in which no mode changes by more than `MAX_CHANGE` each."""
    rates = _rates(law, q, mass, damping)
    if not np.isfinite(rates).all():
        return _MAX_STEPS
    least = math.ceil(period * float(rates.max()) / MAX_CHANGE - _ROUNDING)
    return min(max(least, 1), _MAX_STEPS)


def _rates(law: Law, q: Float64Array, mass: Float64Array, damping: Float64Array) -> Float64Array:
    """Rates (n, joints) of the modes, 1/s, at fractions of the path."""
    still = np.zeros((_ALONG, len(q)))
    everywhere = np.tile(mass, (_ALONG, 1, 1))
    gains = law.gains(Motion(still + q, everywhere, still, still, np.linspace(0.0, 1.0, _ALONG)))
    back = np.linalg.inv(np.linalg.cholesky(mass))
    with np.errstate(over="ignore", invalid="ignore"):
        stiffness = back @ gains.stiffness @ back.T
    if not np.isfinite(stiffness).all():
        return np.asarray(stiffness)
    squares, modes = np.linalg.eigh(stiffness)
    held = _along(modes, back @ gains.damping @ back.T)
    rest = _along(modes, back @ np.diag(damping + law.drive_damping) @ back.T)
    frequency, half = np.sqrt(np.maximum(squares, 0.0)), 0.5 * (held + rest)
    slower = half - np.sqrt(np.maximum(half**2 - frequency**2, 0.0))
    return np.asarray(np.maximum(np.where(half > frequency, slower, frequency), held))


def _along(modes: Float64Array, matrices: Float64Array) -> Float64Array:
    """Entries (n, joints) of symmetric matrices for modes in the columns of (n, joints, joints)."""
    return np.asarray(
        np.einsum("nji,njk,nki->ni", modes, np.broadcast_to(matrices, modes.shape), modes)
    )


@dataclass(frozen=True, eq=False)
class Touch(ShortRepr):
    """Two bodies that touch.

    Attributes:
        bodies: links by name, "attached", or "obstacle" with its index.
        force: of all their contact points together, N.
    """

    bodies: tuple[str, str]
    force: float


class SimulatedArm(ShortRepr):
    """An arm under gravity and a controller that takes a command every period.

        real = lt.simulation.SimulatedArm(arm, q)
        while running:
            real.step(guard.next())
            print(real.q)

    Its model is made from the arm's own URDF: masses, inertias, joint limits, friction, collision
    shapes and the highest torques. The controller knows the same arm, but nothing of the
    disturbances. Equal calls have equal answers.

    `steps` is the number of physics steps in a period, from the gains and inertias at the start.

    Args:
        arm: the arm.
        state: its first: positions (joints,) at rest, or a `CommandedState`.
        scene: obstacles in the base frame; the margins are not used.
        controller: makes torques of the commands.
        disturbances: rotors, and the load, friction, delay, encoders and pushes that the controller
            does not know; by default those of a real arm.
        gravity: acceleration (3,) of gravity in the base frame, m/s^2; by default `arm.gravity`.
        rate: commands per second, 100 to 1e4.

    Raises:
        InvalidInput: if a payload is changed of an arm that carries none.
        InvalidRobot: if the URDF states no masses, or no bodies have its inertias.
        MissingDependency: if the extra `simulation` is not installed.
    """

    def __init__(
        self,
        arm: Arm,
        state: CommandedState | ArrayLike,
        scene: SceneLike = (),
        *,
        controller: Controller | None = None,
        disturbances: Disturbances | None = None,
        gravity: ArrayLike | None = None,
        rate: float = 1000.0,
    ) -> None:
        self._mujoco = check.package("mujoco", extra="simulation")
        self.arm = arm
        self.period = 1.0 / check.number(rate, "rate", at_least=100.0, at_most=1e4)
        pull = check.array(arm.gravity if gravity is None else gravity, "gravity", shape=(3,))
        unknown = Disturbances() if disturbances is None else disturbances
        self.drives = drives_of(arm, unknown, self.period)
        start = _started(state, len(arm.joint_names))
        self.law = (ComputedTorque() if controller is None else controller).law(
            arm, start.q, gravity=pull, rotors=self.drives.rotors
        )
        self.plant = plant(
            arm,
            as_scene(scene).shapes,
            motors=self.drives,
            drive_damping=self.law.drive_damping,
            gravity=pull,
            period=self.period,
        )
        self._choose_step(start.q)
        self._begin(start)

    def _choose_step(self, q: Float64Array) -> None:
        model, joints = self.plant.model, self.plant.joints
        mass = self.arm.mass_matrix(q) + np.diag(model.dof_armature[joints])
        self.steps = steps_per_period(self.law, q, mass, self.drives.damping, period=self.period)
        model.opt.timestep = self.period / self.steps

    def _begin(self, start: CommandedState) -> None:
        self.data: Any = self._mujoco.MjData(self.plant.model)
        self.data.qpos[:] = self.plant.coordinates(start.q)
        for i, (joint, factor, _) in enumerate(self.plant.drives):
            self.data.qvel[i] = factor * start.qd[joint]
        self._connect(start)
        self._mujoco.mj_forward(self.plant.model, self.data)

    def _connect(self, start: CommandedState) -> None:
        """Lets the drives act on the model as it is now."""
        own, plant, law = self.drives, self.plant, self.law
        self._start = start
        data, motors = self.data, plant.motors
        ranges = plant.model.actuator_forcerange[motors]
        self._core = core.Drives(
            np.array([own.encoder, own.rotors, law.fed_forward, own.effort, law.drive_damping]),
            own.late,
            self.period,
            self.steps,
            RUNAWAY,
            _rows(start),
            plant.joints,
            (data.qpos, data.qvel, data.ctrl[motors], ranges, data.actuator_force[motors]),
        )
        self._asked = law.kernel if law.kernel and not own.pushes else self._by_hand

    def _share(self, model: Any, data: Any, prefix: str, steps: int) -> None:
        """Moves into a model with more bodies, in which its names have a prefix."""
        first = prefix + self.arm.joint_names[0]
        shift = model.joint(first).dofadr[0] - self.plant.joints[0]
        own = slice(shift, shift + len(self.data.qpos))
        data.qpos[own], data.qvel[own] = self.data.qpos, self.data.qvel
        motor = model.actuator(first).id
        self.plant = replace(
            self.plant,
            model=model,
            joints=self.plant.joints + shift,
            tip=model.body(prefix + LINK + self.arm.tip).id,
            motors=slice(motor, motor + len(self.arm.joint_names)),
        )
        self.data, self.steps = data, steps
        self._connect(self._start)

    @property
    def torques(self) -> Float64Array:
        """Torques behind the gears during the last period (joints,), N m (N)."""
        return np.asarray(self._core.torques)

    @property
    def demanded(self) -> Float64Array:
        """Torques that the controller asked for in it (joints,), N m (N)."""
        return np.asarray(self._core.demanded)

    @property
    def time(self) -> float:
        """Since the start, s."""
        return self._core.ticks * self.period

    @property
    def q(self) -> Float64Array:
        """Joint positions (joints,), rad (m)."""
        return np.array(self.data.qpos[self.plant.joints])

    @property
    def qd(self) -> Float64Array:
        """Joint velocities (joints,), rad/s (m/s)."""
        return np.array(self.data.qvel[self.plant.joints])

    @property
    def touches(self) -> list[Touch]:
        """Contacts at the beginning of the last step, one entry for each pair of bodies."""
        if self.data.ncon == 0:
            return []
        return _touches(self._mujoco, self.plant.model, self.data)

    def step(self, command: CommandedState, *, progress: float = 0.0) -> Float64Array:
        """Advances by one period, with a command for its end.

        Args:
            command: as `Guard.next` returns it: the acceleration is that of this period.
            progress: fraction of its path that the tip has gone, for controllers whose gains change
                along it.

        Returns:
            Where the joints are then (joints,), rad (m).

        Raises:
            FloatingPointError: if a joint runs away: the gains are too high for the rate.
        """
        for _ in self._period(_rows(command), progress):
            self._mujoco.mj_step(self.plant.model, self.data)
        return self.q

    def _period(self, command: Float64Array, progress: float) -> Iterator[None]:
        """A period with a command (3, joints); its user lets the physics make a step each time."""
        self._stop_runaway(self._core.begin(command, progress, self._asked))
        for i in range(self.steps):
            self._core.act(i)
            yield
            self._stop_runaway(self._core.advance())
        self._core.end()

    def _stop_runaway(self, joint: int) -> None:
        if joint >= 0:
            raise RunawayError(self.arm.joint_names[joint], self.time, joint)

    def _by_hand(self, *moment: Any) -> Float64Array:
        """The torques of a law that is not the core's, or of one whose arm is pushed."""
        q, qd, qdd, *measured = moment
        if self.drives.pushes:
            self._push()
        target = check.computed(CommandedState, q=q, qd=qd, qdd=qdd)
        return self.law.torques(Moment(target, *measured))

    def _run(
        self, commands: tuple[Float64Array, ...], touched: Callable[[int], None], most: int
    ) -> tuple[Any, ...]:
        """A motion as the core records it, until so many periods after bodies first touch."""
        model, data, physics = self.plant.model, self.data, self._mujoco.mj_step

        def step() -> bool:
            physics(model, data)
            return bool(data.ncon)

        q, qd, qdd, progress = commands
        return self._core.run(q, qd, qdd, progress, self._asked, step, touched, most)

    def _push(self) -> None:
        body = self.plant.tip
        force = np.zeros(3)
        for push in self.drives.pushes:
            if push.time <= self.time < push.time + push.duration:
                force += np.asarray(push.force)
        turned = self.data.xmat[body].reshape(3, 3)
        tip = self.data.xpos[body] + turned @ self.arm.tool[0]
        self.data.xfrc_applied[body, :3] = force
        self.data.xfrc_applied[body, 3:] = np.cross(tip - self.data.xipos[body], force)


def _started(state: CommandedState | ArrayLike, joints: int) -> CommandedState:
    if isinstance(state, CommandedState):
        rows = (
            check.array(row, "state", shape=(joints,)) for row in (state.q, state.qd, state.qdd)
        )
        return CommandedState(*rows)
    q = check.array(state, "state", shape=(joints,))
    return CommandedState(q, np.zeros(joints), np.zeros(joints))


def _rows(state: CommandedState) -> Float64Array:
    return np.array([state.q, state.qd, state.qdd])


def _touches(mujoco: Any, model: Any, data: Any) -> list[Touch]:
    forces: dict[tuple[str, str], Float64Array] = {}
    wrench = np.zeros(6)
    for i in range(data.ncon):
        contact = data.contact[i]
        # The base comes first and obstacles last, as in collision reports.
        bodies = sorted(int(model.geom_bodyid[geom]) for geom in contact.geom)
        a, b = (model.body(body).name.removeprefix(LINK) for body in bodies)
        pair, sign = (a, b), 1.0 if model.geom_bodyid[contact.geom[0]] == bodies[0] else -1.0
        mujoco.mj_contactForce(model, data, i, wrench)
        force = sign * contact.frame.reshape(3, 3).T @ wrench[:3]
        forces[pair] = forces.get(pair, np.zeros(3)) + force
    return [Touch(pair, float(np.linalg.norm(force))) for pair, force in forces.items()]
