"""Quality of demonstrations: faults, worth for learning, and the goal to demonstrate next."""

from leadthrough.demonstration_quality.judge import (
    Fault,
    Judgement,
    Suggestion,
    Verdict,
    judge_demonstrations,
)

__all__ = ["Fault", "Judgement", "Suggestion", "Verdict", "judge_demonstrations"]
