"""Words that move stay words: in order, apart, of one sum, and with their sharp edges."""

from itertools import pairwise, permutations

import numpy as np
import pytest

from tests.every import every
from tests.learn.wordy import SETTING, everything, random_scene, scene_of, words_of
from tissuec.fuzzy.scale import Axis
from tissuec.fuzzy.sets import Gaussian
from tissuec.learn.vocabulary.moving import WordsModel
from tissuec.learn.vocabulary.scales import FLOOR, WIDEST, Knots


def one_scale(words: str, **options) -> WordsModel:
    """Return the model of a property whose words are written so."""
    scene = scene_of(
        f"language 1\nproperty hardness from 0 to 1 {{\n{words}\n}}\n"
        "quantity mass from 3 mg to 300 mg on log scale {\n"
        "  evenly = [low, high]; applies to each node\n}\n"
        "rules simple { if hardness is soft then mass is low }\n"
        "body net { mesh is tube { axis from (0, 0, 0) cm to (4, 0, 0) cm; radius = 3 mm\n"
        "  rings = 3; sides = 4; diagonals is both; interior is none }; tissue is flesh }\n"
        "tissue flesh { described in simple; hardness is soft }\n" + SETTING
    )
    return WordsModel(scene, [words_of("Hardness")], **options)


def moved(model, theta):
    """Return the words of the property after moving."""
    return model.vocabulary(theta).properties["hardness"].scale


PARTITIONS = {
    "evenly": "evenly = [soft, medium, hard, harder]",
    "plateaus": "soft until 0.15; medium from 0.4 to 0.6; hard from 0.85",
    "touching": "soft until 0.3; medium from 0.3 to 0.6; hard from 0.7",
    "shapes": "soft = triangle(0, 0, 0.3)\n"
    "medium = triangle(0, 0.3, 1)\nhard = triangle(0.3, 1, 1)",
    "across": "soft = points(0, 1, 0.5, 0.5, 1, 0)\nhard = triangle(0, 1, 1)",
    "outside": "soft = trapezoid(-2, -1, 0.2, 0.7)\nhard = trapezoid(0.2, 0.7, 1.5, 2)",
}


@pytest.mark.parametrize("layout", PARTITIONS)
def test_degrees_that_sum_to_one_still_do(layout):
    model = one_scale(PARTITIONS[layout])
    assert model.size
    for seed in range(30):
        source = np.random.default_rng(seed)
        scale = moved(model, source.normal(size=model.size) * source.choice([0.1, 1, 5, 50]))
        corners = {x for shape in scale.words.values() for x in shape.corners}
        for x in source.random(200):
            if x in corners:
                continue
            # Two straight lines between the same corners: rounding, and nothing else.
            assert sum(s.degree(x) for s in scale.words.values()) == pytest.approx(1, abs=1e-12)


@every("seed", range(25))
def test_every_iterate_is_a_vocabulary(seed):
    model = everything(random_scene(seed))
    source = np.random.default_rng(seed)
    for size in (0.1, 1.0, 10.0, 1000.0):
        theta = size * source.normal(size=model.size)
        vocabulary = model.vocabulary(theta)
        for scale in model.scales:
            named, key = scale.form.named, scale.form.key
            now = (
                vocabulary.properties[key]
                if key in vocabulary.properties
                else vocabulary.quantities[key].named
            ).scale
            places = np.array(scale.knots.places)
            part = theta[scale.start : scale.start + scale.knots.size]
            after = places + scale.knots.moves(part)[0]
            gaps = np.diff(after) / np.diff(places)
            # Rounding of a difference of coordinates, in units of the smallest gap.
            slip = 1e-15 * np.abs(places).max() / np.diff(places).min()
            assert gaps.min() >= FLOOR - 1e-9 - 10 * slip
            assert (after[0], after[-1]) == (places[0], places[-1])
            # A core within another is neither above nor below it.
            for one, other in permutations(named.scale.words, 2):
                if np.less(named.scale.words[one].core, named.scale.words[other].core).all():
                    assert now.words[one].middle < now.words[other].middle


def test_sharp_edges_stay_sharp_and_shared_corners_shared():
    model = one_scale(PARTITIONS["touching"])
    scale = moved(model, np.array([0.4, -0.3, 0.8]))
    edge = scale.words["soft"].core[1]
    assert edge != 0.3 and scale.words["medium"].core[0] == edge
    assert scale.words["soft"].degree(np.nextafter(edge, 1)) == 0.0
    model = one_scale(PARTITIONS["shapes"])
    scale = moved(model, np.array([0.7]))
    peak = scale.words["medium"].middle
    assert peak > 0.3
    assert scale.words["soft"].support[1] == peak == scale.words["hard"].support[0]


def test_a_positive_number_moves_its_corner_up():
    model = one_scale("soft = triangle(0, 0, 0.4)\nhard = gaussian(0.7, 0.1)")
    assert model.names == (
        "hardness: upper flank of soft", "hardness: peak of hard", "hardness: width of hard",
    )  # fmt: skip
    foot = moved(model, np.array([0.2, 0, 0])).words["soft"].support[1]
    bells = [moved(model, t).words["hard"] for t in np.diag([0.0, 0.2, 0.2])]
    assert foot > 0.4 and bells[1].mean > 0.7 and bells[1].sigma == 0.1
    assert isinstance(bells[2], Gaussian) and bells[2].sigma > 0.1 and bells[2].mean == 0.7


def test_widths_of_bells_stay_between_a_part_of_theirs_and_the_range():
    model = one_scale("soft = gaussian(0.2, 0.05)\nhard = gaussian(0.7, 1)")
    assert model.size == 3  # a bell as wide as the range stays so
    for theta in (-1e4, -10.0, 10.0, 1e4):
        sigma = moved(model, np.array([0, 0, theta])).words["soft"].sigma
        assert 0.05 * FLOOR * (1 - 1e-12) <= sigma <= WIDEST


def test_frozen_words_stay_where_they_are():
    scene = random_scene(1)
    key = next(iter(scene.vocabulary.properties))
    words = scene.vocabulary.properties[key].scale.words
    word = next(iter(words))
    model = everything(scene, frozen={key.upper(): [word]})
    assert model.size < everything(scene).size
    theta = np.random.default_rng(0).normal(size=model.size)
    after = model.vocabulary(theta).properties[key].scale.words[word]
    assert after == words[word]
    with pytest.raises(ValueError, match='"nothing" is not a word for'):
        everything(scene, frozen={key: ["nothing"]})


def test_others_do_not_bend_a_frozen_word():
    words = "soft = points(0, 1, 0.5, 0.5, 1, 0)\nhard = triangle(0, 1, 1)"
    assert one_scale(words).names == ("hardness: upper flank of soft",)
    assert one_scale(words, frozen={"hardness": ["hard"]}).names == ()


def test_what_is_no_scale_is_refused():
    scene = random_scene(1)
    with pytest.raises(ValueError, match='"nonsense" is neither a property nor a quantity'):
        WordsModel(scene, [words_of("nonsense")])
    model = everything(scene)
    with pytest.raises(ValueError, match=f"the words move by {model.size} numbers"):
        model.given(np.zeros(model.size + 1))


def test_drift_tells_how_far_words_moved():
    model = one_scale(PARTITIONS["shapes"])
    soft, medium, hard = model.drift(np.array([0.7]))
    peak = moved(model, np.array([0.7])).words["medium"].middle
    assert (medium.before, medium.after) == (0.3, peak)
    assert medium.centre == medium.most == pytest.approx(peak - 0.3)
    assert soft.centre == hard.centre == 0.0 and soft.most == pytest.approx(peak - 0.3)
    assert medium.sentence.startswith('"medium" of hardness moves up by ')
    assert [d.sentence for d in model.drift(np.zeros(1))] == [
        f'"{word}" of hardness stays' for word in ("soft", "medium", "hard")
    ]


def test_knots_move_by_derivatives_that_differences_have():
    knots = Knots(Axis("a", 0, 1), [-1, 0.2, 0.5, 0.7, 0.9], fixed=[0.7])
    theta, h = np.array([0.3, -1.0, 2.0]), 1e-5
    slopes = knots.moves(theta)[1]
    for k, direction in enumerate(np.eye(3)):
        there, back = (knots.moves(theta + s * h * direction)[0] for s in (1, -1))
        assert slopes[:, k] == pytest.approx((there - back) / (2 * h), abs=1e-9)  # h^2
    ends = np.array(knots.places) + knots.moves(np.array([800.0, -900.0, 1e5]))[0]
    assert all(a < b for a, b in pairwise(ends))
