"""Warnings of the compiler."""

from tissuec.core.errors import Diagnostic
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Html, element, html
from tissuec.view.report.sections import Section


def section(story: ReportContent) -> Section | None:
    """Return the warnings of the text; None where there are none."""
    warnings = story.retelling.warnings
    if not warnings:
        return None
    return Section("warnings", "Warnings", html([_one(story, w) for w in warnings]))


def _one(story: ReportContent, warning: Diagnostic) -> Html:
    place = story.texts.link(warning.span.place) if warning.span is not None else None
    notes = [
        element("p", one.message, " ", one.span and story.texts.link(one.span.place))
        for one in warning.notes
    ]
    return element(
        "div",
        element("p", element("b", warning.code), f" {warning.message} ", place),
        element("p", "Hint: ", element("code", warning.hint)) if warning.hint else None,
        notes,
        class_="warning",
    )
