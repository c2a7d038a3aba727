"""Pinocchio's model of an arm, to compare kinematics and dynamics with."""

from xml.etree import ElementTree

import numpy as np
import pinocchio as pin


class Peer:
    """Pinocchio's model of a robot in which nothing but the arm moves."""

    def __init__(self, arm, path, locked):
        whole = pin.buildModelFromUrdf(str(path))
        place = pin.neutral(whole)
        standing = locked | _followers(path, locked)
        for name, value in standing.items():
            self.put(whole, place, name, value)
        fixed = [whole.getJointId(name) for name in standing]
        self.model = pin.buildReducedModel(whole, fixed, place)
        self.data = self.model.createData()
        self.names = arm.joint_names
        self.order = [self.model.joints[self.model.getJointId(name)].idx_v for name in self.names]
        self.base, self.tip = arm.base, arm.tip

    @staticmethod
    def put(model, place, name, value):
        joint = model.joints[model.getJointId(name)]
        whole = value if joint.nq == 1 else (np.cos(value), np.sin(value))
        place[joint.idx_q : joint.idx_q + joint.nq] = whole

    def add_load(self, mass, center, inertia, tool=None):
        frame = self.model.frames[self.model.getFrameId(self.tip)]
        placement = frame.placement if tool is None else frame.placement * tool
        body = pin.Inertia(mass, np.array(center, float), np.array(inertia, float))
        self.model.appendBodyToJoint(frame.parentJoint, body, placement)
        self.data = self.model.createData()

    def configuration(self, q):
        place = pin.neutral(self.model)
        for name, value in zip(self.names, q, strict=True):
            self.put(self.model, place, name, value)
        return place

    def rates(self, values):
        speeds = np.zeros(self.model.nv)
        speeds[self.order] = values
        return speeds

    def torques(self, q, qd, qdd, gravity=(0.0, 0.0, -9.81)):
        self.model.gravity.linear = np.array(gravity, float)
        place = self.configuration(q)
        return pin.rnea(self.model, self.data, place, self.rates(qd), self.rates(qdd))[self.order]

    def gravity(self, q):
        place = self.configuration(q)
        return pin.computeGeneralizedGravity(self.model, self.data, place)[self.order]

    def mass_matrix(self, q):
        upper = np.triu(pin.crba(self.model, self.data, self.configuration(q)))
        return (upper + np.triu(upper, 1).T)[np.ix_(self.order, self.order)]

    def pose(self, q):
        """Of the tip in the base's frame."""
        pin.framesForwardKinematics(self.model, self.data, self.configuration(q))
        base, tip = (self.data.oMf[self.model.getFrameId(name)] for name in (self.base, self.tip))
        return base.actInv(tip)

    def jacobian(self, q):
        """Of the tip, linear rows first, in the base's frame."""
        pin.computeJointJacobians(self.model, self.data, self.configuration(q))
        pin.updateFramePlacements(self.model, self.data)
        back = self.data.oMf[self.model.getFrameId(self.base)].rotation.T
        return np.kron(np.eye(2), back) @ self._columns(pin.getFrameJacobian)

    def jacobian_derivative(self, q, qd):
        """In time, of a robot whose base is not rotated."""
        place = self.configuration(q)
        pin.computeJointJacobiansTimeVariation(self.model, self.data, place, self.rates(qd))
        pin.updateFramePlacements(self.model, self.data)
        return self._columns(pin.getFrameJacobianTimeVariation)

    def _columns(self, matrix):
        tip = self.model.getFrameId(self.tip)
        return matrix(self.model, self.data, tip, pin.LOCAL_WORLD_ALIGNED)[:, self.order]


def _followers(path, values):
    """The values of the joints that mimic these."""
    joints = ElementTree.parse(path).getroot().findall("joint[mimic]")
    mimics = {joint.get("name"): joint.find("mimic").attrib for joint in joints}
    return {
        name: float(mimic.get("multiplier", 1)) * values[mimic["joint"]]
        + float(mimic.get("offset", 0))
        for name, mimic in mimics.items()
        if mimic["joint"] in values
    }
