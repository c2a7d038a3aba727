"""What Lauretti et al. 2023 print of their experiment."""

from __future__ import annotations

# Means over the tasks, by our names of the planners; the paper's own is our "lifted". Its success
# of 100 % is called an improvement of 55.75 over Euler angles and of 24.25 over the plain
# logarithm: points, as we read it.
PRINTED: dict[str, dict[str, float]] = {
    "euler": {"sr_mod": 100.0 - 55.75},
    "log": {"sr_mod": 100.0 - 24.25},
    "lifted": {"npe": 0.05, "noe": 0.07, "sr_mod": 100.0, "plan_s": 2.57e-3},
}
# Tasks and planners whose success is said to be below 40 %.
BELOW_40 = {("harvesting", "euler"), ("seeding", "euler"), ("irrigation", "log")}
SIGNIFICANT = 0.01  # the level of its figure 7, of p after Bonferroni
