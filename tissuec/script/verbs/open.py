"""``open``: jaws that move apart."""

from typing import ClassVar

from tissuec.script.verbs import VERBS
from tissuec.script.verbs.jaws import JawMotion


@VERBS.member("open")
class Open(JawMotion, frozen=True):
    """Opens the jaws of forceps by a length, half of it each, across both.

    The forceps must not be moved as a whole at the same time. What lies between the jaws is
    held by friction only, as long as that bears; the forces on them are those of contact.
    """

    forms: ClassVar[tuple[str, ...]] = ("open TOOL by LENGTH using PROFILE",)
    apart: ClassVar[bool] = True
