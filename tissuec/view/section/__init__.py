"""Planes that cut bodies open in pages and pictures."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tissuec.view.section.plane import SectionPlane


def read_plane(text: str) -> "SectionPlane":
    """Return the plane that a text describes, in the words of cuts or as "z = 6 mm".

    Raises:
        ValueError: It describes none; says where and what to write.
    """
    from tissuec.view.section.written_plane import plane_of  # late: it needs the language

    return plane_of(text)
