"""Quality of demonstrations: faults, worth for learning, and the goal to demonstrate next."""

from leadthrough.demonstration_quality.judge import (
    Fault as Fault,
    Judgement as Judgement,
    Suggestion as Suggestion,
    Verdict as Verdict,
    judge_demonstrations as judge_demonstrations,
)
