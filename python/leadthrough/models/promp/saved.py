"""ProMP skills as the settings and arrays of a file."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from leadthrough.models.archive import Arrays

if TYPE_CHECKING:
    from leadthrough.models.promp.skill import ProMPSkill


# Any: settings are whatever JSON holds.
def taken_apart(skill: ProMPSkill) -> tuple[dict[str, Any], Arrays]:
    """Settings and arrays that `model.from_archive` turns into the skill again."""
    settings = {
        "model": asdict(skill.model),
        "duration": skill.duration,
        **skill.chart.settings(),
    }
    arrays = {
        "mean": skill.free.mean,
        "covariance": skill.free.covariance,
        "noise": skill.noise,
        "scale": skill.scale,
        **skill.chart.arrays(),
    }
    if skill.bounds is not None:
        arrays["lower"], arrays["upper"] = skill.bounds
        settings["truncated"] = True
    if skill.experience is not None:
        arrays["curves"], arrays["paces"] = skill.experience.curves, skill.experience.paces
    return settings, arrays
