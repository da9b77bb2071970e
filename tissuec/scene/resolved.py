"""A program as far as it needs no bodies."""

from msgspec import Struct

from tissuec.scene.declarations import Declarations
from tissuec.scene.model import Tissue, WrittenForce, WrittenLaws
from tissuec.scene.parameters import Constants
from tissuec.scene.vocabulary import Vocabulary


class ResolvedProgram(Struct, frozen=True):
    """A program without bodies: numbers, vocabulary, laws, tissues, forces."""

    declarations: Declarations
    constants: Constants
    vocabulary: Vocabulary
    laws: dict[str, WrittenLaws]
    tissues: dict[str, Tissue]
    forces: dict[str, WrittenForce]
