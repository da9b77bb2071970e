"""Plots: kinds of pictures, drawn of results, vocabularies and benches.

A member is a ``Struct`` whose fields are its options, on the command line as in Python. None of
them imports matplotlib or opens a file before something is drawn.

Shared arguments:
    kind: Name of the kind of plot.
    plot: A plot with its options.
    subjects: What it is drawn of.
    sheet: What is drawn on.
    axes: Axes of matplotlib.
    trajectory: The result.
    view: Direction of the eye.
    panels: Panels, one above the other.
    runs: Results, with their names.
    notes: Remarks below the picture.
    options: Options of matplotlib.
    position: Of all points, in the unit of the axes, shape (point, 3).
    triangles: Corners, shape (triangle, 3).
    colour: Colour of the lines or markers.
    values: In any unit, of any shape.
    points: Points [m], shape (…, 3).
"""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol

from msgspec.structs import fields

from tissuec.core.errors import TissueError
from tissuec.core.hints import alternatives
from tissuec.core.registry import Family

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from tissuec.view.plots.page import Picture
    from tissuec.view.plots.subjects import PlotSubject


class WrongOption(ValueError):
    """A kind of plot has no such option."""


class Plot(Protocol):
    """Interface of members of ``PLOTS``; their fields are options.

    Attributes:
        takes: What it can be drawn of: "result", "words", "table", "bench", "stress" or
            "laboratory".
        several: Whether several of these can be laid over one another.
    """

    takes: ClassVar[str]
    several: ClassVar[bool]

    def picture(self, subjects: "Sequence[PlotSubject]") -> "Picture":
        """Return the picture, with everything it needs.

        Raises:
            TissueError: There is nothing to draw, or an option names what is not there.
        """
        ...


PLOTS: Family[type[Plot]] = Family("tissuec.view.plots", "plot")
#: What is drawn of a subject when nobody says what: the first that has the given options.
USUAL = {
    "result": ("overview", "logs", "paths", "frames", "energies", "errors"),
    "words": ("words", "rules"),
    "table": (
        "convergence",
        "tornado",
        "heat-map",
        "response",
        "distribution",
        "study-curves",
        "scatter-matrix",
    ),
    "bench": ("work-precision",),
    "stress": ("stability",),
    "laboratory": ("stress-strain",),
}


def draw(
    kind: str | None = None,
    *given: Any,
    size: tuple[float, float] | None = None,
    title: str = "",
    style: str = "screen",
    overrides: Sequence[str] = (),
    libraries: Sequence[Path] = (),
    strict: bool = False,
    **options: Any,
) -> "Figure":
    """Return a figure of matplotlib, which notebooks show and ``savefig`` writes.

    Args:
        kind: A member of ``PLOTS``, such as "logs"; None: what suits the first of ``given``.
        given: Names of files, vocabularies, open results, or what a bench found.
        size: Width and height [mm]; chosen by the kind if not given.
        title: Text above all panels.
        style: "screen", or for journals "paper" (85 mm wide) and "paper-wide" (180 mm).
        overrides: Texts of ``--set``, for what is given as a text.
        libraries: Folders in which a text finds what it uses.
        strict: Whether warnings about a text are errors.
        options: Of the kind, such as ``log="force of forceps A"``.

    Raises:
        TissueError: A file, the kind, the style or an option is wrong, or matplotlib is not
            installed.
        CompileError: A text is wrong.
        WrongOption: An option is none of the kind's.
        ValueError: Nothing was given, or nothing that can be plotted.
    """
    from tissuec.view.plots.page import need_matplotlib, new_sheet, style_named
    from tissuec.view.plots.subjects import credits_of, opened

    need_matplotlib()  # before all the work
    look = style_named(style)
    if not given:
        raise ValueError("give at least one file to plot")
    with opened(given, overrides=overrides, libraries=libraries, strict=strict) as subjects:
        name = usual(subjects, options) if kind is None else kind
        plot = make(name, options)
        check(name, plot, subjects)
        picture = plot.picture(subjects)
        size = size or look.size_of(picture.width, picture.height)
        with new_sheet(*size, look) as sheet:
            picture.on(sheet)
            if title:
                sheet.figure.suptitle(title, x=0.01, ha="left", fontsize=10)
        figure: Any = sheet.figure
        figure.kind = name
        figure.credits = credits_of(subjects[0])
        return figure


def usual(subjects: "Sequence[PlotSubject]", options: dict[str, Any]) -> str:
    """Return the kind that suits subjects and has all of some options."""
    taking = [name for name in PLOTS if PLOTS[name].takes == subjects[0].kind]
    first = USUAL[subjects[0].kind]
    ordered = [*first, *(name for name in taking if name not in first)]
    for name in ordered:
        member: Any = PLOTS[name]
        known = set(member.__struct_fields__)
        suits = not hasattr(member, "suits") or member.suits(subjects[0].content)
        if suits and known >= set(options) and (member.several or len(subjects) == 1):
            return name
    return first[0]


def make(kind: str, options: dict[str, Any]) -> Plot:
    """Return a member with options; a single value may replace a list of one.

    Raises:
        TissueError: There is no such kind.
        WrongOption: There is no such option of it.
    """
    if kind not in PLOTS:
        raise TissueError(
            f'there is no kind of plot called "{kind}"; '
            + alternatives(kind, PLOTS, what="kinds")
        )
    member: Any = PLOTS[kind]
    known = {field.name: field for field in fields(member)}
    for name in options:
        if name not in known:
            hint = alternatives(name, known, what="its options") or "it has no options"
            raise WrongOption(f'{kind} has no option "{name}"; {hint}')
    listed = {name for name, field in known.items() if isinstance(field.default, tuple)}
    return member(
        **{
            name: (value,) if name in listed and _is_one(value) else value
            for name, value in options.items()
        }
    )


def _is_one(value: Any) -> bool:
    return isinstance(value, str | int | float)


def check(kind: str, plot: Plot, subjects: "Sequence[PlotSubject]") -> None:
    """Check that a kind can be drawn of subjects.

    Raises:
        TissueError: It cannot, and what could.
    """
    from tissuec.view.plots.subjects import CALLED

    for subject in subjects:
        if subject.kind != plot.takes:
            others = [name for name in PLOTS if PLOTS[name].takes == subject.kind]
            raise TissueError(
                f'"{subject.name}" is {CALLED[subject.kind]}, but the plot {kind} needs '
                f"{CALLED[plot.takes]}; plots of it: {', '.join(others)}"
            )
    if len(subjects) > 1 and not plot.several:
        together = [
            name for name in PLOTS if PLOTS[name].several and PLOTS[name].takes == plot.takes
        ]
        hint = f"; plots of several files: {', '.join(together)}" if together else ""
        raise TissueError(f"the plot {kind} needs one file, not {len(subjects)}{hint}")
