"""Motions tried on a simulated arm under gravity, friction and a controller."""

from leadthrough.simulation.controllers import (
    CartesianImpedance as CartesianImpedance,
    ComputedTorque as ComputedTorque,
    Controller as Controller,
    JointImpedance as JointImpedance,
    PositionServo as PositionServo,
)
from leadthrough.simulation.drives import Disturbances as Disturbances, Push as Push
from leadthrough.simulation.held_object import (
    HeldSimulation as HeldSimulation,
    simulate_held as simulate_held,
)
from leadthrough.simulation.report import (
    Contact as Contact,
    Finding as Finding,
    SimulationReport as SimulationReport,
)
from leadthrough.simulation.simulate import simulate as simulate
from leadthrough.simulation.simulated_arm import (
    SimulatedArm as SimulatedArm,
    Touch as Touch,
)
