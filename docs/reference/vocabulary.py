"""The shipped vocabulary of matter and the usual ranges, as Markdown."""

from collections.abc import Mapping
from functools import cache

from tissuec.core.markdown import code, table
from tissuec.core.resources import library
from tissuec.core.units import PRESSURE, show
from tissuec.fuzzy.hedges import hedged
from tissuec.fuzzy.rulebase import Inference
from tissuec.model.inelastic import TIMES
from tissuec.pipeline import read_words
from tissuec.scene.model import Tissue
from tissuec.scene.request import Request
from tissuec.scene.tissues.quantities import (
    BREAKING_STRAIN,
    CUTTING_RESISTANCE,
    FRICTION,
    QUANTITIES,
    SHARES,
    STIFFENING,
    STRENGTH,
    TOUGHNESS,
    YOUNGS_MODULUS,
)
from tissuec.scene.usual_ranges import USUAL
from tissuec.scene.words.vocabulary import Vocabulary

RULES = "soft matter"
#: What the other properties are for the ladder.
NEUTRAL = {
    "elasticity": "medium", "weight": "medium", "shiftability": "medium",
    "consistency": "smooth",
}  # fmt: skip
_HEDGES = ("extremely", "very", "markedly", "", "rather", "slightly", "hardly")
#: The quantity of each property, and its low, middle and high words.
_TEARING = {
    "extensibility": (BREAKING_STRAIN, ("short", "medium", "long")),
    "cohesion": (STRENGTH, ("friable", "sound", "tough")),
    "tightening": (STIFFENING, ("even", "gradual", "sudden")),
}
_HOLDING = {
    "tearing": (TOUGHNESS, ("ready", "laboured", "reluctant")),
    "slackening": (SHARES[0], ("little", "moderate", "great")),
    "pace": (TIMES[0], ("quick", "steady", "slow")),
    "surface": (FRICTION, ("slimy", "moist", "sticky")),
}
_SIZES = {
    "size": "largest extent of a body of matter, or from a file", "thickness": "of a wall",
    "distance": "of a tool from all bodies", "gravity": "",
}  # fmt: skip


def parts() -> dict[str, str]:
    """Return every generated part by its name."""
    return {
        "ladder of hardness": ladder(),
        "ladders of tearing": ladders(_TEARING),
        "ladders of holding": ladders(_HOLDING),
        "presets of matter": preset_table(),
        "usual ranges": usual_table(),
    }


def ladder() -> str:
    """Return Young's modulus for each word of hardness, from the softest to the hardest."""
    soft = [f"{hedge} soft".strip() for hedge in _HEDGES]
    hard = [f"{hedge} hard".strip() for hedge in reversed(_HEDGES)]
    rows = [(word, _modulus(word)) for word in (*soft, "medium", *hard)]
    half = (len(rows) + 1) // 2
    beside = (*rows[half:], ("", "")) if len(rows) % 2 else rows[half:]
    return table(
        ("hardness", "Young's modulus", "hardness", "Young's modulus"),
        [(*one, *other) for one, other in zip(rows[:half], beside, strict=True)],
    )


def ladders(properties: Mapping[str, tuple[str, tuple[str, ...]]]) -> str:
    """Return a table of the words of some properties, with their numbers.

    Args:
        properties: Their quantities, and their low, middle and high words.
    """
    rows: list[tuple[str, ...]] = []
    for k, hedge in enumerate((*_HEDGES, "", *_HEDGES[::-1])):
        cells: list[str] = []
        for name, (quantity, words) in properties.items():
            word = words[(k >= len(_HEDGES)) + (k > len(_HEDGES))]
            phrase = f"{hedge} {word}".strip()
            found = _concluded(quantity, {"hardness": "soft", name: phrase})
            cells += [phrase, _shown(quantity, float(f"{found:.2g}"))]
        rows.append(tuple(cells))
    heads = [(name, QUANTITIES[quantity].name) for name, (quantity, _) in properties.items()]
    return table(tuple(one for pair in heads for one in pair), rows)


def preset_table() -> str:
    """Return the written numbers of presets of matter, each with its ratio to the words."""
    keys = (
        YOUNGS_MODULUS, BREAKING_STRAIN, STRENGTH, STIFFENING, "density", TOUGHNESS, SHARES[0],
        TIMES[0], CUTTING_RESISTANCE, FRICTION,
    )  # fmt: skip
    rows = [(t.name, *(_beside_words(t, key) for key in keys)) for t in _presets()]
    rows = [row for row in rows if any(row[1:])]
    return table(("tissue", *(QUANTITIES[key].name for key in keys)), rows)


def _beside_words(tissue: Tissue, key: str) -> str:
    """Return a written number of a tissue, with its ratio to words: "5.5 kPa, 0.75"."""
    given, by_words = tissue.given.get(key), tissue.concluded.get(key)
    if given is None or given.how != "written" or given.value == given.quantity.none:
        return ""
    shown = _shown(key, given.value)
    return shown if by_words is None else f"{shown}, {given.value / by_words:.2f}"


def _shown(key: str, value: float) -> str:
    if key in (BREAKING_STRAIN, SHARES[0]):
        return f"{100.0 * value:.3g} %"
    return QUANTITIES[key].show(value)


def usual_table() -> str:
    """Return outside of which ranges values are warned of."""
    rows = [
        (
            code(QUANTITIES[key].name) if key in QUANTITIES else key,
            usual.shown,
            _SIZES.get(key, ""),
        )
        for key, usual in USUAL.items()
    ]
    return table(("quantity", "usual range", "of"), rows)


def _presets() -> list[Tissue]:
    """Return the presets of matter that write numbers, from the softest to the stiffest."""
    found = {
        name: tissue
        for path in sorted((library() / "matter").glob("*.tis"))
        for name, tissue in read_words(Request.file(path))[0].tissues.items()
        if any(given.how == "written" for given in tissue.given.values())
    }
    return sorted(found.values(), key=lambda tissue: tissue.given[YOUNGS_MODULUS].value)


@cache
def _vocabulary() -> Vocabulary:
    return read_words(Request.file(library() / "fuzzy" / "soft_matter.tis"))[0].vocabulary


def _modulus(hardness: str) -> str:
    return show(_concluded(YOUNGS_MODULUS, {"hardness": hardness}), PRESSURE)


def _concluded(quantity: str, phrases: Mapping[str, str]) -> float:
    """Return a quantity of neutral tissue with some phrases, in SI units."""
    facts = {name: _place(name, phrase) for name, phrase in {**NEUTRAL, **phrases}.items()}
    answer = _vocabulary().rules[RULES].base.conclude(quantity, facts)
    assert isinstance(answer, Inference)
    return answer.value


def _place(name: str, phrase: str) -> float:
    words = _vocabulary()
    *front, word = phrase.split()
    scale = words.properties[name].scale
    shape = hedged([words.hedges[one] for one in front], scale.words[word], scale.axis)
    return scale.axis.value_of(shape)
