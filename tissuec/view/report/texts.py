"""The texts of a scene on the page, so that any ``file:line`` becomes a link to its line."""

from collections.abc import Mapping

from tissuec.view.report.markup import Html, element, html, link


def file_name(path: str) -> str:
    """Return the last part of a path of any system."""
    return path.replace("\\", "/").rpartition("/")[2]


class Texts:
    """The scene and its imports, by name.

    Attributes:
        texts: The scene first.
        linked: The lines that the page leads to, by name; they must be shown.
    """

    def __init__(self, scene: str, text: str, used: Mapping[str, str]):
        self.scene = scene
        self.texts = {scene: text} | {name: used[name] for name in used if name != scene}
        self.linked: dict[str, set[int]] = {name: set() for name in self.texts}
        self._lines = {name: text.count("\n") + 1 for name, text in self.texts.items()}
        self._keys = {name: f"text-{number}" for number, name in enumerate(self.texts)}

    def key(self, name: str) -> str:
        """Return the anchor of a text."""
        return self._keys[name]

    def anchor(self, name: str, line: int) -> str:
        """Return the anchor of a line."""
        return f"{self._keys[name]}-{line}"

    def link(self, place: str) -> Html:
        """Return ``file:line`` as a link to that line; as text if it is not on the page.

        The scene is shown without the folder that it lay in.
        """
        name, _, digits = place.rpartition(":")
        if name not in self.texts or not digits.isdecimal():
            return html(place)
        line = int(digits)
        if not 1 <= line <= self._lines[name]:
            return html(place)
        self.linked[name].add(line)
        shown = f"{file_name(name)}:{line}" if name == self.scene else place
        return element("span", link(self.anchor(name, line), shown), class_="place")
