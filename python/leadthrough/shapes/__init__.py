"""Obstacles and carried objects, each with a signed distance: negative inside."""

from leadthrough.shapes.mesh import Mesh as Mesh, PointCloud as PointCloud
from leadthrough.shapes.primitives import (
    Box as Box,
    Capsule as Capsule,
    Cylinder as Cylinder,
    Sphere as Sphere,
)
from leadthrough.shapes.scene import (
    SHAPES as SHAPES,
    MovingObstacle as MovingObstacle,
    Obstacle as Obstacle,
    RandomObstacle as RandomObstacle,
    Scene as Scene,
    SceneLike as SceneLike,
    as_scene as as_scene,
    check_shapes as check_shapes,
    compiled as compiled,
    names_of as names_of,
)
from leadthrough.shapes.shape import Primitive as Primitive, Shape as Shape, Solid as Solid
