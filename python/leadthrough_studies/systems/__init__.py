"""Dynamical systems that only the studies use, registered as models of the package.

`leadthrough learn --model fsm-dm` learns one, and `load_skill` reads it. Their papers are known to
us by summaries only; the modules say what is ours.
"""

from leadthrough.models import ModelEntry

_RESTORE = "leadthrough.models.dynamical.skill:from_archive"
FSM_DM = ModelEntry(
    "fsm-dm", "leadthrough_studies.systems.fsm_dm:FSMDM", ("dynamical",), restore=_RESTORE
)
UMIC = ModelEntry("umic", "leadthrough_studies.systems.umic:UMIC", ("dynamical",), restore=_RESTORE)
