"""What a simulation showed, as `leadthrough simulate` and `leadthrough check` print it."""

from __future__ import annotations

from leadthrough.simulation import SimulationReport


def facts(report: SimulationReport, *, as_json: bool) -> dict[str, object]:
    """What a simulation showed, by its names."""
    joint = int(report.torque_fractions.argmax())
    worst = int(abs(report.errors).max(axis=0).argmax())
    name, fraction = report.arm.joint_names[joint], float(report.torque_fractions[joint])
    tip, turn = float(report.tip_errors.max()), float(abs(report.errors[:, worst]).max())
    return {
        "fit_to_run": report.ok,
        "findings": [str(each) for each in report.findings],
        "tip_error": tip if as_json else 1e3 * tip,
        "joint_error": turn if as_json else 1e3 * turn,
        "torque_used": {"ratio": fraction, "joint": name} if as_json else f"{fraction:.0%}, {name}",
        "contacts": [str(each) for each in report.contacts],
        "energy": float(report.energy.sum()),
        "duration": report.planned.duration,
    }
