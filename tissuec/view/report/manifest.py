"""The manifest of the file."""

from collections.abc import Mapping
from typing import Any, cast

from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Content, Section, element, folded, link, pairs


def section(content: ReportContent) -> Section:
    """Return the whole manifest, folded; texts as links to where they stand."""
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
