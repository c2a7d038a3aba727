"""An arm's shapes in coal, placed by Pinocchio: distances that owe nothing to ours.

Both libraries come with the extra `test`.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np

from leadthrough import check, rotations
from leadthrough.arm import Arm
from leadthrough.check import Float64Array
from leadthrough.errors import InvalidInput
from leadthrough.shapes import Box, Capsule, Cylinder, Shape, Sphere

_EXACT = 1e-8  # m, of coal's distances


def installed() -> bool:
    """Whether coal and Pinocchio are."""
    return find_spec("coal") is not None and find_spec("pinocchio") is not None


class CoalArm:
    """All shapes of an arm's links, as its URDF has them.

    Args:
        arm: whose URDF has no other moving joints than the arm.
        packages: folders of the packages that hold its meshes, which count as they are.
    """

    def __init__(self, arm: Arm, packages: Sequence[str] = ()) -> None:
        self._pin = check.package("pinocchio", extra="test")
        self._coal = check.package("coal", extra="mesh")
        self._model = self._pin.buildModelFromXML(arm.document)
        self._geometry = self._pin.buildGeomFromUrdfString(
            self._model, arm.document, self._pin.GeometryType.COLLISION, package_dirs=list(packages)
        )
        self._data = self._model.createData()
        self._places = self._geometry.createData()
        self._shapes: dict[str, list[Any]] = defaultdict(list)
        for shape in self._geometry.geometryObjects:
            self._shapes[shape.name.rpartition("_")[0]].append(shape)

    def place(self, q: Float64Array) -> None:
        """Put all links where a configuration (joints,) has them."""
        full = self._pin.neutral(self._model)
        for joint, value in zip(list(self._model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        self._pin.updateGeometryPlacements(
            self._model, self._data, self._geometry, self._places, full
        )

    def moving_links(self) -> list[str]:
        """The links behind a moving joint that have shapes."""
        moving = [s for s in self._geometry.geometryObjects if s.parentJoint > 0]
        return list(dict.fromkeys(shape.name.rpartition("_")[0] for shape in moving))

    def link_distance(self, a: str, b: str) -> float:
        """The distance between two links in m, negative where they overlap."""
        pairs = itertools.product(self._shapes[a], self._shapes[b])
        return min(
            self._distance(x.geometry, self._pose(x), y.geometry, self._pose(y)) for x, y in pairs
        )

    def distance_to(self, links: Iterable[str], geometry: Any, pose: Any) -> float:
        """The least distance in m from links to a geometry of coal, negative where they overlap.

        Args:
            links: names.
            geometry: of coal.
            pose: of the shape, as Pinocchio's SE3.
        """
        return min(
            self._distance(shape.geometry, self._pose(shape), geometry, pose)
            for link in links
            for shape in self._shapes[link]
        )

    def solid(self, shape: Shape) -> tuple[Any, Any]:  # neither library declares types
        """The geometry and the pose of a box, ball, capsule or cylinder, for `distance_to`.

        Raises:
            InvalidInput: for another shape.
        """
        turned = np.eye(3)
        if isinstance(shape, Box | Capsule | Cylinder):
            turned = rotations.to_matrix(np.asarray(shape.orientation)[None])[0]
        pose = self._pin.SE3(turned, np.asarray(shape.position))
        if isinstance(shape, Box):
            return self._coal.Box(*shape.size), pose
        if isinstance(shape, Sphere):
            return self._coal.Sphere(shape.radius), pose
        if isinstance(shape, Capsule):
            return self._coal.Capsule(shape.radius, shape.length), pose
        if isinstance(shape, Cylinder):
            return self._coal.Cylinder(shape.radius, shape.length), pose
        raise InvalidInput(f"shape: expected a Box, Sphere, Capsule or Cylinder, got {shape!r}")

    def _pose(self, shape: Any) -> Any:
        return self._places.oMg[self._geometry.getGeometryId(shape.name)]

    def _distance(self, a: Any, pose_a: Any, b: Any, pose_b: Any) -> float:
        at = [self._coal.Transform3s(each.rotation, each.translation) for each in (pose_a, pose_b)]
        request = self._coal.DistanceRequest()
        request.gjk_tolerance = request.epa_tolerance = _EXACT
        return float(self._coal.distance(a, at[0], b, at[1], request, self._coal.DistanceResult()))
