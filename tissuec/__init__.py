"""tissuec: a tissue-description language, its compiler, and a validated soft-tissue simulator.

From Python: ``tissuec.run("tube.tis")``, ``load``, ``check``, ``compile``, ``modes``,
``properties``, ``examine``, ``start``, ``study`` and ``read_table``. The module of each
of these names is imported when the name is first used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tissuec.api import (
        check,
        compile,
        environment,
        examine,
        load,
        modes,
        properties,
        run,
        start,
        study,
    )
    from tissuec.api.notebook import Trajectory
    from tissuec.api.study_table import StudyTable, read_table
    from tissuec.core.errors import (
        CompileError,
        Diagnostic,
        ExpectationError,
        SimulationError,
        TissueError,
        TissueWarning,
    )
    from tissuec.core.version import __version__
    from tissuec.results import PlaceError, ResultError

__all__ = [
    "CompileError",
    "Diagnostic",
    "ExpectationError",
    "PlaceError",
    "ResultError",
    "SimulationError",
    "StudyTable",
    "TissueError",
    "TissueWarning",
    "Trajectory",
    "__version__",
    "check",
    "compile",
    "environment",
    "examine",
    "load",
    "modes",
    "properties",
    "read_table",
    "run",
    "start",
    "study",
]

_HOMES = {
    "tissuec.api": (
        "check",
        "compile",
        "environment",
        "examine",
        "load",
        "modes",
        "properties",
        "run",
        "start",
        "study",
    ),
    "tissuec.results": ("PlaceError", "ResultError"),
    "tissuec.core.version": ("__version__",),
    "tissuec.api.notebook": ("Trajectory",),
    "tissuec.api.study_table": ("StudyTable", "read_table"),
}
_ERRORS = "tissuec.core.errors"


def __getattr__(name: str) -> object:
    if name not in __all__:
        raise AttributeError(f'module "{__name__}" has no attribute "{name}"')
    home = next((home for home, names in _HOMES.items() if name in names), _ERRORS)
    value = globals()[name] = getattr(import_module(home), name)
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
