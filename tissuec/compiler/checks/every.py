"""Checks of a compiled scene: one small generator per rule, each yields diagnostics.

All of them are warnings about scenes that can be run but may not mean what their author thinks.
"""

from collections.abc import Callable, Iterator

from tissuec.compiler.checks.coarse_bodies import coarse
from tissuec.compiler.checks.contact_thickness import thin_skins
from tissuec.compiler.checks.laws import unstable_laws
from tissuec.compiler.checks.nets import (
    dangling,
    driving_dashpots,
    floppy,
    late_breaking,
    pieces,
    small_prestress,
    unstable,
    unstable_step,
    zero_lengths,
)
from tissuec.compiler.checks.starts import costly, out_of_balance
from tissuec.compiler.checks.supports import unheld
from tissuec.compiler.checks.threads import passing_threads, passing_tools
from tissuec.compiler.checks.uneven_walls import uneven_walls
from tissuec.compiler.checks.unusual_sizes import unusual_sizes
from tissuec.compiler.checks.usage import (
    buried_openings,
    cuts_in_vain,
    dimensions_in_vain,
    fallbacks,
    idle_shapes,
    ruptures_in_vain,
    silent_rules,
    unfelt_blades,
    unused_parameters,
    unused_sets,
    vain_overrides,
)
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic

Check = Callable[[Compiled], Iterator[Diagnostic]]


def check_all(compiled: Compiled, *, thorough: bool) -> list[Diagnostic]:
    """Return the warnings of every check.

    Args:
        thorough: Whether to make also those that take time, or are useful on request only.
    """
    checks = (*CHECKS, *(THOROUGH if thorough else ()))
    return [finding for check in checks for finding in check(compiled)]


CHECKS: tuple[Check, ...] = (
    pieces,
    dangling,
    zero_lengths,
    small_prestress,
    driving_dashpots,
    unstable_laws,
    unstable_step,
    fallbacks,
    silent_rules,
    unused_parameters,
    unused_sets,
    vain_overrides,
    idle_shapes,
    dimensions_in_vain,
    ruptures_in_vain,
    buried_openings,
    cuts_in_vain,
    unfelt_blades,
    passing_threads,
    passing_tools,
    thin_skins,
    unusual_sizes,
    uneven_walls,
    out_of_balance,
    unheld,
    costly,
)
THOROUGH: tuple[Check, ...] = (late_breaking, coarse, floppy, unstable)
