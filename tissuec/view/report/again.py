"""The command that runs the scene again."""

from urllib.parse import quote

from tissuec.results import wording
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, Section, element, html, pairs
from tissuec.view.report.texts import file_name

LONGEST = 300_000  # characters of a text that can be saved from the page


def section(content: ReportContent) -> Section:
    """Return the command line, the digest of the text, and the text to be saved."""
    return Section("again", "Run it again", html((_commands(content), pairs(_facts(content)))))


def _commands(content: ReportContent) -> Html:
    manifest = content.manifest
    options = wording.set_options(manifest.get("overrides", ()), manifest.get("libraries", ()))
    lines = [wording.command(content.texts.scene, options)]
    if content.facts["can_resume"]:
        lines.append(wording.command(content.texts.scene, options, resume=True))
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


def _facts(content: ReportContent) -> list[tuple[Content, Content]]:
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
