"""The page about tissues: searchable, readable without a network, made of examinations."""

import re
from collections.abc import Iterable, Iterator, Sequence
from math import isfinite, isnan
from pathlib import Path

from tissuec.analysis.lab.rows import Examination, TestRow
from tissuec.compiler.provenance import ProvenanceRow, cited, tissue_rows
from tissuec.core.version import __version__
from tissuec.scene.model import KnownQuantity
from tissuec.scene.tissues.known_curves import ALONG, TENSION
from tissuec.view.report.atlas_chart import chart, thinned
from tissuec.view.report.markup import Content, Html, element, link, row, table
from tissuec.view.report.page import ALONE, colours, stylesheet

_HERE = Path(__file__).parent
_POINTS = 60  # of a curve in a drawing
_OVERVIEW = ("Young's modulus", "density", "breaking strain")


def render(examined: Sequence[Examination], title: str) -> str:
    """Return the whole HTML document about tissues.

    Args:
        examined: Laboratory results of each.
        title: Title of the page.
    """
    names = _anchors(examined)
    main = element(
        "main",
        element("h1", title),
        element("p", _counted(examined), class_="about"),
        _search(examined),
        _overview(examined, names),
        [_article(one, name) for one, name in zip(examined, names, strict=True)],
        element("p", "No tissue matches.", id="nothing", hidden=True),
    )
    head = element(
        "head",
        element("meta", charset="utf-8"),
        element("meta", name="viewport", content="width=device-width, initial-scale=1"),
        element("meta", name="color-scheme", content="light dark"),
        element("meta", http_equiv="Content-Security-Policy", content=ALONE),
        element("title", title),
        element("style", Html(colours() + stylesheet() + _file("atlas.css"))),
    )
    body = element(
        "body",
        element("div", _contents(examined, names), main, class_="page"),
        element("footer", element("p", f"Made by tissuec lab {__version__}.")),
        element("script", Html(_file("atlas.js"))),
    )
    return f"<!doctype html>\n{element('html', head, body, lang='en')}\n"


def _anchors(examined: Sequence[Examination]) -> list[str]:
    """Return a unique name in the page for each tissue."""
    found: list[str] = []
    for one in examined:
        name = "-".join(one.tissue.name.lower().split())
        count = sum(other == name or other.startswith(f"{name}--") for other in found)
        found.append(f"{name}--{count + 1}" if count else name)
    return found


def _counted(examined: Sequence[Examination]) -> str:
    rows = [row for one in examined for row in one.rows]
    sources = {known.source for one in examined for known in one.tissue.known}
    sources |= {known.source for one in examined for known in one.tissue.curves}
    wrong = sum(not one.is_good for one in examined)
    verdict = f"contradictions in {wrong}" if wrong else "no contradiction"
    return (
        f"{len(examined)} {'tissue' if len(examined) == 1 else 'tissues'}, {len(rows)} "
        f"measurements in the virtual laboratory, {len(sources)} sources: {verdict}."
    )


def _search(examined: Sequence[Examination]) -> Html | None:
    if len(examined) < 2:
        return None
    field = element(
        "input", id="search", type="search", autocomplete="off",
        placeholder="name, word or source, such as: soft friable",
    )  # fmt: skip
    label = element("label", "Search", for_="search")
    return element("p", label, field, element("output", id="found"), class_="search")


def _contents(examined: Sequence[Examination], names: Sequence[str]) -> Html:
    items = [
        element("li", link(name, one.tissue.name), data_for=name)
        for one, name in zip(examined, names, strict=True)
    ]
    return element("nav", element("ol", items), aria_label="Tissues")


def _overview(examined: Sequence[Examination], names: Sequence[str]) -> Html | None:
    if len(examined) < 2:
        return None
    rows = [
        element(
            "tr",
            element("th", _swatch(one), link(name, one.tissue.name), scope="row"),
            [element("td", _number(one, quantity)) for quantity in _OVERVIEW],
            element("td", ", ".join(fact.written for fact in one.tissue.facts)),
            element("td", _mark(one)),
            data_for=name,
        )
        for one, name in zip(examined, names, strict=True)
    ]
    return table("All tissues", ("tissue", *_OVERVIEW, "words", "verdict"), rows)


def _number(examined: Examination, quantity: str) -> str:
    rows = [one for one in examined.rows if one.quantity == quantity]
    return rows[0].shown(rows[0].measured) if rows else "–"


def _swatch(examined: Examination) -> Html | None:
    colour = examined.tissue.appearance.colour
    style = f"background:{colour}"
    return element("i", class_="swatch", style=style, aria_hidden="true") if colour else None


def _mark(examined: Examination) -> Html:
    wrong = sum(not row.is_good for row in examined.rows)
    text = f"{wrong} of {len(examined.rows)} not good" if wrong else "good"
    return element("span", text, class_=f"mark {'bad' if wrong else 'good'}")


# --- one tissue -------------------------------------------------------------------------------


def _article(examined: Examination, name: str) -> Html:
    tissue = examined.tissue
    entries = tissue_rows(tissue)
    heading = element("h2", _swatch(examined), tissue.name, id=f"{name}-title")
    described = f"Described in {tissue.vocabulary}." if tissue.vocabulary else None
    return element(
        "section",
        heading,
        element("p", tissue.about, class_="about") if tissue.about else None,
        element("p", _mark(examined), " ", element("small", _short(tissue.span.place))),
        _words(entries, described),
        element("div", [*_charts(examined)], class_="charts"),
        _rows(examined),
        _numbers(entries),
        [element("p", note, class_="remark") for note in examined.notes],
        id=name,
        class_="tissue-page",
        aria_labelledby=f"{name}-title",
        data_text=" ".join(_searched(examined)).lower(),
    )


def _searched(examined: Examination) -> Iterator[str]:
    """Yield all texts by which a tissue is found."""
    tissue = examined.tissue
    yield from (tissue.name, tissue.about, tissue.vocabulary)
    yield from (f"{fact.property} {fact.written}" for fact in tissue.facts)
    yield from (one.source for one in (*tissue.known, *tissue.curves))
    yield from (f"known {one.quantity.name}" for one in tissue.known)
    yield from (f"known {one.name}" for one in tissue.curves)
    yield from (f"{row.test} {row.quantity}" for row in examined.rows)
    yield "good" if examined.is_good else "contradiction"


def _words(entries: Iterable[ProvenanceRow], described: str | None) -> Content:
    facts = [one for one in entries if one.kind == "property"]
    if not facts:
        return None
    parts = [
        element("div", element("dt", one.name), element("dd", one.value), title=one.how)
        for one in facts
    ]
    return element("dl", parts, class_="words"), element("p", described, class_="remark")


def _numbers(entries: Iterable[ProvenanceRow]) -> Content:
    """Return the table of quantities, laws and evidence."""
    rows = [
        element(
            "tr",
            element("th", one.name, scope="row"),
            element("td", one.value),
            element("td", one.how),
            element("td", [element("div", r.said) for r in one.reasons if r.said]),
            element("td", _short(one.reasons[0].place), class_="place"),
            class_=one.kind,
        )
        for one in entries
        if one.kind != "property"
    ]
    heads = ("number", "value", "from", "by words, or rules", "line")
    return table("Numbers, laws and evidence", heads, rows)


def _short(place: str) -> str:
    """Return file and line without folders, which mean nothing to other readers of the page."""
    return re.split(r"[/\\]", place)[-1]


def _charts(examined: Examination) -> Iterator[Html]:
    torn = {
        row.quantity: row.measured
        for row in examined.rows
        if row.test in ("tearing", "rupture")
    }
    ends = torn.get("breaking strain", float("nan")), torn.get("strength", float("nan"))
    for curve in examined.curves:
        is_torn = curve.mode in (TENSION, ALONG) and all(map(isfinite, ends))
        if len(curve.place):
            yield chart(thinned(curve, _POINTS), ends if is_torn else None)


def _rows(examined: Examination) -> Html:
    rows = [
        row(
            one.test, one.quantity, one.shown(one.measured), _check(one),
            "" if one.given is None else one.shown(one.given),
            [_known(known) for known in one.known],
            element("span", one.verdict, class_=f"mark {'good' if one.is_good else 'bad'}"),
        )
        for one in examined.rows
    ]  # fmt: skip
    heads = ("test", "quantity", "measured", "check", "given", "known", "verdict")
    return table("Measured in the laboratory", heads, rows, "measurements")


def _check(measured: TestRow) -> str:
    return "" if isnan(measured.check) else measured.shown(measured.check)


def _known(known: KnownQuantity) -> Html:
    return element("div", known.shown, element("small", cited(known)))


def _file(name: str) -> str:
    return (_HERE / name).read_text(encoding="utf-8")
