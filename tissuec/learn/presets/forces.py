"""Learnt numbers of forces as params, which the block of a force in any scene can name."""

from collections.abc import Iterator

from tissuec.core.names import key_of
from tissuec.lang.words import written_name
from tissuec.learn.fit.outcome import Estimates, Learnt
from tissuec.learn.presets.drafts import LEARNED, LearntNumber, number_of
from tissuec.learn.presets.numerals import learnt as numeral
from tissuec.learn.presets.tissues import remark


def force_params(learnt: Learnt) -> dict[str, LearntNumber]:
    """Return the numbers of forces, by the names of their params: "learned bed stiffness"."""
    return {_name(one): number_of(one, 0) for one in _of_forces(learnt)}


def param_lines(learnt: Learnt) -> list[str]:
    """Return the lines of a preset that declare these params."""
    lines: list[str] = []
    for one in _of_forces(learnt):
        number = number_of(one, 0)
        value = numeral(number.value, number.low, number.high, number.dimension)
        lines.append(f"param {written_name(_name(one))} = {value}  # {remark(number)}")
    return ["", *lines] if lines else []


def _of_forces(learnt: Learnt) -> Iterator[Estimates]:
    return (one for one in learnt.estimates if one.adjust.per == "force")


def _name(estimates: Estimates) -> str:
    adjust = estimates.adjust
    return f"{LEARNED} {key_of(adjust.of)} {adjust.what}"
