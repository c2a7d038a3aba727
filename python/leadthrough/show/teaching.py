"""A live page to lead an arm by its tip, record demonstrations, and learn and correct a skill.

Each demonstration is in its file as soon as its recording ends.
"""

from __future__ import annotations

import json
import threading
import webbrowser
from collections.abc import Callable, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm, check_arm
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError, ShortRepr
from leadthrough.models.learn import learn, reproduction
from leadthrough.motion import Demonstration, Event, JointTrajectory, PoseTrajectory
from leadthrough.shapes import Scene, SceneLike, as_scene
from leadthrough.show import live_scene
from leadthrough.show.leading import LedArm
from leadthrough.show.live_scene import LAYERS, LiveScene
from leadthrough.show.private import PageServer
from leadthrough.show.recordings import Recordings, recording_of
from leadthrough.show.replanner import Answer, Replanner

_PERIOD = 0.02  # s, of the tip's steps and of recordings
# A closed page or a busy computer must not let the arm jump, s.
_MAX_STEP = 0.1
_DEMONSTRATIONS, _OBSTACLES, _PATH, _GOAL = LAYERS


def teach(
    arm: Arm,
    scene: SceneLike = (),
    *,
    folder: str | Path = "recorded",
    demonstrations: Sequence[Demonstration[JointTrajectory]] = (),
    port: int = 0,
) -> TeachingPage:
    """A live page on which the arm is led by its tip, served until it is closed.

    Args:
        scene: obstacles in the arm's base frame, and the margins to keep.
        folder: for the demonstrations, a .csv each, of the arm's joints.
        demonstrations: joint motions that are there already.
        port: of the page; 0 picks a free one.

    Raises:
        InvalidInput: if the port is taken.
        MissingDependency: if the extra `view` is not installed.
    """
    check_arm(arm)
    check.integer(port, "port", at_least=0, at_most=65535)
    recordings = Recordings(arm, Path(folder), demonstrations)
    return TeachingPage(Teaching(arm, as_scene(scene), recordings), port)


class TeachingPage(ShortRepr):
    """A running page of `teach`.

    Attributes:
        url: of the page; the token in it keeps others out.
        session: the state of the page.
    """

    def __init__(self, session: Teaching, port: int) -> None:
        self.session = session
        document = session.drawn.document()
        self._server = PageServer(document, session, port=port, period=_PERIOD)
        self.url = self._server.url

    def _repr_parts(self) -> list[str]:
        return [self.url]

    def open(self) -> None:
        """Opens the page in the user's browser."""
        webbrowser.open(self.url)

    def wait(self) -> None:
        """Returns when Ctrl-C has closed the page."""
        try:
            threading.Event().wait()
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stops the page's server; a recording that is running is kept."""
        self._server.close()
        self.session.close()


@dataclass(frozen=True, eq=False)
class _Learned:
    """A skill of the demonstrations, and how near it comes to them."""

    planner: Replanner
    text: str


class Teaching:
    """The state of a teaching page and its answers to browsers; one thread calls it."""

    def __init__(self, arm: Arm, scene: Scene, recordings: Recordings) -> None:
        self.arm, self.recordings = arm, recordings
        self.led = LedArm(arm, scene)
        self.planner: Replanner | None = None
        self.answer: Answer | None = None
        self.motion: JointTrajectory | None = None  # the one that the page plays
        self._text = "Press Record and lead the arm by the ring at its tip."
        self._learned = ""
        self._recording: list[tuple[float, Float64Array]] | None = None
        self._events: list[Event] = []
        self._messages: list[str] = []
        self._worker = ThreadPoolExecutor(1)
        self._job: Future[Any] | None = None
        self._changes: list[Callable[[Replanner], None]] = []
        self._is_coarse = False

    @property
    def drawn(self) -> LiveScene:
        """The arm as the page shows it, with all that is drawn."""
        resting = JointTrajectory(np.zeros(1), self.led.q[None], joint_names=self.arm.joint_names)
        return LiveScene(
            self.arm,
            self.motion or resting,
            self.led.scene,
            self.recordings.demonstrations,
            None if self.answer is None else self.answer.path,
            self._goal_position,
        )

    @property
    def idle(self) -> bool:
        """Whether all that was asked for has been answered."""
        return self._job is None and not self._changes and not self._is_coarse

    # Messages of browsers, and answers.

    def greeting(self) -> list[str]:
        """Messages to a browser that has just opened the page."""
        return [self.drawn.message(), self._poses(), self._state()]

    def hear(self, message: str) -> None:
        """Takes a message of a browser, of any content."""
        try:
            said = json.loads(message)
            handler = self._HANDLERS[str(said.pop("do"))]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return  # not from our page
        try:
            handler(self, said)
        except LeadthroughError as error:
            self._say(str(error))
        except OSError as error:
            self._say(f"{error.filename}: {error.strerror}")

    def advance(self, dt: float) -> list[str]:
        """Messages to all browsers, dt s after the last call."""
        step = min(dt, _MAX_STEP)
        if self.led.advance(step):
            self._messages.append(self._poses())
        if self._recording is not None:
            self._recording.append((self._recording[-1][0] + step, self.led.q))
        self._collect()
        told, self._messages = self._messages, []
        return told

    def left(self) -> None:
        """Keeps the recording that runs when the last browser closes the page."""
        self.led.release()
        self._stop({})

    def close(self) -> None:
        """Ends the session; a recording that runs is kept."""
        self.left()
        self._worker.shutdown(wait=True, cancel_futures=True)

    # Leading and recording.

    def _grab(self, said: dict[str, Any]) -> None:
        """Takes the arm where the page shows it."""
        if self.motion is not None and said.get("time") is not None and self._recording is None:
            time = check.number(said["time"], "time", at_least=0.0)
            at = min(time, self.motion.duration) + float(self.motion.times[0])
            self.led.put(np.asarray(self.motion.at(at)))
            self._messages.append(self._poses())

    def _lead(self, said: dict[str, Any]) -> None:
        self.led.lead(_vector(said, "position"))

    def _turn(self, said: dict[str, Any]) -> None:
        self.led.turn(_vector(said, "vector"))

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
        word = "opened" if self._events and self._events[-1].name == "closed" else "closed"
        self._events.append(Event(self._recording[-1][0], word))
        self._say(f"gripper {word}")

    def _stop(self, _: dict[str, Any]) -> None:
        if self._recording is None:
            return
        recorded, self._recording = self._recording, None
        motion = recording_of(self.arm, recorded, self._events)
        if motion is None:
            self._say("Nothing was recorded: the arm did not move.")
            return
        path = self.recordings.add(motion)
        self._show(motion)
        self._say(f"{path} is written; record another, or press Learn.")

    def _delete(self, said: dict[str, Any]) -> None:
        name = self.recordings.remove(self.recordings.checked(said.get("index")))
        self._messages.append(self.drawn.message((_DEMONSTRATIONS,)))
        self._say(f"{name} is deleted.")

    def _play(self, said: dict[str, Any]) -> None:
        self._show(self.recordings.motion(said.get("index")))

    # Learning, planning and correcting.

    def _learn(self, _: dict[str, Any]) -> None:
        given, scene = tuple(self.recordings.demonstrations), self.led.scene
        if not given:
            self._say("Record a demonstration first.")
        elif self._job is None:
            self._job = self._worker.submit(_learned, self.arm, given, scene)
            self._say("Learning ...")

    def _goal(self, said: dict[str, Any]) -> None:
        position = _vector(said, "position")
        self._change(lambda planner: planner.move_goal(position))

    def _obstacle(self, said: dict[str, Any]) -> None:
        position = _vector(said, "position")
        moved, i = self.led.moved(said.get("index"), position)
        if not self.arm.is_clear(self.led.q, moved):
            self._say("The arm is there; lead it away first.")
            return
        self.led.scene = moved
        self._change(lambda planner: planner.move_obstacle(i, position))
        self._messages.append(self.drawn.message((_OBSTACLES,)))

    def _correct(self, said: dict[str, Any]) -> None:
        time = check.number(said.get("time"), "time", at_least=0.0)
        position = _vector(said, "position")
        self._change(lambda planner: planner.correct(time, position))

    def _undo(self, _: dict[str, Any]) -> None:
        self._change(lambda planner: planner.undo())

    def _change(self, change: Callable[[Replanner], None]) -> None:
        """Plans anew after a change; those that come meanwhile are answered together."""
        if self.planner is not None:
            self._changes.append(change)

    def _save(self, _: dict[str, Any]) -> None:
        if self.planner is None:
            self._say("Press Learn first.")
            return
        self.planner.skill.save(self.skill_path)
        self._say(f"The skill is in {self.skill_path}.")

    @property
    def skill_path(self) -> Path:
        """The file of the skill, beside the folder of the demonstrations."""
        return self.recordings.folder.parent / "skill.npz"

    @property
    def command(self) -> str:
        """The next command, which goes on with the files that are there."""
        if self.planner is None:
            known = self.recordings.demonstrations
            return f"leadthrough learn {self.recordings.folder} -o skill.npz" if known else ""
        words = ["leadthrough plan", str(self.skill_path)]
        if self.planner.has_moved_goal:
            goal = [self.planner.goal_position, self.planner.goal_orientation]
            texts = [live_scene.numbers(part) for part in goal if part is not None]
            words.append(f"--goal={'/'.join(texts)}")
        return " ".join([*words, *live_scene.obstacle_words(self.led.scene), "-o", "motion.json"])

    def _collect(self) -> None:
        """Takes what the worker has done, and gives it the next job."""
        if self._job is not None and self._job.done():
            job, self._job = self._job, None
            try:
                self._take(job.result())
            except LeadthroughError as error:
                self._say(str(error))
        if self._job is None and self.planner is not None and (self._changes or self._is_coarse):
            changes, self._changes = self._changes, []
            self._job = self._worker.submit(_replanned, self.planner, changes)
            self._is_coarse = bool(changes)

    def _take(self, result: _Learned | Answer) -> None:
        if isinstance(result, _Learned):
            self.planner, self._learned = result.planner, result.text
            self.planner.skill.save(self.skill_path)
            self._is_coarse = True
            self._say(result.text)
            return
        self.answer, moves = result, result.joints is not None
        if result.joints is not None:
            self.motion = result.joints
        detailed = not self._is_coarse
        self._messages.append(self.drawn.message((_PATH, _GOAL), moves=moves, detailed=detailed))
        verdict = result.trouble or result.verdict
        self._say(f"{self._learned} {verdict[:1].upper()}{verdict[1:]}")

    # Messages.

    def _say(self, text: str) -> None:
        self._text = text.strip()
        self._messages.append(self._state())

    def _show(self, motion: JointTrajectory) -> None:
        self.motion = motion
        self._messages.append(self.drawn.message((_DEMONSTRATIONS,), moves=True))

    def _poses(self) -> str:
        return live_scene.poses_message(self.arm, self.led.q, self.led.blocked)

    @property
    def _goal_position(self) -> Float64Array | None:
        planner = self.planner
        return planner.goal_position if planner is not None and planner.has_goal else None

    def _state(self) -> str:
        goal = self._goal_position
        shapes = self.led.scene.shapes
        return json.dumps(
            {
                "kind": "state",
                "text": self._text,
                "recording": self._recording is not None,
                "demonstrations": self.recordings.listed(),
                "goal": None if goal is None else goal.round(5).tolist(),
                "obstacles": [np.round(each.position, 5).tolist() for each in shapes],
                "corrections": 0 if self.planner is None else self.planner.corrections,
                "learned": self.planner is not None,
                "command": self.command,
            }
        )

    _HANDLERS: ClassVar[dict[str, Callable[[Teaching, dict[str, Any]], None]]] = {
        "grab": _grab, "lead": _lead, "turn": _turn, "release": _release, "record": _record,
        "gripper": _gripper, "stop": _stop, "delete": _delete, "play": _play, "learn": _learn,
        "goal": _goal, "obstacle": _obstacle, "correct": _correct, "undo": _undo, "save": _save,
    }  # fmt: skip


def _learned(arm: Arm, demonstrations: Sequence[Demonstration[Any]], scene: Scene) -> _Learned:
    """The skill of joint motions, as poses of the tip."""
    poses: list[Demonstration[PoseTrajectory]] = [
        Demonstration(arm.poses(each.motion), each.name) for each in demonstrations
    ]
    skill = learn(poses)
    near = reproduction(skill, poses)
    family = type(skill.model).__name__
    text = f"Learned by {family}, within {1e3 * near.position:.2g} mm of every demonstration."
    return _Learned(Replanner(arm, skill, scene=scene, demonstrations=poses), text)


def _replanned(planner: Replanner, changes: Sequence[Callable[[Replanner], None]]) -> Answer:
    """A quick answer after changes, and one in full without."""
    for change in changes:
        change(planner)
    return planner.preview() if changes else planner.plan()


def _vector(said: dict[str, Any], name: str) -> Float64Array:
    value = said.get(name)
    if value is None:
        raise InvalidInput(f"{name}: expected three numbers, got none")
    return check.array(value, name, shape=(3,))
