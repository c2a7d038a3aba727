"""Obstacles and carried objects, each with a signed distance: negative inside."""

from leadthrough.shapes.cloud import PointCloud
from leadthrough.shapes.mesh import Mesh
from leadthrough.shapes.primitives import Box, Capsule, Cylinder, Sphere
from leadthrough.shapes.scene import (
    SHAPES,
    MovingObstacle,
    Obstacle,
    RandomObstacle,
    Scene,
    SceneLike,
    as_scene,
    check_shapes,
    compiled,
    names_of,
)
from leadthrough.shapes.shape import Primitive, Shape, Solid

__all__ = [
    "SHAPES",
    "Box",
    "Capsule",
    "Cylinder",
    "Mesh",
    "MovingObstacle",
    "Obstacle",
    "PointCloud",
    "Primitive",
    "RandomObstacle",
    "Scene",
    "SceneLike",
    "Shape",
    "Solid",
    "Sphere",
    "as_scene",
    "check_shapes",
    "compiled",
    "names_of",
]
