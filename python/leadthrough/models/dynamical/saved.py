"""Skills of dynamical systems in files."""

from __future__ import annotations

from typing import Any

from leadthrough import check
from leadthrough.errors import InvalidInput
from leadthrough.models import archive
from leadthrough.models.chart import Chart
from leadthrough.models.dynamical.clf_dm import CLFDM
from leadthrough.models.dynamical.corrected import Corrected
from leadthrough.models.dynamical.fsm_dm import FSMDM
from leadthrough.models.dynamical.kernel_potential import KernelPotential
from leadthrough.models.dynamical.linear_mixture import LinearMixture
from leadthrough.models.dynamical.lpv_ds import LPVDS
from leadthrough.models.dynamical.modified_ds import ModifiedDS
from leadthrough.models.dynamical.seds import SEDS
from leadthrough.models.dynamical.skill import DynamicalSkill
from leadthrough.models.dynamical.umic import UMIC

_MODELS: dict[str, Any] = {
    model.__name__: model for model in (SEDS, LPVDS, CLFDM, FSMDM, UMIC, ModifiedDS)
}
_FIELDS: dict[str, Any] = {
    field.name: field for field in (LinearMixture, Corrected, KernelPotential)
}


# Any: settings are whatever JSON holds.
def from_archive(settings: dict[str, Any], arrays: archive.Arrays) -> DynamicalSkill:
    """The skill from the settings and arrays that `DynamicalSkill.to_archive` returned."""
    chart = Chart.from_archive(settings, arrays)
    model = _MODELS[settings["name"]](**settings["model"])
    own = {
        name.removeprefix("field_"): check.frozen(value, name, shape=value.shape)
        for name, value in arrays.items()
        if name.startswith("field_")
    }
    field = _FIELDS[settings["field"]].from_arrays(own)
    if field.size != chart.width:
        raise InvalidInput(f"field: expected {chart.width} columns, got {field.size}")
    return DynamicalSkill(
        model,
        chart,
        field,
        check.frozen(arrays["scale"], "scale", shape=(chart.width,)),
        check.frozen(arrays["ends"], "ends", shape=(2, chart.width)),
        check.number(settings["duration"], "duration", above=0.0),
        check.number(settings["pace"], "pace", above=0.0),
        check.frozen(arrays["positions"], "positions", shape=("n", chart.width)),
    )
