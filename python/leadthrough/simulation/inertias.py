"""Masses and inertias of a URDF's links, with what the tip link carries."""

from __future__ import annotations

from collections.abc import Iterable
from xml.etree import ElementTree

import numpy as np

from leadthrough import rotations
from leadthrough.arm import Arm
from leadthrough.arm.attachment import Load
from leadthrough.check import Float64Array

_MOMENTS = (("ixx", "ixy", "ixz"), ("ixy", "iyy", "iyz"), ("ixz", "iyz", "izz"))
_ORIGIN = "0 0 0"


def link_inertias(arm: Arm, *, payload: float) -> dict[str, Load]:
    """The rigid bodies, by the links that they are fixed to, that the arm's joints move."""
    links = ElementTree.fromstring(arm.document).findall("link")
    stated = {link.get("name", ""): link for link in links}
    found = {}
    for name in _moved_links(arm):
        bodies = [_stated(stated[name])]
        if name == arm.tip:
            loads = arm.attachment.loads
            bodies += [
                Load(payload * each.mass, each.center, payload * each.inertia) for each in loads
            ]
        found[name] = _sum(bodies)
    return {name: body for name, body in found.items() if body.mass > 0.0}


def _moved_links(arm: Arm) -> Iterable[str]:
    """The links that are fixed to what one of the arm's joints moves, by whatever branch."""
    robot = arm.robot
    moving = {joint.name for joint in robot.path(arm.base, arm.tip) if joint.kind != "fixed"}
    moved = set()
    for joint in robot.tree:  # parents stand before their children
        if joint.name in moving or (joint.kind == "fixed" and joint.parent in moved):
            moved.add(joint.child)
    return [robot.links[i] for i in sorted(moved)]


def _stated(link: ElementTree.Element) -> Load:
    """The body that a link's <inertial> states; without a mass where there is none."""
    inertial = link.find("inertial")
    if inertial is None:
        return Load(0.0, np.zeros(3), np.zeros((3, 3)))
    origin, mass, tensor = (inertial.find(tag) for tag in ("origin", "mass", "inertia"))
    place, angles = (_numbers(origin, name) for name in ("xyz", "rpy"))
    moments = np.zeros((3, 3))
    if tensor is not None:
        moments = np.array([[float(tensor.get(key, "0")) for key in row] for row in _MOMENTS])
    turned = rotations.to_matrix(rotations.from_euler(angles[None], convention="xyz"))[0]
    return _body(
        float("0" if mass is None else mass.get("value", "0")), place, turned @ moments @ turned.T
    )


def _body(mass: float, center: Float64Array, inertia: Float64Array) -> Load:
    """A load that is not checked: identified tensors of a link need not be those of a body."""
    body = object.__new__(Load)
    vars(body).update(mass=mass, center=center, inertia=inertia)
    return body


def _sum(bodies: list[Load]) -> Load:
    """Rigid bodies as one."""
    mass = sum(body.mass for body in bodies)
    if mass == 0.0:
        return bodies[0]
    center = np.sum([body.mass * body.center for body in bodies], axis=0) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        away = body.center - center
        inertia += body.inertia + body.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return _body(mass, center, inertia)


def _numbers(element: ElementTree.Element | None, name: str) -> Float64Array:
    text = _ORIGIN if element is None else element.get(name, _ORIGIN)
    return np.array([float(word) for word in text.split()])
