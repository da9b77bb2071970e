"""The texts, with a number before each line that other parts of the page link to."""

from collections.abc import Iterator
from itertools import pairwise

from tissuec.core.errors import counted
from tissuec.lsp.semantic_tokens import tokens
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Html, Section, element, folded, html

WHOLE = 3000  # lines of a text that is shown whole
BESIDE = 3  # lines around one that the page leads to
WIDEST = 2000  # characters of a line that are shown

#: Lines from the first one on, by number, and whether they are shown.
Stretch = tuple[int, int, bool]


def section(content: ReportContent) -> Section:
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
