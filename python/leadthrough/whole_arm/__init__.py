"""Motions of a skill that the whole arm can run: the tip gives way where the arm has no room."""

from leadthrough.whole_arm.connection import way_between
from leadthrough.whole_arm.plan_motion import plan_motion
from leadthrough.whole_arm.planned_motion import PlannedMotion
from leadthrough.whole_arm.query import Query

__all__ = ["PlannedMotion", "Query", "plan_motion", "way_between"]
