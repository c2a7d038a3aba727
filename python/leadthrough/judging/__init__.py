"""What each demonstration is worth: which are faulty or unlike the others, what to show next."""

from leadthrough.judging.judge import judge_demonstrations
from leadthrough.judging.judgement import Fault, Judgement, Suggestion, Verdict

__all__ = ["Fault", "Judgement", "Suggestion", "Verdict", "judge_demonstrations"]
