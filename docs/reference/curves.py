"""Published curves of the presets of matter beside those of their laws, as Markdown."""

from collections.abc import Iterator

import numpy as np

from tissuec.analysis.lab import homogeneous, solid_tests
from tissuec.analysis.lab.bench import TestBench
from tissuec.analysis.lab.closed_form import LawCurve
from tissuec.analysis.lab.rows import LabCurve, TestRow, curve_rows
from tissuec.compiler.provenance import cited
from tissuec.core.markdown import table
from tissuec.core.resources import library
from tissuec.core.units import NUMBER
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.scene.tissues.known_curves import COMPRESSION

_STEP = 1e-9  # [s] of a ramp, which is sudden


def parts() -> dict[str, str]:
    """Return every generated part by its name."""
    return {"curves of matter": curve_table()}


def curve_table() -> str:
    """Return each known curve of each preset, with what its law gives at every place."""
    rows: list[tuple[str, ...]] = []
    for path in sorted((library() / "matter").glob("*.tis")):
        request = Request.file(path)
        for tissue in read_words(request)[0].tissues.values():
            if tissue.span.source.name != request.source.name:
                continue
            curves = curves_by_law(TestBench(request, tissue, spacing=1.0))
            rows += [(tissue.name, *_cells(curve)) for curve in curves]
    return table(("tissue", "curve", "law", "published", "verdict", "source"), rows)


def _cells(curve: LabCurve) -> tuple[str, ...]:
    (known,) = curve.known
    (row,) = curve_rows("", curve, "it tears")
    values = (curve.at(place)[0] for place in known.places)
    limits = zip(known.low, known.high, strict=True)
    places = ", ".join(known.shown_place(place) for place in known.places)
    return (
        f"{known.name} at {places}",
        ", ".join(_shown(row, value) for value in values),
        ", ".join(
            _shown(row, low) if low == high else f"{_shown(row, low)} to {_shown(row, high)}"
            for low, high in limits
        ),
        row.verdict,
        cited(known),
    )


def _shown(row: TestRow, value: float) -> str:
    """Return a stress with three digits, or a share in percent."""
    is_share = row.dimension == NUMBER
    return f"{100.0 * value:.3g} %" if is_share else row.shown(float(f"{value:.3g}"))


def curves_by_law(bench: TestBench) -> Iterator[LabCurve]:
    """Yield the known curves of a tissue, each by the closed form of its law."""
    law = LawCurve.of(bench.tissue)
    for known in bench.tissue.curves:
        if not known.mode:
            place, branches = np.array(known.places), solid_tests.branches_of(bench)
            value = np.ones_like(place)
            if branches:
                value = solid_tests.left_by_law(branches, _STEP, place)
        else:
            limit = homogeneous.limits_in(bench, law, known.mode).strain
            within = [one for one in known.places if one <= limit]
            start = 0.0 if known.mode == COMPRESSION else homogeneous.SMALL
            place = np.array(within)
            value = law.stress(known.mode, [start, *within])[1:] if within else np.zeros(0)
        yield LabCurve(known.mode, place, value, value, (known,))
