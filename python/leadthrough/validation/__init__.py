"""Success rate of a skill's motions on an arm, measured on random queries, with its bounds."""

from leadthrough.models import Certificate, ConfidenceInterval, TargetRegion
from leadthrough.validation.validate import SamplingPlan, validate
from leadthrough.validation.validation import (
    Failing,
    Validation,
    clopper_pearson,
    confidence_sequence,
)

__all__ = [
    "Certificate",
    "ConfidenceInterval",
    "Failing",
    "SamplingPlan",
    "TargetRegion",
    "Validation",
    "clopper_pearson",
    "confidence_sequence",
    "validate",
]
