"""A program as far as it needs no bodies."""

from msgspec import Struct

from tissuec.scene.bodies.tables import TablesOfBodies
from tissuec.scene.model import Tissue, WrittenForce, WrittenLaws
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.program.parameters import Constants
from tissuec.scene.words.vocabulary import Vocabulary


class ResolvedProgram(Struct, frozen=True):
    """A program without bodies: numbers, vocabulary, laws, tissues, forces."""

    declarations: Declarations
    constants: Constants
    vocabulary: Vocabulary
    laws: dict[str, WrittenLaws]
    tables: TablesOfBodies
    tissues: dict[str, Tissue]
    forces: dict[str, WrittenForce]
