"""Motions of a skill that the whole arm can run: the tip gives way where the arm has no room."""

from leadthrough.whole_arm.connection import way_between
from leadthrough.whole_arm.plan_motion import plan_motion
from leadthrough.whole_arm.planned_motion import PlannedMotion

__all__ = ["PlannedMotion", "plan_motion", "way_between"]
