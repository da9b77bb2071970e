"""Laws over every kind of plot: what each must keep, whatever it draws."""

import re
from functools import cache
from io import BytesIO
from itertools import product

import matplotlib
import numpy as np
import pytest
from matplotlib.text import Annotation
from msgspec.structs import fields

from tissuec.core import palette
from tissuec.view.plots import PLOTS, USUAL, draw
from tissuec.view.plots.formats import FORMATS, save
from tissuec.view.plots.options import options_of

FILES = {
    "result": "strip.vtkhdf", "words": "fuzzy/soft_tissue", "bench": "bench.json",
    "stress": "stress.json", "laboratory": "lab.json", "table": "grid.csv",
}  # fmt: skip
#: Of kinds for some of what they take only.
OWN_FILES = {
    "convergence": "refined.csv", "distribution": "sample.csv", "heat-map": "plane.csv",
    "tornado": "one_at_a_time.csv",
}  # fmt: skip
KINDS = sorted(PLOTS)
#: Names of axes whose numbers have no unit.
PLAIN = re.compile(
    r"(energy drift|error over largest displacement|degree|hardness|elasticity|weight|"
    r"shiftability|consistency|runs|(step|lift|hardness of liver)?|m\d|Sobol index of .*)$"
)
WITH_UNIT = re.compile(r"\[[^\]]+\]( \(.*\))?$|\[[^\]]+\];")


#: What keeps the slow ones quick, and what one cannot be without; the laws hold of the rest.
QUICK = {
    "rules": {"of": "viscosity"}, "x-y": {"x": "time", "y": "force of right end"},
    "spectrum": {"spectrum": "force of right end along z"},
    "envelope": {"envelope": "force of right end along z"},
}  # fmt: skip


@pytest.fixture(scope="session")
def drawn(folder):
    """Return a function that gives the figure of a kind, drawn once for all tests."""

    @cache
    def figure_of(kind):
        figure = draw(kind, subject(kind, folder), **QUICK.get(kind, {}))
        figure.draw_without_rendering()
        return figure

    return figure_of


def subject(kind, folder):
    name = OWN_FILES.get(kind) or FILES[PLOTS[kind].takes]
    return name if "/" in name else folder / name


def texts(figure):
    """Return all texts that are shown, of ticks those within their axes."""
    found = [*figure.findobj(Annotation), *figure.texts, figure._suptitle, figure._supxlabel]
    for legend in [*figure.legends, *(axes.get_legend() for axes in figure.axes)]:
        found += [] if legend is None else legend.get_texts()
    for axes in figure.axes:
        if axes.axison:
            found += [axes.xaxis.get_label(), axes.yaxis.get_label()]
            found += [label for axis in (axes.xaxis, axes.yaxis) for label in ticks(axis)]
        found += [axes.title, axes._left_title]
    return [text for text in found if text and text.get_visible() and text.get_text()]


def ticks(axis):
    """Return the labels of the ticks that are within an axis."""
    low, high = sorted(axis.get_view_interval())
    places = zip(axis.get_majorticklocs(), axis.get_ticklabels(), strict=False)
    return [label for place, label in places if low <= place <= high]


@pytest.mark.parametrize("kind", KINDS)
def test_axes_say_what_they_are_and_in_which_unit(kind, drawn):
    for axes in drawn(kind).axes:
        for name, shared in (("x", axes.get_shared_x_axes()), ("y", axes.get_shared_y_axes())):
            group = shared.get_siblings(axes)
            labels = [getattr(one, f"get_{name}label")().replace("\n", " ") for one in group]
            for label in filter(None, labels):
                assert WITH_UNIT.search(label) or PLAIN.search(label), label
            numbers = [
                text
                for text in ticks(getattr(axes, f"{name}axis"))
                if is_number(text.get_text())
            ]
            assert any(labels) or not numbers or not axes.axison, (kind, axes)


def is_number(text):
    return bool(re.fullmatch(r"[−\d.,\s]+", text))


@pytest.mark.parametrize("kind", KINDS)
def test_nothing_is_clipped(kind, drawn):
    """Every text lies on the page; a pixel is left to rounding."""
    figure = drawn(kind)
    figure.draw_without_rendering()  # it may have been saved in another size
    width, height = figure.canvas.get_width_height()
    for text in texts(figure):
        box = text.get_window_extent()
        assert box.x0 >= -1 and box.y0 >= -1, text
        assert box.x1 <= width + 1 and box.y1 <= height + 1, text


@pytest.mark.parametrize("kind", KINDS)
def test_names_of_curves_do_not_lie_on_one_another(kind, drawn):
    figure = drawn(kind)
    for axes in figure.axes:
        boxes = [text.get_window_extent() for text in axes.texts if text.get_gid()]
        legend = axes.get_legend()
        boxes += [] if legend is None else [legend.get_window_extent()]
        for number, box in enumerate(boxes):
            for other in boxes[number + 1 :]:
                assert not box.overlaps(other) or box == other


@pytest.mark.parametrize("kind", KINDS)
def test_legends_hide_no_data(kind, drawn):
    figure = drawn(kind)
    for legend in [*figure.legends, *(axes.get_legend() for axes in figure.axes)]:
        if legend is not None:
            box = legend.get_window_extent()
            assert not any(
                box.overlaps(axes.get_window_extent()) for axes in figure.axes if axes.axison
            )


#: Kinds whose curves are interrupted, by a height that is none, where a run is left out.
INTERRUPTED = {"response", "convergence"}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_drawn_are_numbers(kind, drawn):
    for axes in drawn(kind).axes:
        for line in axes.get_lines():
            points = np.asarray(line.get_xydata(), dtype=float)
            if kind in INTERRUPTED:
                points = points[~np.isnan(points[:, 1])]
            assert len(points) and np.isfinite(points).all(), line
        for found in axes.collections:
            for path in found.get_paths():
                assert np.isfinite(path.vertices).all(), found


HEADS = {
    ".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF", ".eps": b"%!PS-Adobe-3.0 EPSF",
    ".pgf": b"% \\usepackage{pgf}",
}  # fmt: skip


def test_every_format_has_a_head_here():
    assert set(FORMATS) == set(HEADS)


#: One kind in every format, and two more as SVG, which shows every number and every name.
QUICKLY = {(kind, ".svg") for kind in ("errors", "paths")} | {("logs", end) for end in HEADS}


@pytest.mark.parametrize(
    ("kind", "suffix"),
    [
        pytest.param(*pair, marks=() if pair in QUICKLY else pytest.mark.slow)
        for pair in product(KINDS, HEADS)
    ],
)
def test_every_format_is_written_and_the_same_again(kind, suffix, drawn, folder, tmp_path):
    again = draw(kind, subject(kind, folder), **QUICK.get(kind, {}))
    files = [tmp_path / f"{name}{suffix}" for name in ("one", "two")]
    for figure, path in zip((drawn(kind), again), files, strict=True):
        save(figure, path, dpi=50)
    one, two = (path.read_bytes() for path in files)
    assert one.startswith(HEADS[suffix])
    assert one == two
    assert b"CreationDate: 20" not in one and b"<dc:date>" not in one


def own_style():
    """Return the parameters of matplotlib but for the backend.

    Matplotlib chooses it when it is first needed, and spells its name in two ways.
    """
    named = matplotlib.rcParams
    return {name: named[name] for name in named if name != "backend"}


@pytest.mark.parametrize("kind", ["logs", pytest.param("words", marks=pytest.mark.slow)])
def test_users_keep_their_own_style(kind, folder):
    with matplotlib.rc_context():
        looks = {"axes.facecolor": "black", "font.size": 30.0}
        matplotlib.rcParams.update(looks)
        mine = own_style()
        figure = draw(kind, subject(kind, folder))
        assert own_style() == mine
    assert matplotlib.colors.to_hex(figure.get_facecolor()) == palette.PAPER
    assert max(text.get_fontsize() for text in texts(figure)) < 15


def test_size_is_as_asked(folder):
    figure = draw("logs", folder / "strip.vtkhdf", size=(200.0, 220.0))
    assert figure.get_size_inches() == pytest.approx((200.0 / 25.4, 220.0 / 25.4))


@pytest.mark.parametrize("kind", KINDS)
def test_options_are_described_and_have_defaults(kind):
    member = PLOTS[kind]
    assert set(member.__struct_fields__) == set(options_of(member))
    assert all(option.help.endswith(".") for option in options_of(member).values())
    member()  # every option can be left out
    assert member.__doc__
    assert not member.__doc__.startswith(f"{member.__name__}(")


def test_options_of_one_name_are_read_alike():
    found = {}
    for member in PLOTS.values():
        for name, option in options_of(member).items():
            default = next(f.default for f in fields(member) if f.name == name)
            same = found.setdefault(name, (option.read, option.spellings, type(default)))
            assert same == (option.read, option.spellings, type(default)), name


def test_each_subject_has_a_usual_kind():
    assert set(FILES) == set(USUAL) == {member.takes for member in PLOTS.values()}
    for subject, kinds in USUAL.items():
        assert {PLOTS[kind].takes for kind in kinds} == {subject}


def test_neighbouring_series_differ_in_lightness_or_dashes():
    from tissuec.view.plots.curves import DASHES, look

    for first, second in ((n, n + 1) for n in range(6)):
        assert look(first)["color"] != look(second)["color"]
        assert look(first)["linestyle"] != look(second)["linestyle"]
    assert len({str(dash) for dash in DASHES}) == len(DASHES)


def test_notebooks_show_figures(drawn):
    figure = drawn("work-precision")
    assert figure._repr_png_().startswith(b"\x89PNG")
    stream = BytesIO()
    figure.savefig(stream, format="svg")
    assert b"<dc:date>" not in stream.getvalue()
