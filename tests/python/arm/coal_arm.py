"""An arm's collision shapes in coal, to compare with."""

import itertools
from collections import defaultdict

import coal
import numpy as np
import pinocchio as pin

from leadthrough.arm.robots import find_robot


class CoalArm:
    """coal, through Pinocchio, with the URDF's own shapes."""

    def __init__(self, name):
        urdf = str(find_robot(name).urdf)
        self.model = pin.buildModelFromUrdf(urdf)
        self.geometry = pin.buildGeomFromUrdf(self.model, urdf, pin.GeometryType.COLLISION)
        self.data = self.model.createData()
        self.geometry_data = self.geometry.createData()
        self.shapes = defaultdict(list)
        for shape in self.geometry.geometryObjects:
            self.shapes[shape.name.rpartition("_")[0]].append(shape)

    def place(self, q):
        full = pin.neutral(self.model)
        for joint, value in zip(list(self.model.joints)[1:], q, strict=True):
            whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
            full[joint.idx_q : joint.idx_q + joint.nq] = whole
        pin.updateGeometryPlacements(self.model, self.data, self.geometry, self.geometry_data, full)

    def pose(self, shape):
        return self.geometry_data.oMg[self.geometry.getGeometryId(shape.name)]

    def link_distance(self, a, b):
        return min(
            distance(x.geometry, self.pose(x), y.geometry, self.pose(y))
            for x, y in itertools.product(self.shapes[a], self.shapes[b])
        )

    def moving_links(self):
        return {
            shape.name.rpartition("_")[0]
            for shape in self.geometry.geometryObjects
            if shape.parentJoint > 0
        }

    def distance_to(self, links, geometry, pose):
        return min(
            distance(shape.geometry, self.pose(shape), geometry, pose)
            for link in links
            for shape in self.shapes[link]
        )


def distance(a, pose_a, b, pose_b):
    place = [coal.Transform3s(pose.rotation, pose.translation) for pose in (pose_a, pose_b)]
    request = coal.DistanceRequest()
    request.gjk_tolerance = request.epa_tolerance = 1e-8
    return coal.distance(a, place[0], b, place[1], request, coal.DistanceResult())
