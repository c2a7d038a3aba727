"""A live page in the browser: a moving arm, with a goal and obstacles that can be dragged."""

from __future__ import annotations

import contextlib
import io
import threading
import webbrowser
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from leadthrough import check
from leadthrough.check import Float64Array, LeadthroughError, MissingDependency
from leadthrough.drawing import palette
from leadthrough.drawing.palette import Colour
from leadthrough.models.protocol import Parameter
from leadthrough.show.animation import GOAL, OBSTACLES, PATH, SPREAD, Animation, Item
from leadthrough.show.arm_scene import goal_item, obstacle_item, path_item, spread_items
from leadthrough.show.private import guarding, new_token
from leadthrough.show.replanner import Answer, Replanner

if TYPE_CHECKING:
    import viser

_FRAME = 1.0 / 40.0  # s
# A plan in full is made when nothing has been dragged for this long, s.
_REST = 0.25
_HANDLE = 0.18  # m
_MAX_SPEED = 2.0


class LiveView:
    """A page that shows a scene and, with a replanner, plans anew while things are dragged."""

    def __init__(
        self, animation: Animation, replanner: Replanner | None = None, *, port: int = 0
    ) -> None:
        self._private = PrivateServer(check.integer(port, "port", at_least=0, at_most=65535))
        self._server = self._private.server
        self._animation, self._planner = animation, replanner
        if replanner is not None:
            dragged = (OBSTACLES, GOAL)
            fixed = tuple(item for item in animation.items if item.layer not in dragged)
            self._stage = Stage(self._server, replace(animation, items=fixed))
        else:
            self._stage = Stage(self._server, animation)
        self.handles: dict[str, viser.TransformControlsHandle] = {}
        self._answer: Answer | None = None
        self._changes: list[Callable[[], None]] = []
        self._asked, self._closing = threading.Event(), threading.Event()
        self._motion_controls()
        self._layer_controls()
        if replanner is not None:
            self._model_controls(replanner)
            self._drag_handles(replanner)
        self._threads = [threading.Thread(target=self._play, daemon=True)]
        if replanner is not None:
            self._threads.append(
                threading.Thread(target=self._replan, args=(replanner,), daemon=True)
            )
        for thread in self._threads:
            thread.start()

    @property
    def url(self) -> str:
        """The page's URL; the token in it keeps others out."""
        return self._private.url

    @property
    def answer(self) -> Answer | None:
        """The latest plan or preview; None before the first, and without a replanner."""
        return self._answer

    @property
    def clients(self) -> dict[int, viser.ClientHandle]:
        """The browsers that show the page, as viser's handles by number."""
        return dict(self._server.get_clients())

    def open(self) -> None:
        """Opens the page in the user's browser."""
        webbrowser.open(self.url)

    def wait(self) -> None:
        """Returns when the view has been closed; Ctrl-C closes it."""
        try:
            while not self._closing.wait(1.0):
                pass
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Stops the page's server."""
        self._closing.set()
        self._asked.set()
        for thread in self._threads:
            thread.join()
        self._private.stop()

    def request(self, change: Callable[[], None]) -> None:
        """Asks for a new plan, before which a change is made to the replanner."""
        self._changes.append(change)
        self._asked.set()

    def _motion_controls(self) -> None:
        gui = self._server.gui
        with gui.add_folder("Motion"):
            self._playing = gui.add_checkbox("play", True)
            # Any: mypy takes the handle's `value` for read-only.
            self._time: Any = gui.add_slider("time, s", 0.0, self._end(), 0.01, 0.0)
            self._speed = gui.add_slider("speed", 0.1, _MAX_SPEED, 0.1, 1.0)
        self._status = gui.add_markdown("\n\n".join(self._animation.remarks))
        self._time.on_update(lambda _: self._stage.pose(self._animation, self._time.value))

    def _layer_controls(self) -> None:
        def add_box(layer: str) -> None:
            box = self._server.gui.add_checkbox(layer, True)
            box.on_update(lambda _: self._stage.show(layer, box.value))

        with self._server.gui.add_folder("Layers"):
            for layer in dict.fromkeys(item.layer for item in self._animation.items):
                add_box(layer)

    def _model_controls(self, planner: Replanner) -> None:
        nominal = round(planner.nominal_duration, 2)
        with self._server.gui.add_folder("Model"):
            slider = self._server.gui.add_slider(
                "duration, s", round(0.2 * nominal, 2), 3.0 * nominal, 0.01, nominal
            )
            slider.on_update(
                lambda _: self.request(lambda: setattr(planner, "duration", slider.value))
            )
            for i, parameter in enumerate(planner.parameters):
                self._parameter_slider(planner, i, parameter)

    def _parameter_slider(self, planner: Replanner, index: int, parameter: Parameter) -> None:
        slider = self._server.gui.add_slider(
            parameter.label, parameter.lower, parameter.upper, parameter.step, parameter.value
        )
        slider.on_update(
            lambda _: self.request(lambda: planner.set_parameter(index, float(slider.value)))
        )

    def _drag_handles(self, planner: Replanner) -> None:
        if planner.has_goal:
            self._handle("goal", planner.goal_position, planner.goal_orientation, planner.move_goal)
            self._stage.draw(goal_item(np.zeros(3)), under="/goal")
        for i, shape in enumerate(planner.obstacles):
            name = f"obstacle {i}"
            orientation = getattr(shape, "orientation", None)
            self._handle(name, shape.position, orientation, partial(planner.move_obstacle, i))
            item = replace(obstacle_item(shape, i), mesh=shape.surface())
            self._stage.draw(item, under=f"/{name}")

    def _handle(
        self,
        name: str,
        position: Float64Array,
        orientation: Float64Array | None,
        move: Callable[[Float64Array, Float64Array | None], None],
    ) -> None:
        handle = self._server.scene.add_transform_controls(
            f"/{name}",
            scale=_HANDLE,
            depth_test=False,
            disable_rotations=orientation is None,
            position=position,
            wxyz=(1.0, 0.0, 0.0, 0.0) if orientation is None else orientation,
        )

        def moved(_: object) -> None:
            position = np.array(handle.position)
            rotated = None if orientation is None else np.array(handle.wxyz)
            self.request(lambda: move(position, rotated))

        handle.on_update(moved)
        self.handles[name] = handle

    def _end(self) -> float:
        return round(max(float(self._animation.times[-1]), 0.01), 2)

    def _play(self) -> None:
        while not self._closing.wait(_FRAME):
            if (
                self._playing.value
                and len(self._animation.times) > 1
                and self._server.get_clients()
            ):
                at = self._time.value + _FRAME * self._speed.value
                self._time.value = 0.0 if at > self._end() else at

    def _replan(self, planner: Replanner) -> None:
        """Shows a preview after each change, of the latest only, and a plan once all is at rest."""
        planner.preview()  # prepares what the first drag would otherwise wait for
        while not self._closing.is_set():
            self._show(planner, planner.plan())
            self._asked.wait()
            while self._asked.is_set() and not self._closing.is_set():
                self._asked.clear()
                trouble = self._apply_changes()
                self._show(planner, trouble or planner.preview())
                self._asked.wait(_REST)

    def _apply_changes(self) -> Answer | None:
        changes, self._changes = self._changes, []
        try:
            for change in changes:
                change()
        except LeadthroughError as error:
            return Answer(None, None, str(error), "", 0.0)
        return None

    def _show(self, planner: Replanner, answer: Answer) -> None:
        if answer.path is not None:
            self._stage.redraw(PATH, [path_item(answer.path)])
        if answer.joints is not None:
            self._animation = self._animation.with_motion(planner.arm, answer.joints)
            self._time.max = self._end()
            self._stage.pose(self._animation, self._time.value)
        if not answer.trouble:
            spread = spread_items(planner.arm, planner.asked_skill())
            self._stage.redraw(SPREAD, spread)
        kind = "planned" if answer.verdict else "previewed"
        head = f"**{kind} in {1e3 * answer.seconds:.0f} ms**"
        lines = [head, answer.trouble or answer.verdict, *self._animation.remarks]
        self._status.content = "\n\n".join(lines)
        self._answer = answer


_GRID_CELL = (232, 235, 239)
_GRID_SECTION = (205, 211, 218)


class Stage:
    """The nodes of a scene on a viser server, by layer."""

    def __init__(self, server: viser.ViserServer, animation: Animation) -> None:
        self._server = server
        self._nodes: dict[str, list[viser.MeshHandle]] = {}
        self._hidden: set[str] = set()
        self._set_up(animation)
        self._links = animation.links
        self._frames = [
            server.scene.add_frame(f"/arm/{link}", show_axes=False) for link in animation.links
        ]
        for item in animation.items:
            self.draw(item)
        self.pose(animation, 0.0)

    def draw(self, item: Item, *, under: str | None = None) -> None:
        """Adds a surface below its link, or below the node `under`."""
        if under is None:
            under = "" if item.link is None else f"/arm/{self._links[item.link]}"
        # The browser computes normals itself, smooth where faces share a vertex.
        mesh = item.shaded
        node = self._server.scene.add_mesh_simple(
            f"{under}/{item.layer}/{item.name}",
            mesh.vertices.astype(np.float32),
            mesh.faces.astype(np.uint32),
            color=to_bytes(item.colour),
            opacity=None if item.opacity == 1.0 else item.opacity,
            visible=item.layer not in self._hidden,
        )
        self._nodes.setdefault(item.layer, []).append(node)

    def redraw(self, layer: str, items: Iterable[Item]) -> None:
        """Replaces all surfaces of a layer by these."""
        with self._server.atomic():
            for node in self._nodes.pop(layer, []):
                node.remove()
            for item in items:
                self.draw(item)

    def show(self, layer: str, visible: bool) -> None:
        """Shows or hides a layer."""
        (self._hidden.discard if visible else self._hidden.add)(layer)
        for node in self._nodes.get(layer, []):
            node.visible = visible

    def pose(self, animation: Animation, time: float) -> None:
        """Moves the links to their poses at a time, s."""
        positions, orientations = animation.poses_at(time)
        with self._server.atomic():
            for frame, position, orientation in zip(
                self._frames, positions, orientations, strict=True
            ):
                frame.position, frame.wxyz = position, orientation

    def _set_up(self, animation: Animation) -> None:
        server = self._server
        server.gui.configure_theme(
            show_logo=False,
            show_share_button=False,
            brand_color=to_bytes(palette.rgb(palette.PATH)),
        )
        server.gui.main_panel.dock_right()
        server.scene.set_up_direction("+z")
        server.scene.world_axes.visible = False
        # Light from an image and shadows take a computer without a graphics card half of its time
        # for each frame, and seconds to prepare.
        server.scene.configure_environment_map(hdri=None)
        server.scene.configure_default_lights(cast_shadow=False)
        server.scene.add_grid(
            "/ground", width=4.0, height=4.0, cell_size=0.1, section_size=0.5, plane="xy",
            cell_color=_GRID_CELL, section_color=_GRID_SECTION, shadow_opacity=0.0,
        )  # fmt: skip
        centre, radius = animation.ball()
        server.initial_camera.position = tuple(centre + radius * np.array([2.0, -2.0, 1.3]))
        server.initial_camera.look_at = tuple(centre)
        server.initial_camera.fov = 0.7


def to_bytes(colour: Colour) -> tuple[int, int, int]:
    """A colour as three bytes."""
    red, green, blue = (round(255.0 * part) for part in colour)
    return red, green, blue


# viser has no option for a guard: the function with which it starts to listen is replaced while it
# does.
_starting = threading.Lock()


class PrivateServer:
    """A running viser server and its address."""

    def __init__(self, port: int) -> None:
        try:
            import viser  # noqa: PLC0415
        except ImportError:
            raise MissingDependency("viser", extra="view") from None
        token = new_token()
        with _starting, _guarded_by(token) as guarded, silence():
            self.server: viser.ViserServer = viser.ViserServer(
                host="127.0.0.1", port=port, verbose=False
            )
        self.url = f"http://127.0.0.1:{self.server.get_port()}/{token}/"
        if not guarded:
            self.stop()
            raise MissingDependency("a viser that serves by websockets", extra="view")

    def stop(self) -> None:
        """Stops the server."""
        with silence():
            self.server.stop()


def silence() -> AbstractContextManager[TextIO]:
    """Keeps viser's own messages off our output."""
    return contextlib.redirect_stdout(io.StringIO())


@contextmanager
def _guarded_by(token: str) -> Iterator[list[str]]:
    """Lets viser listen with our answer before its own; the list is filled when it has."""
    from websockets.asyncio import server as library  # noqa: PLC0415

    listen, guarded = library.serve, []

    def serve(handler: Any, *where: Any, process_request: Any = None, **options: Any) -> Any:
        if handler.__module__.startswith("viser."):
            guarded.append(handler.__module__)
            process_request = guarding(process_request, token)
        return listen(handler, *where, process_request=process_request, **options)

    library.serve = serve  # type: ignore[assignment, misc]
    try:
        yield guarded
    finally:
        library.serve = listen  # type: ignore[misc]
