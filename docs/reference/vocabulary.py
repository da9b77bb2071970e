"""The shipped vocabulary of matter and the usual ranges, as Markdown."""

from functools import cache

from tissuec.core.markdown import code, table
from tissuec.core.resources import library
from tissuec.core.units import PRESSURE, show
from tissuec.fuzzy.hedges import hedged
from tissuec.fuzzy.inference_results import Inference
from tissuec.pipeline import read_words
from tissuec.scene.model import Tissue
from tissuec.scene.quantities import QUANTITIES, YOUNGS_MODULUS
from tissuec.scene.request import Request
from tissuec.scene.usual_ranges import USUAL
from tissuec.scene.vocabulary import Vocabulary

RULES = "soft matter"
#: What the other properties are for the ladder.
NEUTRAL = {
    "elasticity": "medium", "weight": "medium", "shiftability": "medium",
    "consistency": "smooth",
}  # fmt: skip
_HEDGES = ("extremely", "very", "markedly", "", "rather", "slightly", "hardly")
_SIZES = {
    "size": "largest extent of a body of matter, or from a file", "thickness": "of a wall",
    "distance": "of a tool from all bodies", "gravity": "",
}  # fmt: skip


def parts() -> dict[str, str]:
    """Return every generated part by its name."""
    return {
        "ladder of hardness": ladder(),
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


def preset_table() -> str:
    """Return the presets of matter with a measured modulus, and what their words give."""
    rows = [
        (tissue.name, show(written, PRESSURE), show(by_words, PRESSURE), f"{ratio:.2f}")
        for tissue, written, by_words, ratio in _moduli()
    ]
    return table(("tissue", "Young's modulus", "from its words", "ratio"), rows)


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


def _moduli() -> list[tuple[Tissue, float, float, float]]:
    found: list[tuple[Tissue, float, float, float]] = []
    for path in sorted((library() / "matter").glob("*.tis")):
        for tissue in read_words(Request.file(path))[0].tissues.values():
            given = tissue.given[YOUNGS_MODULUS]
            if given.how == "written":
                by_words = tissue.concluded[YOUNGS_MODULUS]
                found.append((tissue, given.value, by_words, given.value / by_words))
    return sorted(found, key=lambda row: row[1])


@cache
def _vocabulary() -> Vocabulary:
    return read_words(Request.file(library() / "fuzzy" / "soft_matter.tis"))[0].vocabulary


def _modulus(hardness: str) -> str:
    facts = {
        name: _place(name, phrase)
        for name, phrase in (NEUTRAL | {"hardness": hardness}).items()
    }
    answer = _vocabulary().rules[RULES].base.conclude(YOUNGS_MODULUS, facts)
    assert isinstance(answer, Inference)
    return show(answer.value, PRESSURE)


def _place(name: str, phrase: str) -> float:
    words = _vocabulary()
    *front, word = phrase.split()
    scale = words.properties[name].scale
    shape = hedged([words.hedges[one] for one in front], scale.words[word], scale.axis)
    return scale.axis.value_of(shape)
