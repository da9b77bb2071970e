"""Mistakes that people make: what is written in place of what, and how it is answered."""

from typing import NamedTuple


class Mistake(NamedTuple):
    """One or several replacements in a scene that is right.

    Attributes:
        old: What is right; several texts where several are replaced.
        new: What is written instead.
        code: Of the answer.
        marked: The text that is marked.
        hint: A part of the hint, or of the message where there is none.
        rest: Codes of what is left after the first edit that is proposed.
    """

    old: str | tuple[str, ...]
    new: str | tuple[str, ...]
    code: str
    marked: str
    hint: str
    rest: tuple[str, ...] = ()

    def made_in(self, scene: str) -> str:
        """Return the scene with the mistake."""
        old, new = (((one,) if isinstance(one, str) else one) for one in (self.old, self.new))
        for right, wrong in zip(old, new, strict=True):
            assert right in scene, right
            scene = scene.replace(right, wrong, 1)
        return scene
