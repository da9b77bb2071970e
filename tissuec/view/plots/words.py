"""The words of a vocabulary: the degree of each over the range of its property or quantity."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar

from msgspec import Struct

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.names import key_of
from tissuec.view.plots import PLOTS
from tissuec.view.plots.options import Option
from tissuec.view.plots.page import Canvas, Picture
from tissuec.view.plots.partition import draw_partition
from tissuec.view.plots.subjects import PlotSubject

if TYPE_CHECKING:
    from tissuec.scene.words.phrases import NamedScale
    from tissuec.scene.words.vocabulary import Vocabulary

WIDTH, ROW, AROUND = 180.0, 36.0, 6.0  # [mm]


@PLOTS.member("words")
class Words(Struct, frozen=True):
    """The words of properties and quantities as sets.

    Attributes:
        of: Only these properties and quantities; all if none is named.
    """

    takes: ClassVar[str] = "words"
    several: ClassVar[bool] = False

    of: Annotated[
        tuple[str, ...], Option("Only this property or quantity; may be repeated.", "NAME")
    ] = ()

    def picture(self, subjects: Sequence[PlotSubject]) -> Picture:
        scales = self._chosen(subjects[0])
        columns = min(2, len(scales))
        rows = -(-len(scales) // columns)

        def draw(sheet: Canvas) -> None:
            # Side by side, more words have more room; in a table all have the same.
            room = [len(named.scale.words) for named in scales] if rows == 1 else None
            grid = sheet.figure.subplots(
                rows, columns, squeeze=False, sharey=True, width_ratios=room
            ).ravel()
            for axes, named in zip(grid, scales, strict=False):
                draw_partition(sheet, axes, named)
            for axes in grid[len(scales) :]:
                axes.remove()
            for axes in grid[::columns]:
                axes.set_ylabel("degree")

        return Picture(WIDTH if columns == 2 else 0.6 * WIDTH, AROUND + rows * ROW, draw)

    def _chosen(self, subject: PlotSubject) -> list["NamedScale"]:
        known = scales_of(subject.content.vocabulary)
        if not known:
            raise TissueError(
                f'"{subject.name}" has no words: it uses no vocabulary; '
                '"tissuec plot fuzzy/soft_tissue" shows the shipped vocabulary'
            )
        for name in self.of:
            if key_of(name) not in known:
                names = [named.name for named in known.values()]
                hint = alternatives(name, names, what="there are")
                raise TissueError(f'there is no property or quantity "{name}"; {hint}')
        return [known[key_of(name)] for name in self.of] or list(known.values())


def scales_of(vocabulary: "Vocabulary") -> dict[str, "NamedScale"]:
    """Return properties, and then quantities, by lower-case name."""
    quantities = {key: scale.named for key, scale in vocabulary.quantities.items()}
    return {**vocabulary.properties, **quantities}
