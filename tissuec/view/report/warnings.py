"""Warnings of the compiler."""

from tissuec.core.errors import Diagnostic
from tissuec.view.report.content import ReportContent
from tissuec.view.report.markup import Html, Section, element, html


def section(content: ReportContent) -> Section | None:
    """Return the warnings of the text; None where there are none."""
    warnings = content.recompiled.warnings
    if not warnings:
        return None
    return Section("warnings", "Warnings", html([_one(content, w) for w in warnings]))


def _one(content: ReportContent, warning: Diagnostic) -> Html:
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
