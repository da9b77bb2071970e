"""The report on natural modes."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from tissuec.analysis.vibration.frames import in_words
from tissuec.analysis.vibration.modes import Mode, Modes
from tissuec.core.report import Fact, FactTable, Part, Report
from tissuec.core.units import TIME, show

HEAD = ("mode", "frequency", "period", "damping ratio", "kinetic energy")


def modes_report(modes: Modes, file: Path | None = None) -> Report:
    """Return the report on modes.

    Args:
        modes: The modes.
        file: The result file that shows them, if one was written.
    """
    parts: list[Part] = [FactTable(HEAD, [*map(_row, modes)], least=(6, 12, 10, 15))]
    parts += [Fact("note", note, "remark") for note in modes.notes]
    if file is not None:
        parts.append(Fact("", f"wrote {file}", "remark"))
    return Report(parts, {**as_dict(modes), "file": file})


def _row(mode: Mode) -> tuple[str, ...]:
    # Rounding leaves next to nothing of what is not damped.
    ratio = "" if mode.damping_ratio is None else f"{round(mode.damping_ratio, 12):.3g}"
    period = "" if mode.period is None else show(mode.period, TIME)
    return str(mode.number), in_words(mode), period, ratio, _shares(mode.shares)


def _shares(shares: Mapping[str, float]) -> str:
    """Return the bodies with a per cent of the energy or more, the largest share first."""
    ranked = sorted(shares.items(), key=lambda item: -item[1])
    return ", ".join(f"{name} {100 * share:.0f} %" for name, share in ranked if share >= 0.005)


def as_dict(modes: Modes) -> dict[str, Any]:
    """Return modes as plain data in SI units, without their shapes."""
    return {
        "free_nodes": modes.free_nodes,
        "modes": [
            {
                "mode": mode.number,
                "kind": mode.kind,
                "frequency": mode.frequency,
                "period": mode.period,
                "growth": mode.growth,
                "damping_ratio": mode.damping_ratio,
                "shares": dict(mode.shares),
            }
            for mode in modes
        ],
        "notes": list(modes.notes),
    }
