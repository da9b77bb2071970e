"""``close``: jaws that move towards each other."""

from typing import ClassVar

from tissuec.script.verbs import VERBS
from tissuec.script.verbs.jaws import JawMotion


@VERBS.member("close")
class Close(JawMotion, frozen=True):
    """Closes the jaws of forceps by a length, half of it each, across both.

    The forceps must not be moved as a whole at the same time. What lies between the jaws is
    held by friction only, as long as that bears; the forces on them are those of contact.
    """

    forms: ClassVar[tuple[str, ...]] = ("close TOOL by LENGTH using PROFILE",)
    apart: ClassVar[bool] = False
