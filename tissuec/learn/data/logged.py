"""Logs in files of runs that belong to a fit, and conversion of their numbers."""

import re
from collections.abc import Iterable

from tissuec.model.network import Floats
from tissuec.script.fit_problem import Fit
from tissuec.script.measures import MEASURES

POSITION = "position"
_SIGNS = re.compile(r"[\W_]+")
_JOINING = ("of", "to")


def is_position(fit: Fit) -> bool:
    """Return whether the mean place of a set is fitted."""
    return fit.measure is MEASURES[POSITION]


def title_of(fit: Fit) -> str:
    """Return the name of the log of a fit: "force of pressed"."""
    key = next((name for name, measure in MEASURES.items() if measure is fit.measure), "")
    subjects = " to ".join(one.name for one in fit.subjects)
    return f"{key} of {subjects}" if subjects else key


def find_log(fit: Fit, names: Iterable[str]) -> str | None:
    """Return which of the logs of a file is that of a fit, however it is spelled."""
    wanted = [_plain(title_of(fit)), _plain(fit.text)]
    wanted += [_plain(column.name) for column in fit.columns[:1]]
    known = {_plain(name): name for name in reversed(list(names))}
    return next((known[name] for name in wanted if name in known), None)


def _plain(name: str) -> str:
    words = _SIGNS.sub(" ", name.lower()).split()
    return " ".join(word for word in words if word not in _JOINING)


def as_measured(fit: Fit, components: Floats) -> Floats:
    """Return the values that a fit compares.

    Args:
        components: Of its measure in SI units, shape (row, component).

    Returns:
        What is along a direction, or the one number, shape (row,); all components of a
        position and of what tables name three columns of, shape (row, 3).
    """
    width = components.shape[1]
    if fit.along is not None and width > 1:
        return fit.part(components)
    if width == 1:
        return components[:, 0]
    if width == 3 and (is_position(fit) or len(fit.columns) == 3):
        return components
    assert fit.measure is not None
    return fit.measure.value(components)
