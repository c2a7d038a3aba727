"""Calls of the guard: limits per sample of 1, 0.1 and 0.01 rad, two joints."""

import numpy as np
from bindings.calls import call, make, model

from leadthrough import _core as core

ROOMY = np.full(2, 10.0)
limits = make(
    core.StepLimits,
    lower=-ROOMY,
    upper=ROOMY,
    step=np.ones(2),
    bend=np.full(2, 0.1),
    twist=np.full(2, 0.01),
)
REST = np.zeros((3, 2))
SLOW = 0.005 * np.ones((6, 2)) * np.minimum(np.arange(6), 1.0)[:, None]
JUMP = np.array([[0.0, 0.0], [0.0, 2.0]])
SMALL = {"limits": limits, "history": REST}

call(core.first_excess, 1, **SMALL, samples=JUMP)  # the order of the difference
call(core.brake, np.zeros((0, 2)), **SMALL)
call(core.bridge_to_start, SLOW[1:1], **SMALL, target=SLOW, most_steps=10)
call(core.bridge_on_time, SLOW[1:1], **SMALL, target=SLOW, most_steps=10)
call(core.slowed, SLOW, limits=limits, path=SLOW, most_samples=60)
call(core.stopped, None, **SMALL, path=SLOW)
around = make(core.Surroundings, model=model, obstacles=[], growth=[], margin=0.0, self_margin=0.0)
call(core.first_contact, None, around=around, start=np.zeros(2), samples=SLOW, age=0.0)
