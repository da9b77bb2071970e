"""Where a run comes from: origins of numbers, its texts, how to reproduce and cite it."""

from collections.abc import Iterable, Iterator, Mapping
from itertools import pairwise
from typing import Any, cast
from urllib.parse import quote

from tissuec.compiler.provenance import SET, ProvenanceRow, Reason, tissue_rows, used_tissues
from tissuec.core.errors import Diagnostic, counted
from tissuec.core.report import FactSection
from tissuec.core.version import __version__
from tissuec.lsp.semantic_tokens import tokens
from tissuec.scene.model import Tissue
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.request import run_command, set_options
from tissuec.view.report.content import ReportContent, file_name
from tissuec.view.report.markup import (
    Content,
    Html,
    Section,
    element,
    folded,
    html,
    link,
    pairs,
    row,
    shown,
    table,
)
from tissuec.view.scene_summary import plan_sections


def numbers(content: ReportContent) -> Section:
    """Return params, and the table of each tissue that bodies are made of."""
    words = content.recompiled.words
    if words is None:
        text = (
            "This version cannot read the files of this run, so the origin of numbers is "
            "unknown."
        )
        return Section("numbers", "Origin of the numbers", element("p", text))
    parts = [_params(content, words), *(_tissue(content, one) for one in used_tissues(words))]
    known = [part for part in parts if part is not None]
    body = html(known) if known else element("p", "The scene has neither params nor tissues.")
    return Section("numbers", "Origin of the numbers", body)


def _params(content: ReportContent, words: ResolvedProgram) -> Html | None:
    parameters = words.constants.parameters()
    if not parameters:
        return None
    rows = [
        row(
            one.name,
            str(one.value),
            SET if one.overridden else "written",
            content.texts.link(one.item.span.place),
        )
        for one in parameters
    ]
    heads = ("param", "value", "how", "line")
    return html((element("h3", "Params"), table("Params of the scene", heads, rows)))


def _tissue(content: ReportContent, tissue: Tissue) -> Html:
    heads = ("name", "value", "how", "because", "line")
    rows = [line for one in tissue_rows(tissue) for line in _rows(content, one)]
    missing = [
        element("p", element("b", name), f": none: {reason}")
        for name, reason in tissue.gaps.items()
    ]
    return html(
        (
            element("h3", tissue.name, " ", content.texts.link(tissue.span.place)),
            element("p", tissue.about) if tissue.about else None,
            table(f"Entries of {tissue.name}", heads, rows, "tissue") if rows else None,
            missing,
        )
    )


def _rows(content: ReportContent, entry: ProvenanceRow) -> Iterable[Html]:
    """Yield an entry as one row for each of its reasons."""
    first, *others = entry.reasons
    span = len(entry.reasons) if others else None
    cells = (
        element("th", entry.name, scope="row", rowspan=span),
        element("td", entry.value, rowspan=span),
        element("td", _how(entry), rowspan=span),
    )
    yield element("tr", cells, _reason(content, first), class_=entry.kind)
    for reason in others:
        yield element("tr", _reason(content, reason), class_=entry.kind)


def _how(entry: ProvenanceRow) -> str:
    return f"value: {entry.how}" if entry.kind == "property" else entry.how


def _reason(content: ReportContent, reason: Reason) -> Html:
    bar: Content = None
    if reason.degree is not None:
        # The number is beside it; the bar is for the eye.
        width = f"width:{100.0 * min(max(reason.degree, 0.0), 1.0):.0f}%"
        bar = element("span", element("i", style=width), class_="bar", aria_hidden="true")
    facts = element("small", reason.facts) if reason.facts else None
    because = element("td", bar, reason.said, " " if facts else None, facts)
    return html((because, element("td", content.texts.link(reason.place))))


def plan(content: ReportContent) -> Section:
    """Return the plan; that in the file where the scene cannot be compiled."""
    plan = content.prediction
    if plan is not None:
        return Section("plan", "Plan", shown(plan_sections(plan)))
    text = "Arrays and cost are unknown, because the scene could not be compiled again."
    skipped = content.manifest.get("plan", {}).get("skipped") or ["nothing"]
    parts = (element("p", text), shown([FactSection("skipped", skipped)]))
    return Section("plan", "Plan", html(parts))


LONGEST = 300_000  # characters of a text that can be saved from the page


def again(content: ReportContent) -> Section:
    """Return the command line, the digest of the text, and the text to be saved."""
    return Section(
        "again", "Run it again", html((_commands(content), pairs(_again_facts(content))))
    )


def _commands(content: ReportContent) -> Html:
    manifest = content.manifest
    options = set_options(manifest.get("overrides", ()), manifest.get("libraries", ()))
    lines = [run_command(content.texts.scene, options)]
    if content.facts["can_resume"]:
        lines.append(run_command(content.texts.scene, options, resume=True))
    texts = ("To run it again:", "To resume it:")
    return html(
        [
            (
                element("p", text),
                element("pre", element("code", line), class_="command", tabindex="0"),
            )
            for text, line in zip(texts, lines, strict=False)
        ]
    )


def _again_facts(content: ReportContent) -> list[tuple[Content, Content]]:
    used = [name for name in content.texts.texts if name != content.texts.scene]
    facts: list[tuple[Content, Content]] = [
        ("digest of the scene", element("code", "SHA-256 ", content.manifest["digest"])),
        ("scene", _save(content.texts.scene, content.trajectory.text)),
    ]
    if used:
        saved = [element("li", _save(name, content.texts.texts[name])) for name in used]
        facts.append(("used files", element("ul", saved)))
    for name, digest in content.manifest.get("files", {}).items():
        text = f"not stored in the result; SHA-256 {digest}"
        facts.append((f"file {name}", element("code", text)))
    return facts


def _save(name: str, text: str) -> Html:
    """Return a link under which a text can be saved, unless it would be half of the page."""
    if len(text) > LONGEST:
        python = element("code", "tissuec.load(…).sources")
        return html((f"{file_name(name)} is too long for a page; ", python, " contains it"))
    data = f"data:text/plain;charset=utf-8,{quote(text)}"
    return element("a", f"save {file_name(name)}", href=data, download=file_name(name))


def citing(content: ReportContent) -> Section:
    """Return the citations of the scene, the program and the method."""
    return Section("cite", "Cite as", pairs(_sources(content)))


def _sources(content: ReportContent) -> Iterator[tuple[Content, Content]]:
    manifest = content.manifest
    if text := manifest.get("cite"):
        yield "scene", text
    elif author := manifest.get("author"):
        place = ", ".join(filter(None, (manifest.get("laboratory"), manifest.get("licence"))))
        yield "scene", f"{author}: {content.title}{f' ({place})' if place else ''}."
    yield "program", SOFTWARE
    yield "method", PAPER


def manifest(content: ReportContent) -> Section:
    """Return the whole manifest, folded; texts as links to their places."""
    entries = [(name, _shown(content, name, value)) for name, value in content.manifest.items()]
    count = f"{len(entries)} entries"
    return Section("manifest", "Manifest", folded(count, pairs(entries, "manifest")))


def _shown(content: ReportContent, name: str, value: Any) -> Content:
    if name == "sources" and isinstance(value, Mapping):
        sources = cast("Mapping[str, Any]", value)
        links = [
            element("li", link(content.texts.key(source), source))
            for source in sources
            if source in content.texts.texts
        ]
        return element("ul", links) if links else "none"
    return _nested(value)


def _nested(value: Any) -> Content:
    match value:
        case Mapping() if value:
            entries = cast("Mapping[Any, Any]", value)
            return pairs((str(key), _nested(one)) for key, one in entries.items())
        case list() if value:
            items = cast("list[Any]", value)
            return element("ol", [element("li", _nested(one)) for one in items])
        case Mapping() | list() | None | "":
            return "none"
        case bool():
            return "yes" if value else "no"
        case _:
            return str(value)


def warnings(content: ReportContent) -> Section | None:
    """Return the warnings of the text; None where there are none."""
    warnings = content.recompiled.warnings
    if not warnings:
        return None
    return Section("warnings", "Warnings", html([_warning(content, w) for w in warnings]))


def _warning(content: ReportContent, warning: Diagnostic) -> Html:
    place = content.texts.link(warning.span.place) if warning.span is not None else None
    notes = [
        element("p", one.message, " ", one.span and content.texts.link(one.span.place))
        for one in warning.notes
    ]
    return element(
        "div",
        element("p", element("b", warning.code), f" {warning.message} ", place),
        element("p", "Hint: ", element("code", warning.hint)) if warning.hint else None,
        notes,
        class_="warning",
    )


WHOLE = 3000  # lines of a text that is shown whole
BESIDE = 3  # lines around one that the page leads to

#: Lines from the first one on, by number, and whether they are shown.
Stretch = tuple[int, int, bool]


def texts(content: ReportContent) -> Section:
    """Return the scene, and folded its imports. To be made last, when all links are known."""
    scene, *used = content.texts.texts
    parts: list[Content] = [_text(content, scene)]
    for name in used:
        key = content.texts.key(name)
        parts.append(folded(element("code", name), _text(content, name), id=key, class_="used"))
    return Section("text", "The scene", html(parts))


def _text(content: ReportContent, name: str) -> Html:
    text = content.texts.texts[name]
    lines = colour_lines(text) if name.endswith(".tis") else [html(x) for x in text.split("\n")]
    if lines and not text.rpartition("\n")[2]:
        lines = lines[:-1]  # a line end ends a line and begins none
    linked = content.texts.linked[name]
    rows: list[Content] = []
    for start, stop, is_shown in stretches(len(lines), linked):
        if is_shown:
            rows += (_line(content, name, n, lines[n - 1], linked) for n in range(start, stop))
        else:
            text = f"… {counted(stop - start, 'line')} …\\n"
            rows.append(element("span", text, class_="left-out"))
    label = f"Text of {name}"
    return element("pre", element("code", rows), class_="text", tabindex="0", aria_label=label)


def _line(
    content: ReportContent, name: str, number: int, shown: Html, linked: "set[int]"
) -> Html:
    anchor = content.texts.anchor(name, number)
    digits = element(
        "a", href=f"#{anchor}", class_="digits", data_line=number, aria_label=f"line {number}"
    )
    mark = "line linked" if number in linked else "line"
    return element("span", digits, shown, "\n", id=anchor, class_=mark)


def stretches(count: int, linked: "set[int]") -> Iterator[Stretch]:
    """Yield ranges of lines to show: the beginning of a long text, and linked lines."""
    if count <= WHOLE:
        yield 1, count + 1, True
        return
    shown = set(range(1, WHOLE // 2 + 1)).union(
        *(range(max(one - BESIDE, 1), min(one + BESIDE, count) + 1) for one in linked)
    )
    edges = (n for n in range(2, count + 1) if (n in shown) != (n - 1 in shown))
    for start, stop in pairwise([1, *edges, count + 1]):
        yield start, stop, start in shown


def colour_lines(text: str) -> list[Html]:
    """Return the lines of a text with their words marked by category."""
    lines: list[list[Content]] = [[]]
    for piece, kind in _pieces(text):
        for number, part in enumerate(piece.split("\n")):
            if number:
                lines.append([])
            if part:
                lines[-1].append(element("span", part, class_=f"t-{kind}") if kind else part)
    return [html(line) for line in lines]


def _pieces(text: str) -> Iterator[tuple[str, str]]:
    """Yield all of a text in pieces, each with its kind, "" for none."""
    at = 0
    for start, stop, kind in tokens(text):
        if start > at:
            yield text[at:start], ""
        yield text[start:stop], kind
        at = stop
    yield text[at:], ""


SOFTWARE = (
    f"The tissuec authors: tissuec {__version__}, a tissue-description language, its compiler, "
    "and a validated soft-tissue simulator."
)
PAPER = (
    "A. Nürnberger, A. Radetzky, R. Kruse: The Simulation of Elastic Tissues in Virtual "
    "Medicine Using Neuro-Fuzzy Systems. SPIE Medical Imaging 1998."
)
