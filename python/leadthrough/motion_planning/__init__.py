"""Motions of a skill that the whole arm can run: the tip gives way where the arm is blocked."""

from leadthrough.motion_planning.connection import connect_configurations as connect_configurations
from leadthrough.motion_planning.plan_motion import (
    PlannedMotion as PlannedMotion,
    plan_motion as plan_motion,
)
from leadthrough.motion_planning.tip_paths import Query as Query
