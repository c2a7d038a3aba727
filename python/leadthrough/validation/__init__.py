"""Success rate of a skill's motions on an arm, measured on random queries, with its bounds."""

from leadthrough.models import (
    Certificate as Certificate,
    ConfidenceInterval as ConfidenceInterval,
    TargetRegion as TargetRegion,
)
from leadthrough.validation.validate import (
    Failing as Failing,
    SamplingPlan as SamplingPlan,
    Validation as Validation,
    clopper_pearson as clopper_pearson,
    confidence_sequence as confidence_sequence,
    validate as validate,
)
