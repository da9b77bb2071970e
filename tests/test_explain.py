"""`tissuec explain`, in all its forms, of every law, every shipped scene and every preset."""

import json
import math
from itertools import chain, combinations, product
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from tests.every import every
from tests.laws.test_laws import SPRING, VISCOUS
from tests.laws.test_solid_laws import KEEPING, SAMPLES
from tissuec.cli import group
from tissuec.core.resources import library
from tissuec.core.source import Source, Span
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.laws.formula import ZERO
from tissuec.laws.solid import SOLID_LAWS
from tissuec.learn.presets.tissues import law_text
from tissuec.pipeline import read_words
from tissuec.scene.model import WrittenLaw
from tissuec.scene.request import Request

OPTIONS = ("--json", "--plan", "--bodies")
#: What the command says of words alone, and of the scene in arrays.
OF_WORDS: list[tuple[str, ...]] = [(), ("--json",)]
FORMS = [*chain.from_iterable(combinations(OPTIONS, count) for count in range(4))]
SHIPPED = sorted(library().rglob("*.tis"))

NET = "spring constant = 20 N/m; viscosity = 0.1 N*s/m; mass = 1 g"
MATTER = "Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 1 ms"
THREAD = "thread { line from (0, 0, 0) mm to (20, 0, 0) mm; pieces = 2; thickness = 2 mm }"
BLOCK = "lattice { cell = 5 mm; box from (0, 0, 0) mm to (10, 5, 5) mm }"
FAMILIES = {
    "spring law": (SPRING_LAWS, SPRING),
    "viscosity law": (VISCOSITY_LAWS, VISCOUS),
    "solid law": (SOLID_LAWS, SAMPLES),
}


def explained(path: Path, *options: str) -> str:
    found = CliRunner().invoke(group, ["explain", str(path), *options])
    assert found.exit_code == 0, found.output
    return found.stdout


def every_law():
    """Yield the entry of a tissue, its numbers, and the mesh of a body, for every law."""
    constants = read_words(Request(Source("t.tis", "language 1")))[0].constants
    for word, (family, samples) in FAMILIES.items():
        for name, member in family.items():
            law = WrittenLaw(name, ZERO, Span(Source("", ""), 0, 0), member(**samples[name]))
            text = law_text(word, law, {}, constants)
            is_net = word != "solid law" and name != "stress curve"
            if word != "solid law" or name in KEEPING:  # others are no laws of bars
                yield text, NET if is_net else MATTER, THREAD
            if not is_net:
                yield text, MATTER, BLOCK


def explain_laws(folder, forms, laws):
    path = folder / "law.tis"
    for (law, numbers, mesh), options in product(laws, forms):
        path.write_text(
            f"language 1\ntissue gum {{ {numbers}; {law} }}\n"
            f"body bar {{ mesh is {mesh}; tissue is gum }}\n"
            "environment { gravity = (0, 0, 0) m/s^2 }\nsimulate { duration = 1 ms }\n"
        )
        said = explained(path, *options)
        word, _, rest = law.partition(" is ")
        name = rest.split(" {")[0]
        if "--json" in options:
            found = json.loads(said)["tissues"]["gum"]["laws"][word]
            assert found["law"] == name
            assert found["energy" if word == "solid law" else "force"]
        else:
            assert f"{word}" in said and name in said


def test_every_law_is_explained(tmp_path):
    explain_laws(tmp_path, OF_WORDS, every_law())


def test_a_law_without_code_is_explained_with_bodies_and_plan(tmp_path):
    explain_laws(tmp_path, [OPTIONS], [one for one in every_law() if "ogden" in one[0]])


@pytest.mark.slow  # every law by words, and one of them with its bodies: above
def test_every_law_is_explained_in_every_form(tmp_path):
    explain_laws(tmp_path, FORMS, every_law())


@every("name", SAMPLES)
def test_the_energy_that_is_explained_is_that_of_the_law(name):
    law, squares = SOLID_LAWS[name](**SAMPLES[name]), np.array([1.9, 0.7, 1.0 / (1.9 * 0.7)])
    values = {"i1": squares.sum(), "i2": (1.0 / squares).sum(), "trace": squares.sum()}
    values |= {"cofactors": values["i2"], "j": 1.0, "lame": 3.0}
    stretches = dict(zip(("l1", "l2", "l3"), np.sqrt(squares).tolist(), strict=True))
    found = eval(law.energy().code(), {**vars(math), **values, **stretches})
    # Stretches of 1.9 lose four digits in the zeros that sums over stretches are found from.
    assert found == pytest.approx(float(law.energy().at(values)), rel=1e-12)


@every("path", SHIPPED, ids=lambda path: path.stem, parts=2)
def test_whatever_is_shipped_is_explained(path):
    for options in OF_WORDS:
        explained(path, *options)


@pytest.mark.slow  # what is shipped by words, and a small body: above
@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_shipped_scenes_are_explained_in_every_form(path):
    if path.parent.name == "scenes":
        for options in (("--plan",), ("--bodies",), ("--plan", "--bodies", "--json")):
            explained(path, *options)
