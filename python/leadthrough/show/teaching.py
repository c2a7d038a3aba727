"""A live page to lead an arm by its tip, record demonstrations, and learn and correct a skill.

Each demonstration is in its file as soon as its recording ends. The arm is led inside its limits,
clear of itself and of obstacles: the tip follows a target with a short lag, as fast as the joints
may move; where something is in its path it slides along or stops.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from shlex import quote
from typing import Any, ClassVar

import numpy as np

from leadthrough import check, rotations
from leadthrough.arm import Arm, check_arm
from leadthrough.check import Float64Array, InvalidInput
from leadthrough.motion import Demonstration, Event, JointTrajectory
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.show.animation import link_motion
from leadthrough.show.lesson import Learned, learned, plan_command
from leadthrough.show.live_session import Handler, LivePage, LiveSession, vector
from leadthrough.show.recordings import Recordings, recording_of

# A closed page or a busy computer must not let the arm jump, s.
_MAX_STEP = 0.1
_OPEN, _CLOSE = "open gripper", "close gripper"  # events
# Time in which the tip comes nearer to its target by a factor of e, s: a pointer's jitter is gone.
_LAG = 0.06
_MAX_SPEED = 0.6  # m/s, of a tip that is led by hand
_MAX_TURN = 1.5  # rad/s
# Fraction of the joints' velocity limits at which the arm is led.
_OF_LIMITS = 0.9
# An inverse kinematics that answers with farther joints has changed to another branch, rad.
_MAX_JUMP = 0.4
# Parts of a blocked step that are tried in turn: along obstacles, and less of it.
_PARTS = np.array(
    [(1, 1, 1), (1, 1, 0), (0, 0, 1), (1, 0, 1), (0, 1, 1), (1, 0, 0), (0, 1, 0), (0.3, 0.3, 0.3)]
)
_FULL_POSE = 6  # joints; with fewer, the orientation is left free
_CANDIDATES, _SHORT_LIST = 2000, 60
# Of the tip at the first configuration, as fractions of the largest coordinate that it can have.
_IN_FRONT, _ABOVE = 0.5, 0.15
_DOWN = np.array([0.0, 1.0, 0.0, 0.0])  # w, x, y, z


def teach(
    arm: Arm,
    scene: SceneLike = (),
    *,
    folder: str | Path = "recorded",
    demonstrations: Sequence[Demonstration[JointTrajectory]] = (),
    port: int = 0,
) -> LivePage[Teaching]:
    """A live page on which the arm is led by its tip, served until it is closed.

    Args:
        scene: obstacles in the arm's base frame, and the margins to keep.
        folder: for the demonstrations, a .csv each, of the arm's joints.
        demonstrations: joint motions that are there already.
        port: of the page; 0 picks a free one.

    Raises:
        InvalidInput: if the port is taken or the folder cannot be made.
        MissingDependency: if the extra `view` is not installed.
    """
    check_arm(arm)
    place = Path(folder)
    try:  # before anything is recorded that could not be kept
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"folder: {place} cannot be made ({error.strerror})") from None
    recordings = Recordings(arm, place, demonstrations)
    return LivePage(Teaching(arm, as_scene(scene), recordings), "teach", port)


class Teaching(LiveSession):
    """The state of a teaching page and its answers to browsers; one thread calls it."""

    def __init__(self, arm: Arm, scene: Scene, recordings: Recordings) -> None:
        super().__init__(arm, scene, demonstrations=recordings.demonstrations)
        self.recordings = recordings
        self.led = LedArm(arm, scene)
        self._text = "Press Record and lead the arm by the ring at its tip."
        self._learned = ""
        self._recording: list[tuple[float, Float64Array]] | None = None
        self._events: list[Event] = []
        self._learner = ThreadPoolExecutor(1)
        self._lesson: Future[Learned] | None = None
        self._to_save = False

    @property
    def idle(self) -> bool:
        return self._lesson is None and not self._to_save and super().idle

    def greeting(self) -> list[str]:
        scene, state = super().greeting()
        return [scene, self.led.message(), state]

    def _go_on(self, dt: float) -> None:
        step = min(dt, _MAX_STEP)
        if self.led.advance(step):
            self._messages.append(self.led.message())
        if self._recording is not None:
            self._recording.append((self._recording[-1][0] + step, self.led.q))
        super()._go_on(dt)
        if self._lesson is not None and self._lesson.done():
            self._finish(self._lesson)
        # Not before the plan is whole, whose verdict would replace what is said here.
        if super().idle:
            self._save_now()

    def left(self) -> None:
        """Keeps the recording that runs when the last browser closes the page."""
        self.led.release()
        with self._telling():
            self._stop({})

    def close(self) -> None:
        """Ends the session; a recording that runs is kept, and a skill that is to be saved."""
        super().close()
        with self._telling():
            self._save_now()
        self._learner.shutdown(wait=True, cancel_futures=True)

    def _grab(self, said: dict[str, Any]) -> None:
        """Takes the arm where the page shows it."""
        if self.motion is not None and said.get("time") is not None and self._recording is None:
            time = check.number(said["time"], "time", at_least=0.0)
            at = min(time, self.motion.duration) + float(self.motion.times[0])
            self.led.put(np.asarray(self.motion.at(at)))
            self._messages.append(self.led.message())

    def _lead(self, said: dict[str, Any]) -> None:
        self.led.lead(vector(said, "position"))

    def _turn(self, said: dict[str, Any]) -> None:
        self.led.turn(vector(said, "vector"))

    def _release(self, _: dict[str, Any]) -> None:
        self.led.release()

    def _record(self, _: dict[str, Any]) -> None:
        if self._recording is None:
            self._recording, self._events = [(0.0, self.led.q)], []
            self._say("Recording: lead the arm by the ring at its tip, then press Stop.")

    def _gripper(self, _: dict[str, Any]) -> None:
        if self._recording is None:
            self._say("The gripper closes and opens while recording.")
            return
        name = _OPEN if self._events and self._events[-1].name == _CLOSE else _CLOSE
        self._events.append(Event(self._recording[-1][0], name))
        self._say(name)

    def _stop(self, _: dict[str, Any]) -> None:
        if self._recording is None:
            return
        motion = recording_of(self.arm, self._recording, self._events)
        if motion is None:
            self._recording = None
            self._say("Nothing was recorded: the arm did not move.")
            return
        path = self.recordings.add(motion)  # the recording goes on if this cannot be written
        self._recording = None
        self._show(motion)
        self._say(f"{path} is written; record another, or press Learn.")

    def _delete(self, said: dict[str, Any]) -> None:
        name = self.recordings.remove(self.recordings.checked(said.get("index")))
        self._redraw_demonstrations(moves=False)
        self._say(f"{name} is deleted.")

    def _rename(self, said: dict[str, Any]) -> None:
        index = self.recordings.checked(said.get("index"))
        path = self.recordings.rename(index, said.get("name"))
        self._redraw_demonstrations(moves=False)
        self._say(f"It is in {path} now.")

    def _trim(self, said: dict[str, Any]) -> None:
        index = self.recordings.checked(said.get("index"))
        self._show(self.recordings.trim(index, said.get("first"), said.get("last")))
        self._say(f"{self.demonstrations[index].name} is trimmed, in its file too.")

    def _restore(self, _: dict[str, Any]) -> None:
        motion = self.recordings.restore()
        if motion is not None:
            self._show(motion)
            self._say("The last change is taken back.")

    def _play(self, said: dict[str, Any]) -> None:
        index = self.recordings.checked(said.get("index"))
        self._show(self.recordings.demonstrations[index].motion)

    def _learn(self, _: dict[str, Any]) -> None:
        given = tuple(self.demonstrations)
        if not given:
            self._say("Record a demonstration first.")
        elif self._lesson is None:
            self._lesson = self._learner.submit(learned, self.arm, given, self.scene)
            self._say("Learning ...")

    def _finish(self, lesson: Future[Learned]) -> None:
        self._lesson = None
        found = lesson.result()
        self._learned = found.text
        self.plan_with(found.planner)
        found.planner.skill.save(self.skill_path)
        self._say(found.text)

    def _save(self, _: dict[str, Any]) -> None:
        self._to_save = self.planner is not None
        if self.planner is None:
            self._say("Press Learn first.")

    def _save_now(self) -> None:
        if self.planner is None or not self._to_save:
            return
        self._to_save = False
        self.planner.skill.save(self.skill_path)
        scene = self.skill_path.with_suffix(".html")
        self.drawn.write(scene)
        self._say(f"The skill is in {self.skill_path}, this scene in {scene}.")

    def _export(self, _: dict[str, Any]) -> None:
        if not self.demonstrations:
            self._say("Record a demonstration first.")
            return
        path = self.recordings.export(self.scene)
        self._say(f"The data set is in {path}; to learn from it: {self._learn_command}")

    @property
    def skill_path(self) -> Path:
        return self.recordings.folder.parent / "skill.npz"

    @property
    def command(self) -> str:
        """The next command, which goes on with the files that are there."""
        if self.planner is not None:
            return plan_command(self.planner, self.skill_path, self.scene)
        return self._learn_command * bool(self.demonstrations)

    @property
    def _learn_command(self) -> str:
        return f"leadthrough learn {quote(str(self.recordings.source))} -o skill.npz"

    def _shown(self) -> JointTrajectory:
        resting = JointTrajectory(np.zeros(1), self.led.q[None], joint_names=self.arm.joint_names)
        return self.motion or resting

    def _place(self, scene: Scene) -> bool:
        if not self.arm.is_clear(self.led.q, scene):
            self._say("The arm is there; lead it away first.")
            return False
        self.scene = self.led.scene = scene
        return True

    def _worded(self, verdict: str, how: str) -> str:  # noqa: ARG002 (pages that only look have it)
        return f"{self._learned} {verdict[:1].upper()}{verdict[1:]}"

    def _facts(self) -> dict[str, Any]:
        return {
            "recording": self._recording is not None,
            "demonstrations": self.recordings.listed(),
            "shown": [i for i, e in enumerate(self.demonstrations) if e.motion is self.motion],
            "restorable": self.recordings.former is not None,
            "command": self.command,
        }

    def _show(self, motion: JointTrajectory) -> None:
        self.motion = motion
        self._redraw_demonstrations(moves=True)

    _HANDLERS: ClassVar[Mapping[str, Handler]] = {
        **LiveSession.HANDLERS, "grab": _grab, "lead": _lead, "turn": _turn, "release": _release,
        "record": _record, "gripper": _gripper, "stop": _stop, "delete": _delete, "play": _play,
        "rename": _rename, "trim": _trim, "restore": _restore, "export": _export,
        "learn": _learn, "save": _save,
    }  # fmt: skip


class LedArm:
    """The configuration of an arm and the target that its tip follows."""

    def __init__(self, arm: Arm, scene: Scene) -> None:
        self.arm, self.scene = arm, scene
        self.q = first_configuration(arm, scene)
        self.blocked = ""  # the reason why the tip does not follow its target
        self._target: tuple[Float64Array, Float64Array] | None = None

    @property
    def tip(self) -> tuple[Float64Array, Float64Array]:
        """Position (3,) and orientation (4,) of the tip."""
        return self.arm.forward_kinematics(self.q)

    def lead(self, position: Float64Array) -> None:
        """Sets the position that the tip follows."""
        self._target = position, (self._target or self.tip)[1]

    def turn(self, vector: Float64Array) -> None:
        """Turns the target by a rotation vector (3,) in the base frame."""
        position, orientation = self._target or self.tip
        turned = rotations.compose(rotations.exp(vector[None]), orientation[None])[0]
        self._target = position, turned

    def message(self) -> str:
        """Poses of the links, and the reason why the tip does not follow, for the page."""
        _, positions, orientations = link_motion(self.arm, self.q[None])
        poses = np.concatenate([positions, orientations], axis=2).ravel().round(5).tolist()
        return json.dumps({"kind": "poses", "poses": poses, "why": self.blocked})

    def release(self) -> None:
        """The tip stays where it is."""
        self._target, self.blocked = None, ""

    def put(self, q: Float64Array) -> None:
        """Takes a configuration (joints,) without a motion."""
        self.release()
        self.q = np.clip(q, self.arm.limits.lower, self.arm.limits.upper)

    def advance(self, dt: float) -> bool:
        """Follows the target for dt s; whether the arm moved."""
        if self._target is None:
            return False
        near = 1.0 - math.exp(-dt / _LAG)
        position, orientation = self.tip
        step = near * (self._target[0] - position)
        step *= min(1.0, _MAX_SPEED * dt / (float(np.linalg.norm(step)) or 1.0))
        back = rotations.inverse(orientation[None])
        turn = near * rotations.log(rotations.compose(self._target[1][None], back))[0]
        turn *= min(1.0, _MAX_TURN * dt / (float(np.linalg.norm(turn)) or 1.0))
        before, self.blocked = self.q, ""
        self.q = self._stepped(position, orientation, step, turn, dt)
        return not np.array_equal(before, self.q)

    def _stepped(
        self, position: Float64Array, orientation: Float64Array, step: Float64Array,
        turn: Float64Array, dt: float,
    ) -> Float64Array:  # fmt: skip
        """The configuration after the largest part of a step that the arm can make."""
        for part in _PARTS:
            turned = rotations.compose(rotations.exp(part.min() * turn[None]), orientation[None])[0]
            q = self._solved(position + part * step, turned, dt)
            if q is not None:
                return q
        return self.q

    def _solved(
        self, position: Float64Array, orientation: Float64Array, dt: float
    ) -> Float64Array | None:
        """A clear configuration at a pose, or on the way there; None if there is none nearby."""
        free = len(self.arm.joint_names) < _FULL_POSE
        found = self.arm.inverse_kinematics(position, None if free else orientation, q0=self.q)
        move = found.q - self.q
        if not found.success or np.abs(move).max() > _MAX_JUMP:
            limits = " and ".join(found.limiting_joints)
            self.blocked = f"{limits}: at its limit" if limits else "out of reach"
            return None
        most = float((np.abs(move) / (_OF_LIMITS * self.arm.limits.velocity * dt)).max())
        q = self.q + move / max(most, 1.0)
        edge = JointTrajectory(
            np.array([0.0, 1.0]), np.stack([self.q, q]), joint_names=self.arm.joint_names
        )
        if not self.arm.is_clear(edge, self.scene):
            self.blocked = "an obstacle or the arm itself is in the way"
            return None
        return q


def first_configuration(arm: Arm, scene: Scene) -> Float64Array:
    """A clear configuration (joints,) with room to lead the tip, in front of the base."""
    low, high = _bounds(arm)
    random = np.random.default_rng(0).uniform(0.15, 0.85, (_CANDIDATES, len(low)))
    rows = low + random * (high - low)
    best = rows[np.argsort(-_worth(arm, rows))][:_SHORT_LIST]
    tips = arm.forward_kinematics(best)[0]
    down = [arm.inverse_kinematics(p, _DOWN, q0=q) for p, q in zip(tips, best, strict=True)]
    listed = np.array([each.q for each in down if each.success] or best)
    ranked = listed[np.argsort(-_worth(arm, listed))]
    clear = ranked[np.asarray(arm.is_clear(ranked, scene))]
    return np.asarray(clear[0] if len(clear) else ranked[0])


def _bounds(arm: Arm) -> tuple[Float64Array, Float64Array]:
    return arm.limits.lower.clip(-math.pi, math.pi), arm.limits.upper.clip(-math.pi, math.pi)


def _worth(arm: Arm, q: Float64Array) -> Float64Array:
    """How well the tip can be led from configurations (n, joints), in m per rad or less."""
    tips = arm.forward_kinematics(q)[0]
    extent = float(np.abs(tips).max())
    room = np.linalg.svd(arm.jacobian(q)[:, :3], compute_uv=False)[:, -1]
    low, high = _bounds(arm)
    apart = np.minimum(q - low, high - q) / np.maximum(high - low, 1e-9)
    in_front = np.maximum(1.0 - 2.0 * np.abs(tips[:, 0] / extent - _IN_FRONT), 0.05)
    aside = 1.0 - np.minimum(np.abs(tips[:, 1]) / extent, 0.9)
    above = np.where(tips[:, 2] > _ABOVE * extent, 1.0, 0.1)
    return np.asarray(room * np.minimum(4.0 * apart.min(axis=1), 1.0) * in_front * aside * above)
