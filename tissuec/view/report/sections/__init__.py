"""The parts of the page: one file each, with one function from ``ReportContent`` to markup."""

from msgspec import Struct

from tissuec.view.report.markup import Html, element


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
