"""Figures for journals: widths, sizes of letters, fonts, and formats that they ask for."""

import re
import zlib
from functools import cache

import matplotlib
import numpy as np
import pytest

from tests.view.plots.test_kinds import KINDS, QUICK, subject, texts
from tissuec.core.errors import TissueError
from tissuec.view.plots import draw
from tissuec.view.plots.formats import in_latex, save
from tissuec.view.plots.page import STYLES

NARROW, WIDE = "paper", "paper-wide"
#: Figures that a column of 85 mm has room for.
OF_COLUMN = ("energies", "errors", "logs", "study-curves", "response", "work-precision", "x-y")


@pytest.fixture(scope="module")
def on_paper(folder):
    """Return a function that gives the figure of a kind in a style, drawn once."""

    @cache
    def figure_of(kind, style):
        figure = draw(kind, subject(kind, folder), style=style, **QUICK.get(kind, {}))
        figure.draw_without_rendering()
        return figure

    return figure_of


@pytest.mark.parametrize("kind", KINDS)
def test_letters_have_7_to_9_points(kind, on_paper):
    figure = on_paper(kind, WIDE)
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(180.0)
    found = [text for text in texts(figure) if text.get_text().strip()]
    assert found
    for text in found:
        assert 7.0 <= text.get_fontsize() <= 9.0, text
        assert not text.get_parse_math(), text  # formulas have smaller letters in them


@pytest.mark.parametrize("kind", OF_COLUMN)
def test_nothing_collides_in_a_column(kind, on_paper):
    figure = on_paper(kind, NARROW)
    assert figure.get_size_inches()[0] * 25.4 == pytest.approx(85.0)
    found = [text for text in texts(figure) if text.get_text().strip()]
    width, height = figure.canvas.get_width_height()
    boxes = [text.get_window_extent() for text in found]
    for number, (text, box) in enumerate(zip(found, boxes, strict=True)):
        assert 7.0 <= text.get_fontsize() <= 9.0, text
        assert box.x0 >= -1 and box.x1 <= width + 1, text
        assert box.y0 >= -1 and box.y1 <= height + 1, text
        for other, place in zip(found[number + 1 :], boxes[number + 1 :], strict=True):
            assert other is text or not box.overlaps(place), (text, other)
    for axes in (one for one in figure.axes if one.get_label() != "<colorbar>"):
        assert axes.get_window_extent().width > 0.35 * width, axes


@pytest.mark.parametrize("kind", ["logs", "x-y"])
def test_a_pdf_has_its_letters_in_these_sizes_with_whole_fonts(kind, on_paper, tmp_path):
    save(on_paper(kind, NARROW), tmp_path / "a.pdf")
    written = (tmp_path / "a.pdf").read_bytes()
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", written, re.DOTALL)
    drawn = b"".join(filter(None, map(_inflated, streams)))
    sizes = {float(size) for size in re.findall(rb"/\S+ ([\d.]+) Tf", drawn)}
    assert sizes and min(sizes) >= 7.0 and max(sizes) <= 9.0
    fonts = re.findall(rb"/BaseFont /(\S+)", written)
    assert fonts and all(b"DejaVu" in font for font in fonts)
    # Every description of a font names the file of it that the PDF contains.
    assert written.count(b"/Type /FontDescriptor") == written.count(b"/FontFile2 ") >= 1


def _inflated(stream):
    try:
        return zlib.decompress(stream)
    except zlib.error:
        return None


def test_an_svg_has_its_texts_as_text(on_paper, tmp_path):
    save(on_paper("x-y", NARROW), tmp_path / "a.svg")
    written = (tmp_path / "a.svg").read_text(encoding="utf-8")
    said = set(re.findall(r"<text[^>]*>(.*?)</text>", written))
    lines = [text.get_text().split("\n") for text in texts(on_paper("x-y", NARROW))]
    assert {line.strip() for some in lines for line in some} <= said


def test_an_eps_is_opaque_and_leaves_the_figure_as_it_was(folder, tmp_path, recwarn):
    figure = draw("energies", folder / "strip.vtkhdf")
    bands = [band for axes in figure.axes for band in axes.collections]
    before = [(band.get_alpha(), band.get_facecolor().tolist()) for band in bands]
    save(figure, tmp_path / "a.eps")
    assert [(band.get_alpha(), band.get_facecolor().tolist()) for band in bands] == before
    assert any(alpha is not None and alpha < 1.0 for alpha, _ in before)
    assert not [one for one in recwarn if "transparency" in str(one.message)]
    written = (tmp_path / "a.eps").read_text(encoding="latin-1")
    alpha, ((red, green, blue, _),) = next(one for one in before if one[0] is not None)
    mixed = [f"{alpha * part + 1.0 - alpha:.3f}".rstrip("0") for part in (red, green, blue)]
    assert f"{' '.join(mixed)} setrgbcolor" in written
    assert "/DejaVuSans" in written  # embedded


def test_pgf_needs_no_latex(on_paper, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    save(on_paper("logs", NARROW), tmp_path / "a.pgf")
    written = (tmp_path / "a.pgf").read_text(encoding="utf-8")
    assert written.count(r"\begin{pgfscope}") == written.count(r"\end{pgfscope}") > 10
    assert written.count("{") == written.count("}")
    assert "time [ms]}" in written and "tension of" in written
    assert r"\fontsize{8.000000}" in written


def test_names_are_no_commands_of_latex():
    assert in_latex("a_b {50 %} $x^2$ µN·s 10⁻³") == (
        r"a\_b \{50 %\} \$x\textasciicircum{}2\$ \ensuremath{\mu}N\ensuremath{\cdot}s "
        r"10\textsuperscript{-}\textsuperscript{3}"
    )


def test_shades_that_pgf_cannot_hold_are_refused(on_paper, tmp_path):
    with pytest.raises(TissueError, match=r"write \.pdf or \.eps"):
        save(on_paper("rules", WIDE), tmp_path / "a.pgf")
    assert not (tmp_path / "a.pgf").exists()


def test_powers_of_ten_are_letters(on_paper):
    (axes,) = on_paper("spectrum", NARROW).axes
    said = [label.get_text() for label in axes.get_yticklabels()]
    assert any(re.fullmatch("10[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", text) for text in said), said


def test_few_decades_have_plain_numbers(folder):
    figure = draw("x-y", folder / "strip.vtkhdf", x="length of strip", y="force of right end",
                  start=0.02, stop=0.05, scale=("x=log", "y=log"))  # fmt: skip
    for axis in (figure.axes[0].xaxis, figure.axes[0].yaxis):
        low, high = axis.get_view_interval()
        ticks = zip(axis.get_majorticklocs(), axis.get_ticklabels(), strict=True)
        shown = [text.get_text() for place, text in ticks if low <= place <= high]
        assert len(shown) >= 2 and all(re.fullmatch(r"[\d.]+", text) for text in shown), shown


def test_a_style_is_one_of_three_and_users_keep_theirs(folder):
    assert list(STYLES) == ["screen", NARROW, WIDE]
    with pytest.raises(TissueError, match="did you mean"):
        draw("logs", folder / "strip.vtkhdf", style="papr")
    mine = matplotlib.rcParams.copy()
    figure = draw("logs", folder / "strip.vtkhdf", style=NARROW, size=(60.0, 50.0))
    assert matplotlib.rcParams == mine
    assert figure.get_size_inches() * 25.4 == pytest.approx(np.array([60.0, 50.0]))
