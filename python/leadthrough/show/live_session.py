"""A live page in the browser: its state, which browsers move and see, and its own server."""

from __future__ import annotations

import asyncio
import contextlib
import hmac
import json
import logging
import secrets
import threading
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from http import HTTPStatus
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, Literal, TypeVar

import numpy as np

from leadthrough import check
from leadthrough.arm import Arm
from leadthrough.check import Float64Array, InvalidInput, LeadthroughError, ShortRepr
from leadthrough.models.protocol import Skill
from leadthrough.motion import Demonstration, JointTrajectory
from leadthrough.shapes import Scene, Shape
from leadthrough.show import arm_scene as scenes, page
from leadthrough.show.animation import Animation, Item, Layer
from leadthrough.show.arm_scene import goal_item, path_item, start_item
from leadthrough.show.replanner import Answer, Change, Replanner, Replanning

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

_MOTIONLESS = Animation((), np.zeros(0), np.zeros((0, 0, 3)), np.zeros((0, 0, 4)), ())
_MARKS = {Layer.PATH: path_item, Layer.START: start_item, Layer.GOAL: goal_item}
LAYERS = [layer for layer in Layer if layer not in (Layer.ARM, Layer.PLANNED)]


@dataclass(frozen=True, eq=False)
class LiveScene:
    """An arm and what is drawn with it."""

    arm: Arm
    motion: JointTrajectory | None  # that the page plays
    scene: Scene
    demonstrations: Sequence[Demonstration] = ()
    path: Float64Array | None = None  # of the tip (n, 3)
    goal: Float64Array | None = None  # (3,)
    skill: Skill | None = None  # whose spread is drawn
    via: Sequence[Float64Array] = ()  # points (3,) that the path was moved to
    wanted: Float64Array | None = None  # path of the tip (m, 3) by the skill alone
    others: Sequence[Float64Array] = ()  # such paths by other modes

    def document(self, kind: str) -> str:
        """The page of a kind, "teach" or "view"."""
        return page.live_document(self._whole(), self.arm.robot.name, kind)

    def write(self, path: str | Path) -> None:
        """Writes a page that needs no server."""
        page.write_page(path, self.arm.robot.name, page.scene(self._whole()), whole=True)

    def message(
        self, layers: Sequence[str] = LAYERS, *, moves: bool = False, detailed: bool = True
    ) -> str:
        """Surfaces of some layers, and the motion from now on if it `moves`."""
        items = tuple(item for name in layers for item in self._items(name))
        motion = scenes.arm_motion(self.arm, self.motion) if moves else _MOTIONLESS
        drawn = replace(motion, items=items)
        told = self._readouts() if detailed else None
        data = page.packed(drawn, level=1, layers=list(layers), readouts=told)
        return json.dumps({"kind": "scene", "data": data, "moves": moves})

    def _whole(self) -> Animation:
        drawn = scenes.arm_scene(self.arm, self.motion)
        items = [item for item in drawn.items if item.layer not in LAYERS]
        items += [item for name in LAYERS for item in self._items(name)]
        return replace(drawn, items=tuple(items), readouts=self._readouts())

    def _readouts(self) -> dict[str, Any] | None:
        return scenes.readouts(self.arm, self.motion, self.scene, self.wanted)

    def _items(self, layer: str) -> Iterable[Item]:
        if layer == Layer.DEMONSTRATIONS:
            return scenes.demonstration_items(self.arm, self.demonstrations)
        if layer == Layer.OBSTACLES:
            return [scenes.obstacle_item(shape, i) for i, shape in enumerate(self.scene.shapes)]
        if layer == Layer.SPREAD:
            return scenes.spread_items(self.arm, self.skill)
        if layer == Layer.VIA:
            return scenes.via_items(self.via)
        if layer == Layer.MODES:
            return scenes.mode_items(self.others)
        marked = self.goal if layer == Layer.GOAL else self.path
        return [] if marked is None else [_MARKS[Layer(layer)](marked)]


Handler = Callable[[Any, dict[str, Any]], None]

# Durations that the slider offers, as multiples of the skill's own.
_DURATIONS = (0.2, 3.0)


class LiveSession:
    """A motion of an arm on a live page; one thread calls it."""

    _HANDLERS: ClassVar[Mapping[str, Handler]]

    def __init__(
        self,
        arm: Arm,
        scene: Scene,
        motion: JointTrajectory | None = None,
        *,
        demonstrations: Sequence[Demonstration] = (),
    ) -> None:
        self.arm, self.scene, self.motion = arm, scene, motion
        self.demonstrations = demonstrations
        self.answer: Answer | None = None
        self._planning: Replanning | None = None
        self._path: Float64Array | None = None
        self._text = ""
        self._messages: list[str] = []

    @property
    def planner(self) -> Replanner | None:
        """The skill that plans; None without one."""
        return None if self._planning is None else self._planning.planner

    @property
    def idle(self) -> bool:
        """Whether all that was asked for has been answered."""
        return self._planning is None or self._planning.idle

    def plan_with(self, planner: Replanner, answer: Answer | None = None) -> None:
        """Plans with a skill from now on; its answer so far, if there is one."""
        if self._planning is not None:
            self._planning.close()
        self._planning = Replanning(planner, planned=answer is not None)
        if answer is not None:
            self._take(answer, whole=True)

    @property
    def drawn(self) -> LiveScene:
        planner = self.planner
        skill, via = (None, ()) if planner is None else (planner.asked_skill(), planner.via)
        planned = self.answer if self.answer and self.answer.joints is self.motion else None
        return LiveScene(
            *(self.arm, self._shown(), self.scene, self.demonstrations),
            *(self._path, self._place_of("goal"), skill, via),
            wanted=None if planned is None else planned.wanted,
            others=() if planned is None else planned.others,
        )

    def greeting(self) -> list[str]:
        """Messages to a browser that has just opened the page."""
        return [self.drawn.message(moves=self.motion is not None), self._state()]

    def hear(self, message: str) -> None:
        """Takes a message of a browser, of any content."""
        try:
            said = json.loads(message)
            handler = self._HANDLERS[str(said["do"])]
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
            return  # not from our page
        with self._telling():
            handler(self, said)

    def advance(self, dt: float) -> list[str]:
        """Messages to all browsers, dt s after the last call."""
        with self._telling():
            self._go_on(dt)
        told, self._messages = self._messages, []
        return told

    def _go_on(self, dt: float) -> None:  # noqa: ARG002 (a session that moves needs it)
        """Does what is due, dt s after the last call."""
        found = None if self._planning is None else self._planning.collect()
        if found is not None:
            self._take(found[0], whole=found[1])

    @contextmanager
    def _telling(self) -> Iterator[None]:
        """Tells the browsers of trouble, which must not end the page."""
        try:
            yield
        except LeadthroughError as error:
            self._say(str(error))
        except OSError as error:
            self._say(f"{error.filename}: {error.strerror}")

    def left(self) -> None:
        """The last browser has closed the page."""

    def close(self) -> None:
        self.left()
        if self._planning is not None:
            self._planning.close()

    def request(self, change: Change) -> None:
        if self._planning is not None:
            self._planning.request(change)

    # Messages of browsers.

    def _end(self, said: dict[str, Any]) -> None:
        name, how = str(said["do"]), "turn" if "vector" in said else "move"
        given = vector(said, "vector" if how == "turn" else "position")
        self.request(lambda planner: getattr(getattr(planner, name), how)(given))

    def _obstacle(self, said: dict[str, Any]) -> None:
        shapes = list(self.scene.shapes)
        last = len(shapes) - 1
        i = check.integer(said.get("index", -1), "index", at_least=0, at_most=last)
        shapes[i] = moved = _moved(shapes[i], said)
        if self._place(replace(self.scene, obstacles=tuple(shapes))):
            at = moved.position, moved.orientation
            self.request(lambda planner: planner.move_obstacle(i, *at))
            self._messages.append(self.drawn.message((Layer.OBSTACLES,)))

    def _correct(self, said: dict[str, Any]) -> None:
        time = check.number(said.get("time"), "time", at_least=0.0)
        position = vector(said, "position")
        self.request(lambda planner: planner.correct(time, position))

    def _undo(self, _: dict[str, Any]) -> None:
        self.request(lambda planner: planner.undo())

    def _slide(self, said: dict[str, Any]) -> None:
        sliders = self._sliders()
        last = len(sliders) - 1
        i = check.integer(said.get("index", -1), "index", at_least=0, at_most=last)
        low, high = sliders[i]["lower"], sliders[i]["upper"]
        value = check.number(said.get("value"), "value", at_least=low, at_most=high)
        if i == 0:
            self.request(lambda planner: setattr(planner, "duration", value))
        else:
            self.request(lambda planner: planner.set_parameter(i - 1, value))

    HANDLERS: ClassVar[Mapping[str, Handler]] = MappingProxyType(
        {"start": _end, "goal": _end, "obstacle": _obstacle, "correct": _correct, "undo": _undo,
         "slide": _slide}
    )  # fmt: skip
    _HANDLERS = HANDLERS

    # Differences of sessions.

    def _shown(self) -> JointTrajectory | None:
        return self.motion

    def _place(self, scene: Scene) -> bool:
        """Takes a scene whose obstacles were moved, unless they cannot be there."""
        self.scene = scene
        return True

    def _worded(self, verdict: str, how: str) -> str:
        return f"{how}. {verdict}"

    def _facts(self) -> dict[str, Any]:
        """Parts of the state that other sessions have not."""
        return {"sliders": self._sliders()}

    # Messages to browsers.

    def _take(self, answer: Answer, *, whole: bool) -> None:
        self.answer, moves = answer, answer.joints is not None
        if answer.path is not None:
            self._path = answer.path
        if answer.joints is not None:
            self.motion = answer.joints
        hidden = {Layer.DEMONSTRATIONS, Layer.OBSTACLES, Layer.SPREAD if answer.trouble else None}
        layers = [layer for layer in LAYERS if layer not in hidden]
        self._messages.append(self.drawn.message(layers, moves=moves, detailed=whole))
        how = f"{'planned' if whole else 'previewed'} in {1e3 * answer.seconds:.0f} ms"
        self._say(self._worded(answer.trouble or answer.verdict, how))

    def _redraw_demonstrations(self, *, moves: bool) -> None:
        self._messages.append(self.drawn.message((Layer.DEMONSTRATIONS,), moves=moves))

    def _say(self, text: str) -> None:
        self._text = text.strip()
        self._messages.append(self._state())

    def _sliders(self) -> list[dict[str, Any]]:
        """The duration and the skill's parameters."""
        planner = self.planner
        if planner is None:
            return []
        own = planner.nominal_duration
        low, high = (round(factor * own, 2) for factor in _DURATIONS)
        first = (("duration, s", planner.duration or own, low, high, 0.01),)
        others = ((p.label, p.value, p.lower, p.upper, p.step) for p in planner.parameters)
        names = ("label", "value", "lower", "upper", "step")
        return [dict(zip(names, row, strict=True)) for row in (*first, *others)]

    def _place_of(self, name: Literal["start", "goal"]) -> Float64Array | None:
        end = None if self.planner is None else self.planner.end(name)
        return None if end is None else np.round(end.position, 5)

    def _state(self) -> str:
        planner = self.planner
        ends = {name: self._place_of(name) for name in ("start", "goal")}
        return json.dumps(
            {
                "kind": "state",
                "text": self._text,
                **{name: None if at is None else at.tolist() for name, at in ends.items()},
                "obstacles": [np.round(each.position, 5).tolist() for each in self.scene.shapes],
                "corrections": 0 if planner is None else planner.corrections,
                "learned": planner is not None,
                **self._facts(),
            }
        )


def _moved(shape: Shape, said: dict[str, Any]) -> Shape:
    """A shape at another position, or turned by a rotation vector."""
    if "vector" in said:
        return shape.turned(vector(said, "vector"))
    return shape.at(vector(said, "position"), shape.orientation)


def vector(said: dict[str, Any], name: str) -> Float64Array:
    value = said.get(name)
    if value is None:
        raise InvalidInput(f"{name}: expected three numbers, got none")
    return check.array(value, name, shape=(3,))


# Any web page that a browser has open may send requests to 127.0.0.1, by a name of its own that it
# lets point there (DNS rebinding) or across sites; so may any program of another user. The server
# therefore answers only where the path begins with a random token, the host is this machine's and
# the origin, where there is one, is the server's own page.
_TOKEN_BYTES = 24
_REFUSED = "Open the address that leadthrough printed, with all of its letters.\n"

# Called by websockets before it answers: None lets a WebSocket be opened.
Reply = Callable[["ServerConnection", "Request"], "Response | None"]


def guarding(answer: Reply, token: str) -> Reply:
    """The answer for those who know the token, from pages of this server; 403 for others."""

    def guarded(connection: ServerConnection, request: Request) -> Response | None:
        given, _, rest = request.path.removeprefix("/").partition("/")
        given = given.partition("?")[0]
        known = hmac.compare_digest(given.encode("utf-8", "replace"), token.encode())
        if not known or not _is_from_here(request, connection.local_address[1]):
            return connection.respond(HTTPStatus.FORBIDDEN, _REFUSED)
        response = answer(connection, replace(request, path=f"/{rest}"))
        if response is not None:
            response.headers["Referrer-Policy"] = "no-referrer"  # the address is the secret
            response.headers["Cache-Control"] = "no-store"
        return response

    return guarded


def _is_from_here(request: Request, port: int) -> bool:
    hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}
    named = request.headers.get_all("Host")
    origins = request.headers.get_all("Origin")
    return (
        len(named) == 1
        and named[0] in hosts
        and all(origin.removeprefix("http://") in hosts for origin in origins)
    )


# Longer messages of a browser are refused, bytes.
_MAX_MESSAGE = 65536


class PageServer:
    """A page, and a websocket between all browsers that show it and a session."""

    def __init__(self, document: str, session: LiveSession, *, port: int, period: float) -> None:
        try:
            import websockets  # noqa: F401, PLC0415
        except ImportError:
            raise check.MissingDependency("websockets", extra="view") from None
        self._document, self._session, self._period = document, session, period
        self._token = secrets.token_urlsafe(_TOKEN_BYTES)
        self._ready, self._closing = threading.Event(), threading.Event()
        self._trouble: OSError | None = None
        self._port = port
        self._thread = threading.Thread(target=lambda: asyncio.run(self._serve()), daemon=True)
        self._thread.start()
        self._ready.wait()
        if self._trouble is not None:
            raise InvalidInput(f"port: cannot listen on {port} ({self._trouble.strerror})")

    @property
    def url(self) -> str:
        """The page's URL; the token in it keeps others out."""
        return f"http://127.0.0.1:{self._port}/{self._token}/"

    def close(self) -> None:
        self._closing.set()
        self._thread.join()

    async def _serve(self) -> None:
        from websockets.asyncio.server import broadcast, serve  # noqa: PLC0415

        quiet = logging.Logger("leadthrough", logging.CRITICAL)  # nobody reads it
        answer = guarding(self._answer, self._token)
        try:
            server = await serve(
                *(self._talk, "127.0.0.1", self._port),
                process_request=answer, max_size=_MAX_MESSAGE, logger=quiet, close_timeout=0.2,
            )  # fmt: skip
        except OSError as error:
            self._trouble = error
            self._ready.set()
            return
        async with server:
            self._port = next(iter(server.sockets)).getsockname()[1]
            self._ready.set()
            last = due = time.monotonic()
            while not self._closing.is_set():
                due = max(due + self._period, last)
                await asyncio.sleep(max(due - time.monotonic(), 0.0))
                last, before = time.monotonic(), last
                for message in self._session.advance(last - before):
                    broadcast(server.connections, message)

    async def _talk(self, connection: ServerConnection) -> None:
        from websockets.exceptions import ConnectionClosed  # noqa: PLC0415

        with contextlib.suppress(ConnectionClosed):
            for message in self._session.greeting():
                await connection.send(message)
            async for heard in connection:
                self._session.hear(heard if isinstance(heard, str) else "")
        if not connection.server.connections - {connection}:
            self._session.left()

    def _answer(self, connection: ServerConnection, request: Request) -> Response | None:
        path = request.path.partition("?")[0]
        if path == "/live":
            return None
        if path != "/":
            return connection.respond(HTTPStatus.NOT_FOUND, "There is one page, at /.\n")
        response: Any = connection.respond(HTTPStatus.OK, self._document)
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        return response  # type: ignore[no-any-return]


# Time between looks at what is to be told, s: of an arm that is led also that of its steps.
_PERIODS = {"teach": 0.02, "view": 0.005}

SessionT = TypeVar("SessionT", bound=LiveSession)


class LivePage(ShortRepr, Generic[SessionT]):
    """A running live page.

    Attributes:
        session: the state of the page.
        url: of the page; the token in it keeps others out.
    """

    def __init__(self, session: SessionT, kind: Literal["teach", "view"], port: int) -> None:
        check.integer(port, "port", at_least=0, at_most=65535)
        self.session = session
        self._closed = threading.Event()
        document, period = session.drawn.document(kind), _PERIODS[kind]
        self._server = PageServer(document, session, port=port, period=period)
        self.url = self._server.url

    def _repr_parts(self) -> list[str]:
        return [self.url]

    @property
    def answer(self) -> Answer | None:
        """The latest plan or preview; None before the first, and without a skill."""
        return self.session.answer

    def open(self) -> None:
        """Opens the page in the user's browser."""
        webbrowser.open(self.url)

    def wait(self) -> None:
        """Returns when the page has been closed; Ctrl-C closes it."""
        try:
            self._closed.wait()
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stops the page's server; a recording that is running is kept."""
        self._server.close()
        self.session.close()
        self._closed.set()
