"""``close``: jaws that move towards each other."""

from typing import ClassVar

from tissuec.script.verbs import VERBS
from tissuec.script.verbs.jaws import JawMotion


@VERBS.member("close")
class Close(JawMotion, frozen=True):
    """Closes the jaws of forceps by a length; each jaw moves by half of it.

    The forceps must not be moved as a whole at the same time. Tissue between the jaws is held
    only by friction, and slips when the pull exceeds it. The forces on the jaws are contact
    forces.
    """

    apart: ClassVar[bool] = False
