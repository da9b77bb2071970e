"""Logs and energies over time."""

from tissuec.report.markup import element
from tissuec.report.sections import Section
from tissuec.report.story import Story


def section(story: Story) -> Section | None:
    """Return the plots of everything that was logged; None where nothing was."""
    return Section("curves", "Logs and energies", element("p", "…"))
