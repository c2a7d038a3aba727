"""Draws a scene on a viser server."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from leadthrough.drawing import palette
from leadthrough.drawing.palette import Colour
from leadthrough.show.creases import creased
from leadthrough.show.scene import SMOOTH, Animation, Item

if TYPE_CHECKING:
    import viser

_GRID_CELL = (232, 235, 239)
_GRID_SECTION = (205, 211, 218)


class Stage:
    """The nodes of a scene on a viser server, by layer."""

    def __init__(self, server: viser.ViserServer, shown: Animation) -> None:
        self._server = server
        self._nodes: dict[str, list[viser.MeshHandle]] = {}
        self._hidden: set[str] = set()
        self._set_up(shown)
        self._links = shown.links
        self._frames = [
            server.scene.add_frame(f"/arm/{link}", show_axes=False) for link in shown.links
        ]
        for item in shown.items:
            self.draw(item)
        self.pose(shown, 0.0)

    def draw(self, item: Item, *, under: str | None = None) -> None:
        """Adds a surface below its link, or below the node `under`."""
        if under is None:
            under = "" if item.link is None else f"/arm/{self._links[item.link]}"
        # The browser computes normals itself, smooth where faces share a vertex.
        mesh = item.mesh if item.layer in SMOOTH else creased(item.mesh)[0]
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

    def pose(self, shown: Animation, time: float) -> None:
        """Moves the links to their poses at a time, s."""
        positions, orientations = shown.poses_at(time)
        with self._server.atomic():
            for frame, position, turned in zip(self._frames, positions, orientations, strict=True):
                frame.position, frame.wxyz = position, turned

    def _set_up(self, shown: Animation) -> None:
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
        centre, radius = shown.ball()
        server.initial_camera.position = tuple(centre + radius * np.array([2.0, -2.0, 1.3]))
        server.initial_camera.look_at = tuple(centre)
        server.initial_camera.fov = 0.7


def to_bytes(colour: Colour) -> tuple[int, int, int]:
    """A colour as three bytes."""
    red, green, blue = (round(255.0 * part) for part in colour)
    return red, green, blue
