"""HTML from values: markup is an ``Html``, and all other text is escaped."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby
from typing import Any, TypeAlias

from msgspec import Struct

from tissuec.core.data import printable
from tissuec.core.report import Fact, FactTable, FailedExpectation, Part, Verbatim

#: Elements that have no content and no end.
_VOID = ("img", "meta")


class Html(str):
    """Markup, which is not escaped."""

    __slots__ = ()


#: What an element may contain; None is nothing.
Content: TypeAlias = "Html | str | int | Iterable[Content] | None"


def html(content: Content) -> Html:
    """Return content as markup."""
    match content:
        case None:
            return Html()
        case Html():
            return content
        case str():
            return Html(escape(printable(content)))
        case int():
            return Html(content)
        case _:
            return Html("".join(map(html, content)))


def element(tag: str, /, *content: Content, **attributes: str | int | bool | None) -> Html:
    """Return an element.

    Args:
        content: What is in it.
        attributes: ``class_`` becomes ``class``, ``aria_label`` becomes ``aria-label``; those
            that are None or False are left out.
    """
    written = "".join(_attribute(key, value) for key, value in attributes.items())
    if tag in _VOID:
        return Html(f"<{tag}{written}>")
    return Html(f"<{tag}{written}>{html(content)}</{tag}>")


def _attribute(key: str, value: str | int | bool | None) -> str:
    if value is None or value is False:
        return ""
    name = key.removesuffix("_").replace("_", "-")
    return f" {name}" if value is True else f' {name}="{escape(printable(str(value)))}"'


def link(target: str, *content: Content) -> Html:
    """Return a link within the page."""
    return element("a", *content, href=f"#{target}")


def listing(items: Iterable[Content]) -> Html:
    """Return items as a list."""
    return element("ul", [element("li", item) for item in items])


def table(
    caption: Content,
    heads: Sequence[Content],
    rows: Iterable[Content],
    class_: str | None = None,
) -> Html:
    """Return a table that scrolls by itself where a page is too narrow for it.

    Args:
        caption: What it shows, without a full stop.
        heads: Heads of the columns.
        rows: Markup of ``row``.
        class_: Class of the table.
    """
    head = element("tr", [element("th", text, scope="col") for text in heads])
    body = element(
        "table",
        element("caption", caption, "."),
        element("thead", head),
        element("tbody", rows),
        class_=class_,
    )
    return element(
        "div", body, class_="wide", tabindex="0", role="region", aria_label=_plain(caption)
    )


def _plain(content: Content) -> str | None:
    return content if isinstance(content, str) and not isinstance(content, Html) else None


def row(*cells: Content) -> Html:
    """Return a row of a table whose first cell is its head."""
    first, *others = cells
    return element("tr", element("th", first, scope="row"), [element("td", c) for c in others])


def pairs(entries: Iterable[tuple[Content, Content]], class_: str = "facts") -> Html:
    """Return names with their descriptions."""
    parts = [element("div", element("dt", key), element("dd", value)) for key, value in entries]
    return element("dl", parts, class_=class_)


def folded(summary: Content, *content: Content, **attributes: str | bool | None) -> Html:
    """Return content that is shown when its summary is clicked.

    Args:
        attributes: Attributes of the element.
    """
    return element("details", element("summary", summary), *content, **attributes)


def shown(parts: Iterable[Part]) -> Html:
    """Return parts of a report: sentences as a list, facts as pairs, tables and sections."""
    return html([_shown(kind, [*some]) for kind, some in groupby(parts, type)])


def _shown(kind: type, some: "list[Any]") -> Content:
    """Return parts of one kind that follow each other."""
    if kind is str:
        return listing(some)
    if kind is Fact:
        return pairs((fact.name, fact.text) for fact in some)
    if kind is FailedExpectation:
        return pairs((one.expectation, one.measured) for one in some)
    if kind is FactTable:
        return [table(one.title, one.heads, [row(*c) for c in one.rows]) for one in some]
    if kind is Verbatim:
        return [element("pre", one.text) for one in some]
    titled = ((one.title[:1].upper() + one.title[1:], one.parts) for one in some)
    return [(element("h3", title) if title else None, shown(inner)) for title, inner in titled]


class Section(Struct, frozen=True):
    """A part of the page.

    Attributes:
        key: Its anchor.
        title: Its heading, also in the list of contents.
    """

    key: str
    title: str
    body: Html

    def write(self) -> Html:
        """Return it with its heading."""
        heading = element("h2", self.title, id=f"{self.key}-title")
        return element(
            "section", heading, self.body, id=self.key, aria_labelledby=f"{self.key}-title"
        )
