"""Exact derivatives beside those by differences."""

from collections.abc import Sequence

from tissuec.core.errors import counted
from tissuec.learn.learning import Compared
from tissuec.learn.telling.rows import aligned

HEADINGS = ("derivative by", "exact", "by differences", "relative difference")


def as_lines(lesson: str, found: Sequence[Compared], allowed: float) -> list[str]:
    """Return a table of derivatives and the verdict on the worst of them."""
    rows = [(n, f"{a:+.9e}", f"{b:+.9e}", f"{apart:.1e}") for n, a, b, apart in found]
    worst = max((one.apart for one in found), default=0.0)
    verdict = "good" if worst <= allowed else "WRONG"
    count = counted(len(found), "direction")
    last = f"{count}, at worst {worst:.1e}, allowed {allowed:g}"
    return [*aligned([HEADINGS, *rows]), f"learn {lesson}: derivatives are {verdict}: {last}"]
