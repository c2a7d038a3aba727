"""MuJoCo's model of an arm against our dynamics and Pinocchio's."""

import mujoco
import numpy as np
import pinocchio
import pytest
from simulation.conftest import HOME, IDEAL, disturbed

import leadthrough as lt
from leadthrough.errors import InvalidRobot
from leadthrough.sanity import ImplausibleInputWarning
from leadthrough.simulation.drives import drives_of
from leadthrough.simulation.model import plant

_FREE = (
    mujoco.mjtDisableBit.mjDSBL_CONTACT
    | mujoco.mjtDisableBit.mjDSBL_LIMIT
    | mujoco.mjtDisableBit.mjDSBL_DAMPER
    | mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
)
MIMICKED = """<robot name="two">
<link name="world"/><link name="one"><inertial><origin xyz="0.2 0 0"/><mass value="1"/>
<inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<link name="two"><inertial><origin xyz="0.1 0.02 0"/><mass value="0.5"/>
<inertia ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
<joint name="one" type="revolute"><parent link="world"/><child link="one"/><axis xyz="0 1 0"/>
<limit lower="-2" upper="2" effort="50" velocity="3"/>
<dynamics damping="0.3" friction="0.2"/></joint>
<joint name="two" type="revolute"><parent link="one"/><child link="two"/><origin xyz="0.4 0 0"/>
<axis xyz="0 1 0"/><limit lower="-2" upper="2" effort="50" velocity="3"/>{mimic}</joint></robot>"""


def model_of(arm, obstacles=()):
    return plant(
        arm,
        obstacles,
        motors=drives_of(arm, IDEAL, 0.001),
        drive_damping=np.zeros(len(arm.joint_names)),
        gravity=np.array([0.0, 0.0, -9.81]),
        period=0.001,
    )


@pytest.mark.parametrize("name", ["panda", "ur3", "tiago", "two"])
def test_torques_and_accelerations_agree_with_our_inverse_dynamics(name):
    """The last one calls its links as its joints, and its root as MuJoCo calls the world."""
    tool = lt.Box((0.1, 0.05, 0.2), (0.02, 0.0, 0.1))
    free = lt.Arm.from_urdf(MIMICKED.format(mimic="")) if name == "two" else lt.Arm.load(name)
    arm = free.with_attached(tool, mass=1.3).with_tool((0.0, 0.01, 0.2))
    made = model_of(arm)
    made.model.opt.disableflags = _FREE
    data = mujoco.MjData(made.model)
    rng = np.random.default_rng(0)
    low, high = np.maximum(arm.limits.lower, -3.0), np.minimum(arm.limits.upper, 3.0)
    for _ in range(20):
        q = rng.uniform(low, high)
        qd, qdd = rng.normal(size=(2, len(q)))
        torques = arm.inverse_dynamics(q, qd, qdd)
        data.qpos[:], data.qvel[:], data.qacc[:] = made.coordinates(q), qd, qdd
        mujoco.mj_inverse(made.model, data)
        assert np.abs(data.qfrc_inverse - torques).max() < 1e-9
        data.qfrc_applied[:] = torques
        mujoco.mj_forward(made.model, data)
        assert np.abs(data.qacc - qdd).max() < 1e-6


def test_torques_agree_with_pinocchio():
    arm = lt.Arm.load("ur3")
    made, model = model_of(arm), pinocchio.buildModelFromXML(arm.document)
    made.model.opt.disableflags = _FREE
    data, other = mujoco.MjData(made.model), model.createData()
    rng = np.random.default_rng(1)
    for q, qd, qdd in rng.uniform(-2.0, 2.0, (20, 3, 6)):
        turned = np.concatenate([q[:5], [np.cos(q[5]), np.sin(q[5])]])  # of a joint without limits
        wanted = pinocchio.rnea(model, other, turned if model.nq == 7 else q, qd, qdd)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, qd, qdd
        mujoco.mj_inverse(made.model, data)
        assert np.abs(data.qfrc_inverse - wanted).max() < 1e-9


def test_an_arm_whose_joints_mimic_others_holds_still():
    arm = lt.Arm.from_urdf(
        MIMICKED.format(mimic='<mimic joint="one" multiplier="-0.5" offset="0.2"/>')
    )
    real = lt.simulation.SimulatedArm(arm, [0.3])
    for _ in range(300):
        real.step(lt.guard.CommandedState(np.array([0.3]), np.zeros(1), np.zeros(1)))
    assert abs(real.q[0] - 0.3) < 1e-3
    assert abs(real.data.qpos[1] - (0.2 - 0.5 * 0.3)) < 1e-3
    assert abs(real.torques[0] - arm.gravity_torques([0.3])[0]) < 0.21  # friction holds a part


def test_friction_and_damping_are_the_urdfs():
    arm = lt.Arm.from_urdf(MIMICKED.format(mimic=""))
    model = model_of(arm).model
    assert np.array_equal(model.dof_frictionloss, [0.2, 0.0])
    assert np.array_equal(model.dof_damping, [0.3, 0.0])


def test_the_lower_of_two_torque_limits_counts():
    arm = lt.Arm.load("panda")
    values = vars(arm.limits) | {"effort": arm.limits.effort * [10, 0.5, 1, 1, 1, 1, 1]}
    changed = lt.Arm.load("panda", limits=lt.arm.JointLimits(**values))
    limits = model_of(changed).model.actuator_forcerange[:, 1]
    assert np.array_equal(limits, [87, 43.5, 87, 87, 12, 12, 12])


def test_the_motors_work_is_what_lifts_and_moves_the_arm(loaded, simulated):
    report = simulated
    q = report.simulated.positions
    weight = loaded.gravity_torques(0.5 * (q[1:] + q[:-1]))
    lifted = (weight * np.diff(q, axis=0)).sum()
    # Torques are constant during a period, over which the work of a moving arm is off by as much.
    assert report.work.sum() == pytest.approx(lifted, abs=0.005 * report.energy.sum())
    assert (report.energy >= report.work).all()


def test_friction_takes_energy(loaded, swing, simulated):
    report = lt.simulate(loaded, swing, disturbances=disturbed(friction=0.5))
    way = np.abs(np.diff(report.simulated.positions, axis=0)).sum(axis=0)
    assert report.work.sum() - simulated.work.sum() == pytest.approx(0.5 * way.sum(), rel=0.05)


def test_an_arm_without_masses_is_refused():
    with pytest.raises(InvalidRobot, match="no link that the arm moves has a mass"):
        lt.simulate(
            lt.Arm.from_urdf(MIMICKED.format(mimic="").replace("inertial", "ignored")),
            lt.JointTrajectory([0.0, 1.0], np.zeros((2, 2))),
        )


def test_all_shapes_are_obstacles_and_what_is_held_counts():
    """A press from above stops at each kind of shape."""
    cube = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 0.05
    faces = [[0, 1, 3], [0, 3, 2], [4, 5, 7], [4, 7, 6], [0, 1, 5], [0, 5, 4]]
    faces += [[2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 3, 7], [1, 7, 5]]
    held = lt.Capsule(0.02, 0.05, (0.0, 0.0, 0.05))
    arm = lt.Arm.load("panda").with_attached(held, mass=0.2)
    tip = arm.forward_kinematics(HOME)[0] - [0.0, 0.0, 0.12]
    shapes = [
        lt.Box((0.1, 0.1, 0.1), tip),
        lt.Sphere(0.05, tip),
        lt.Capsule(0.05, 0.02, tip),
        lt.Cylinder(0.05, 0.1, tip),
        lt.Mesh(cube, faces, tip),
        lt.PointCloud(np.vstack([cube, np.zeros(3)]), 0.04, tip),
    ]
    deep = arm.inverse_kinematics(tip, arm.forward_kinematics(HOME)[1], q0=HOME).q
    way = lt.trajectories.minimum_jerk_time_scaling(np.linspace(0.0, 1.0, 51))
    motion = lt.JointTrajectory(np.linspace(0.0, 0.4, 51), HOME + np.outer(way, deep - HOME))
    for shape in shapes:
        report = lt.simulate(arm, motion, [shape])
        assert report.contacts[0].bodies == ("attached", "obstacle 0"), shape
        assert report.contacts[0].force > 5.0
        assert report.tip_errors.max() > 0.01
        assert not report.ok


def test_inertias_of_no_rigid_body_are_balanced_with_a_warning_that_names_the_link():
    """1, 2 and 4 fall short by 1, of which each principal moment takes a third."""
    broken = MIMICKED.format(mimic="").replace(
        'ixx="0.01" ixy="0.001" ixz="0" iyy="0.02" iyz="0" izz="0.02"',
        'ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.04"',
    )
    with pytest.warns(ImplausibleInputWarning, match=r"^link two: .*0\.01, 0\.02, 0\.04"):
        made = model_of(lt.Arm.from_urdf(broken))
    third = 0.01 / 3.0
    inertia = made.model.body_inertia[made.tip]
    assert sorted(inertia) == pytest.approx([0.01 + third, 0.02 + third, 0.04 - third], abs=1e-9)
