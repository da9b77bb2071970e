"""The base of all learn blocks: their items, and the file of the result."""

from collections.abc import Sequence
from pathlib import Path

from tissuec.core.source import Source
from tissuec.lang import syntax as s
from tissuec.scene.learning.clauses import LearnReader
from tissuec.scene.learning.data import DataReader
from tissuec.scene.learning.entries import learn_schema
from tissuec.scene.learning.sentences import SENTENCES
from tissuec.scene.program.declarations import Declared
from tissuec.scene.program.parameters import Constants
from tissuec.scene.reading.block_sentences import BlockItems


class LearnItems(BlockItems):
    """Sorts the items of one learn block.

    Attributes:
        data: Its files, also the one that is written.
    """

    def __init__(self, declared: Declared, constants: Constants, sources: Sequence[Source]):
        assert isinstance(declared.item, s.Block)
        self.name, self.block = declared.name, declared.item
        super().__init__(f"learn {self.name.text}", SENTENCES, learn_schema(), constants)
        self.data = DataReader(self.block, constants)
        self.sources = sources
        self.write: Path | None = None

    def reader(self, entry: str, item: s.Item) -> LearnReader:
        """Return what reads a sentence."""
        assert isinstance(item, s.Assign | s.Sentence | s.Function | s.Block)
        return LearnReader(entry, item, self.scope)

    def read_write(self, item: s.Item) -> None:
        """Read the file of the result."""
        (name,) = self.reader("write", item).get().files
        self.write = self.data.place_to_write(name, self.sources)
