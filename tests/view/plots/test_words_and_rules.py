"""Words are drawn as the sets that they are, rules as what they conclude."""

import numpy as np
import pytest

from tissuec.core.errors import CompileError, TissueError
from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request
from tissuec.view.plots import draw
from tissuec.view.plots import rules as drawn_rules
from tissuec.view.plots.rules import POINTS

pytestmark = pytest.mark.usefixtures("unplaced")

SHAPES = """language 1
property wetness from 0 to 10 { dry = points(0, 1, 2, 1, 4, 0); damp = gaussian(5, 1)
  wet = trapezoid(5, 8, 10, 10) }
property size from 1 mm to 100 mm on log scale { evenly = [tiny, large] }
property colour from 0 to 1 { evenly = [pale, dark] }
quantity mass from 1 mg to 1 g on log scale { evenly = [low, high]; applies to each node }
quantity viscosity from 1 mN*s/m to 2 mN*s/m {
  evenly = [low, high]; applies to each spring; otherwise is low
}
hedge very = shift(50 %, outward)
rules moist {
  if wetness is dry and size is tiny then mass is low
  if wetness is wet and colour is dark then mass is high
  if size is large and colour is pale then viscosity is high
}
"""


@pytest.fixture(scope="module")
def moist():
    words, _ = read_words(Request(Source("moist.tis", SHAPES)))
    return words


@pytest.fixture(scope="module")
def soft():
    from tissuec.core.resources import library

    words, _ = read_words(Request.file(library() / "fuzzy" / "soft_tissue.tis"))
    return words


def curves(axes):
    return {line.get_label(): line.get_xydata() for line in axes.get_lines()}


# --- words ------------------------------------------------------------------------------------


def test_every_property_and_quantity_has_a_panel(soft):
    figure = draw("words", "fuzzy/soft_tissue")
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels == [
        "hardness", "elasticity", "weight", "shiftability", "consistency",
        "spring constant [N/m]", "viscosity [mN·s/m]", "mass [mg]", "breaking force [mN]",
    ]  # fmt: skip
    hardness = curves(figure.axes[0])
    assert list(hardness) == ["soft", "medium", "hard"]
    assert [text.get_text() for text in figure.axes[0].texts] == list(hardness)


def test_sets_are_drawn_by_their_degrees(moist):
    figure = draw("words", moist)
    named = [*moist.vocabulary.properties.values()]
    named += [scale.named for scale in moist.vocabulary.quantities.values()]
    assert len(figure.axes) == len(named) == 5
    for axes, one in zip(figure.axes, named, strict=True):
        axis = one.scale.axis
        factor = axes.get_xlim()[1] / axis.high
        for word, shape in one.scale.words.items():
            for x, degree in curves(axes)[word]:
                value = min(max(x / factor, axis.low), axis.high)
                assert shape.degree(axis.to_scale(value)) == pytest.approx(degree, abs=1e-9)
        assert axes.get_xscale() == ("log" if axis.log else "linear")
    bell = curves(figure.axes[0])["damp"]
    assert bell[:, 1].max() == pytest.approx(1.0)  # the mean is one of its points


def test_corners_are_points_of_the_curve(moist):
    dry = curves(draw("words", moist, of="Wetness").axes[0])["dry"]
    assert dry == pytest.approx(np.array([[0, 1], [2, 1], [4, 0], [10, 0]]))


def test_words_of_a_scene_are_those_that_it_uses(folder):
    labels = [axes.get_xlabel() for axes in draw(None, folder / "strip.tis").axes]
    assert labels[0] == "hardness"


def test_what_has_no_words_says_so(tmp_path):
    bare = tmp_path / "bare.tis"
    bare.write_text("language 1\nlet a = 1 mm\n", encoding="utf-8")
    with pytest.raises(TissueError, match="has no words: it uses no vocabulary"):
        draw("words", bare)
    with pytest.raises(TissueError, match="has no rules"):
        draw("rules", bare)
    with pytest.raises(TissueError, match='did you mean "hardness"'):
        draw("words", "fuzzy/soft_tissue", of="hardnes")
    with pytest.raises(TissueError, match='did you mean "fuzzy/soft_tissue"'):
        draw("words", "fuzzy/soft_tisue")
    bare.write_text("language 1\nproperty p from 1 to 0 { evenly = [a] }\n", encoding="utf-8")
    with pytest.raises(CompileError):
        draw("words", bare)


# --- rules ------------------------------------------------------------------------------------


@pytest.fixture
def few(monkeypatch):
    """Take few points of each axis, to be quick."""
    monkeypatch.setattr(drawn_rules, "POINTS", 7)


def test_a_surface_is_what_the_rules_conclude(soft, few):
    plot = drawn_rules.Rules(of=("spring constant",), x="hardness", y="elasticity",
                             at=("consistency=0.9",))  # fmt: skip
    (surface,) = plot.surfaces(soft.vocabulary, "soft")
    base = soft.vocabulary.rules["soft tissue"].base
    assert surface.value.shape == (7, 7)
    for row, up in enumerate(surface.y):
        for column, right in enumerate(surface.x):
            facts = {
                "hardness": right, "elasticity": up, "consistency": 0.9,
                "shiftability": 0.5, "weight": 0.5,
            }  # fmt: skip
            found = base.infer(facts)["spring constant"]
            assert surface.value[row, column] == found.value
    assert surface.fixed == {"shiftability": "0.5", "consistency": "0.9"}


def test_the_picture_shows_the_surface(soft, few):
    figure = draw("rules", "fuzzy/soft_tissue", of="mass", x="weight", y="hardness")
    axes, bar = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("weight", "hardness")
    assert bar.get_ylabel() == "mass [mg]"
    (mesh, *_) = axes.collections
    base = soft.vocabulary.rules["soft tissue"].base
    columns = [
        1e6 * base.infer({"weight": weight})["mass"].value for weight in np.linspace(0, 1, 7)
    ]
    shown = np.asarray(mesh.get_array()).reshape(7, 7)
    assert shown == pytest.approx(np.tile(columns, (7, 1)))
    words = list(axes.child_axes)
    assert [t.get_text() for t in words[0].get_xticklabels()] == ["low", "medium", "high"]


def test_what_is_fixed_is_stated_and_words_stand_for_their_middles(soft, few):
    plot = drawn_rules.Rules(of=("viscosity",), x="elasticity", y="consistency",
                             at=("shiftability=very high",))  # fmt: skip
    (surface,) = plot.surfaces(soft.vocabulary, "soft")
    named = soft.vocabulary.properties["shiftability"]
    high = named.scale.axis.value_of(named.scale.words["high"])
    very = float(surface.fixed["shiftability"])
    assert very == pytest.approx(high + 0.5 * (1.0 - high), abs=1e-3)  # half way to the end
    figure = draw("rules", soft, of="viscosity", x="elasticity", y="consistency",
                  at="shiftability=0.25")  # fmt: skip
    assert figure.axes[0].get_title(loc="left") == "viscosity, at shiftability = 0.25"


def test_where_no_rule_speaks_there_is_no_number(moist, few):
    mass, viscosity = drawn_rules.Rules().surfaces(moist.vocabulary, "moist")
    assert np.isnan(mass.value).any() and np.isfinite(mass.value).any()
    assert not mass.is_fallback.any()
    assert np.isfinite(viscosity.value).all() and viscosity.is_fallback.any()
    base = moist.vocabulary.rules["moist"].base
    facts = {"wetness": 2.0, "size": 0.05, "colour": 0.5}
    assert not hasattr(base.infer({**facts, "wetness": 4.5})["mass"], "value")
    figure = draw("rules", moist)
    said = {t.get_text()[2:] for axes in figure.axes if axes.get_legend()
            for t in axes.get_legend().get_texts()}  # fmt: skip
    assert said == {"no rule fires: error", "no rule fires: fallback"}


def test_properties_of_log_scales_have_log_axes(moist, few):
    figure = draw("rules", moist, of="mass", x="size", y="wetness")
    axes = figure.axes[0]
    assert axes.get_xlabel() == "size [mm]"
    assert axes.get_xscale() == "log"
    assert axes.get_xlim() == pytest.approx((1.0, 100.0))


def test_a_quantity_that_never_changes_is_drawn_too(few):
    text = SHAPES[: SHAPES.index("rules")] + (
        "rules plain { if colour is pale or colour is dark then viscosity is low }\n"
    )
    words, _ = read_words(Request(Source("plain.tis", text)))
    figure = draw("rules", words)
    assert len(figure.axes) == 2


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"of": "mas"}, 'no quantity concluded by rules "mas"; did you mean "mass"'),
        ({"x": "hardnes"}, 'no property "hardnes"; did you mean "hardness"'),
        ({"x": "weight", "y": "weight"}, "two different properties"),
        ({"at": "hardness"}, "does not have the form PROPERTY=VALUE"),
        ({"at": "hardness=2"}, "outside its range"),
        (
            {"at": "hardness=sofft"},
            'neither a number nor a word for hardness; did you mean "soft"',
        ),
        ({"x": "hardness", "at": "hardness=0.5"}, "is on an axis"),
        ({"at": "hardnes=0.5"}, 'did you mean "hardness"'),
    ],
)
def test_what_cannot_be_drawn_is_said(options, message, few):
    with pytest.raises(TissueError, match=message):
        draw("rules", "fuzzy/soft_tissue", **options)


def test_there_are_enough_points_to_see_corners():
    assert POINTS >= 50
