"""Motions tried on a simulated arm under gravity, friction and a controller."""

from leadthrough.simulation.controllers import (
    CartesianImpedance,
    ComputedTorque,
    Controller,
    JointImpedance,
    PositionServo,
)
from leadthrough.simulation.report import Contact, Finding, SimulationReport
from leadthrough.simulation.simulate import simulate
from leadthrough.simulation.simulated_arm import Disturbances, Push, SimulatedArm, Touch

__all__ = [
    "CartesianImpedance",
    "ComputedTorque",
    "Contact",
    "Controller",
    "Disturbances",
    "Finding",
    "JointImpedance",
    "PositionServo",
    "Push",
    "SimulatedArm",
    "SimulationReport",
    "Touch",
    "simulate",
]
