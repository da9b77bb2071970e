"""How to reproduce and cite a run: commands, texts, warnings, sources and the manifest."""

from collections.abc import Iterator, Mapping
from typing import Any, cast
from urllib.parse import quote

from tissuec.core.citation import PAPER, SOFTWARE
from tissuec.core.errors import Diagnostic
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
)

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
