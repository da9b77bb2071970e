"""The shipped vocabulary of matter: every word and hedge counts, in the right direction."""

import random
from functools import cache
from itertools import pairwise, permutations

import pytest

from tests.every import every
from tissuec.core.resources import library
from tissuec.core.source import Source
from tissuec.fuzzy.hedges import Shift, hedged, moves
from tissuec.fuzzy.rulebase import Inference
from tissuec.pipeline import compile_request, read_words
from tissuec.scene.request import Request

#: What grows (1) or falls (-1) with each property.
LEADS = {
    "hardness": {
        "young's modulus": 1, "breaking strain": -1, "strength": 1, "cutting resistance": 1,
    },
    "elasticity": {"retardation time": -1, "breaking strain": 1},
    "weight": {"density": 1},
    "shiftability": {"young's modulus": -1, "retardation time": 1},
    "consistency": {
        "young's modulus": 1, "breaking strain": -1, "strength": -1,
    },
    "extensibility": {"breaking strain": 1},
    "cohesion": {"strength": 1, "cutting resistance": 1},
    "tightening": {"stiffening": 1},
    "fluid content": {"poisson's ratio": 1},
    "tearing": {"toughness": 1},
    "slackening": {"relaxing share": 1},
    "pace": {"relaxation time": 1},
    "surface": {"friction": 1},
}  # fmt: skip
#: Those of the method; the others can be left out.
PUBLISHED = ("hardness", "elasticity", "weight", "shiftability", "consistency")


@cache
def vocabulary():
    return read_words(Request.file(library() / "fuzzy" / "soft_matter.tis"))[0].vocabulary


def concluded(facts):
    answers = vocabulary().rules["soft matter"].base.infer(facts)
    return {
        key: answer.value for key, answer in answers.items() if isinstance(answer, Inference)
    }


@pytest.mark.parametrize("name", LEADS)
@pytest.mark.parametrize("others", [PUBLISHED, LEADS], ids=["published", "all"])
def test_sliders_change_conclusions_strictly_monotonically(name, others):
    source = random.Random(name)
    for _ in range(60):
        facts = {key: source.random() for key in others}
        less, more = sorted((source.random(), source.random()))
        one, other = (concluded(facts | {name: at}) for at in (less, more))
        for quantity, sign in LEADS[name].items():
            assert sign * (other[quantity] - one[quantity]) > 0.0


@every("name", LEADS)
def test_every_hedge_of_every_word_changes_a_conclusion_in_its_direction(name):
    words = vocabulary()
    scale = words.properties[name].scale
    low, high = scale.axis.bounds
    facts = dict.fromkeys(LEADS, 0.4)
    for shape in scale.words.values():
        plain = concluded(facts | {name: scale.axis.value_of(shape)})
        for hedge in words.hedges.values():
            assert isinstance(hedge, Shift)
            if not moves(hedge, shape, scale.axis):
                # Only a word in the middle of its scale has no end that is nearer.
                assert shape.middle == pytest.approx((low + high) / 2)
                continue
            at = scale.axis.value_of(hedged([hedge], shape, scale.axis))
            other = concluded(facts | {name: at})
            upward = (shape.middle > (low + high) / 2) == (hedge.direction == "outward")
            for quantity, sign in LEADS[name].items():
                assert (sign if upward else -sign) * (other[quantity] - plain[quantity]) > 0.0


#: Words of hardness from the softest to the hardest.
HEDGES = ["extremely", "very", "markedly", "", "rather", "slightly", "hardly"]


def ladder(low, middle, high):
    """Return the phrases of a property from one end of its scale to the other."""
    below, above = ([f"{h} {word}".strip() for h in HEDGES] for word in (low, high))
    return [*below, middle, *reversed(above)]


LADDER = ladder("soft", "medium", "hard")
NEUTRAL = {"hardness": "medium", "elasticity": "medium", "weight": "medium",
           "shiftability": "medium", "consistency": "smooth"}  # fmt: skip


def place(name, phrase):
    """Return the number for which a phrase stands on the scale of a property."""
    words = vocabulary()
    *front, word = phrase.split()
    scale = words.properties[name].scale
    shape = hedged([words.hedges[one] for one in front], scale.words[word], scale.axis)
    return scale.axis.value_of(shape)


def modulus(**phrases):
    facts = {name: place(name, phrase) for name, phrase in (NEUTRAL | phrases).items()}
    return concluded(facts)["young's modulus"]


@pytest.mark.parametrize(
    ("context", "least", "most"),
    [
        ({}, 2.58, 2.60),
        ({"elasticity": "small", "shiftability": "low", "consistency": "chapped"}, 2.5, 2.7),
        ({"elasticity": "big", "shiftability": "high"}, 2.4, 2.8),
    ],
)
def test_each_hedge_of_hardness_is_the_same_step_of_the_modulus(context, least, most):
    found = [modulus(hardness=word, **context) for word in LADDER]
    steps = [b / a for a, b in pairwise(found)]
    # In the neutral context only hardness changes: even up to the rounding of 4.95 and 24.75.
    assert least < min(steps) and max(steps) < most
    # From softer than brain (1 kPa) to stiffer than tendon along its fibres (0.1 GPa).
    assert found[0] < 1e3 and found[-1] > 1e8


def test_the_fuzzy_words_of_springs_are_those_published():
    scale = vocabulary().properties["hardness"].scale
    assert list(scale.words) == ["soft", "medium", "hard"]
    assert scale.words["soft"].xs == (0.0, 1 / 6, 0.5, 1.0)


def presets():
    files = sorted((library() / "matter").glob("*.tis"))
    return {k: t for f in files for k, t in read_words(Request.file(f))[0].tissues.items()}


#: How far the words of a preset may be from the number that it writes: a hedge is 2.6, so that
#: the nearest one is within its root, 1.6.
WITHIN = 1.5


def moduli():
    """Return the written modulus and that of the words, for presets that have both."""
    return {
        name: (tissue.given["young's modulus"].value, tissue.concluded["young's modulus"])
        for name, tissue in presets().items()
        if tissue.given["young's modulus"].how == "written"
    }


def test_the_own_words_of_a_preset_give_its_measured_modulus():
    assert len(moduli()) >= 15
    for name, (written, by_words) in moduli().items():
        assert 1 / WITHIN < by_words / written < WITHIN, name


def test_words_keep_the_order_of_measured_moduli():
    for (one, (written, by_words)), (other, (least, low)) in permutations(moduli().items(), 2):
        if written > 1.2 * least:
            assert by_words > low, (one, other)


def test_presets_of_different_words_have_different_numbers():
    numbers = {
        name: tuple(sorted((key, given.value) for key, given in tissue.given.items()))
        for name, tissue in presets().items()
    }
    assert len(numbers) > 20
    assert len(set(numbers.values())) == len(numbers)


@pytest.mark.parametrize(
    "path", sorted((library() / "matter").glob("*.tis")), ids=lambda p: p.stem
)
def test_a_preset_of_matter_is_complete_and_agrees_with_what_is_known(path):
    words, diagnostics = read_words(Request.file(path))
    assert not diagnostics
    for tissue in words.tissues.values():
        assert not tissue.gaps
        assert {"young's modulus", "density", "retardation time"} <= tissue.given.keys()
        assert {"breaking strain", "strength"} & tissue.given.keys()


TWO = """language 1
use "tissues/liver"
use "fuzzy/soft_matter"
tissue gland {
  described in soft matter
  hardness is soft; elasticity is medium; weight is medium
  shiftability is low; consistency is SMOOTH
}
body one { mesh is lattice { cell = 5 mm; CUBE }; tissue is gland }
body two { mesh is lattice { kind is sodium chloride; cell = 5 mm; CUBE }; tissue is liver }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
""".replace("CUBE", "box from (0, 0, 0) mm to (5, 5, 5) mm")


def read(text):
    return compile_request(Request(Source("two.tis", text, None)))


def test_two_vocabularies_stand_in_one_scene_and_each_concludes_its_own_quantities():
    compiled, _ = read(TWO.replace("SMOOTH", "smooth"))
    matter, springs = (compiled.scene.tissues[name] for name in ("gland", "liver"))
    assert set(matter.given) == {
        "young's modulus", "retardation time", "density", "breaking strain", "strength",
        "stiffening", "poisson's ratio", "cutting resistance",
    }  # fmt: skip
    assert set(springs.given) == {"spring constant", "viscosity", "mass", "breaking force"}
    alone, _ = read(
        "\n".join(line for line in TWO.splitlines() if "body one" not in line).replace(
            "SMOOTH", "smooth"
        )
    )
    two = compiled.network.bodies[1].springs
    assert (compiled.network.springs.stiffness[two] == alone.network.springs.stiffness).all()


def test_a_hedge_of_a_word_in_the_middle_is_warned_of():
    _, diagnostics = read(
        TWO.replace("SMOOTH", "smooth").replace("is medium;", "is very medium;")
    )
    assert [one.code for one in diagnostics].count("W205") == 1
