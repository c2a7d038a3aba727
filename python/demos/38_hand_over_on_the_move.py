"""Catch a belt's part on the move, ride with it, and leave it at speed."""

import numpy as np

from leadthrough import trajectories as tr

BELT, PERIOD = 0.25, 0.002  # m/s, s


def caught() -> list[tr.FilterState]:
    """The tool along the belt, from rest until it has ridden with the part for half a second."""
    reach = tr.TimeOptimalFilter(velocity=0.8, acceleration=2.0)
    states = [tr.FilterState.at_rest([0.0])]
    riding = 0
    while riding < 0.5 / PERIOD:
        part = 0.3 + BELT * PERIOD * len(states)
        states.append(reach.step(states[-1], [part], PERIOD, velocity=[BELT]))
        riding += abs(states[-1].position[0] - part) < 1e-9
    return states


def main() -> None:
    """Catch the part, then leave at its velocity for where another tool takes over."""
    states = caught()
    last = states[-1]
    limits = {"velocity": 0.8, "acceleration": 2.0, "jerk": 20.0}
    leave = tr.double_s(
        last.position, [1.2], **limits, start_velocity=last.velocity, end_velocity=[0.4]
    )
    fastest = np.abs(leave.evaluate(np.linspace(*leave.domain, 200), 1)).max()
    print(
        f"caught after {PERIOD * len(states) - 0.5:.2f} s, {last.position[0]:.3f} m along the belt"
    )
    print(
        f"handed over {leave.domain[1]:.2f} s later at 0.4 m/s; at most {fastest:.2f} m/s between"
    )


if __name__ == "__main__":
    main()
