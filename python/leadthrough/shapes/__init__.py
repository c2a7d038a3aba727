"""Obstacles, each with a signed distance: negative inside, zero on the surface."""

from leadthrough.shapes.box import Box
from leadthrough.shapes.cloud import PointCloud
from leadthrough.shapes.hull import Hull
from leadthrough.shapes.mesh import Mesh
from leadthrough.shapes.round import Capsule, Cylinder, Sphere
from leadthrough.shapes.scene import (
    MovingObstacle,
    Obstacle,
    RandomObstacle,
    Scene,
    SceneLike,
    Shape,
    as_scene,
    check_shapes,
    compiled,
)

__all__ = [
    "Box",
    "Capsule",
    "Cylinder",
    "Hull",
    "Mesh",
    "MovingObstacle",
    "Obstacle",
    "PointCloud",
    "RandomObstacle",
    "Scene",
    "SceneLike",
    "Shape",
    "Sphere",
    "as_scene",
    "check_shapes",
    "compiled",
]
