"""A vocabulary of gels, and gels whose numbers are those that its words give."""

import random
from pathlib import Path

from tissuec.core.source import Source
from tissuec.pipeline import read_words
from tissuec.scene.request import Request

VOCABULARY = """language 1
about "Words of gels."
property firmness from 0 to 10 { evenly = [soft, medium, firm] }
property weight from 0 to 10 { evenly = [light, heavy] }
# The numbers of the gels.
quantity Young's modulus from 1 kPa to 1 MPa on log scale {
  low = triangle(1 kPa, LOW, MEDIUM)
  medium = triangle(LOW, MEDIUM, HIGH)
  high = triangle(MEDIUM, HIGH, 1 MPa)
}
quantity density from 0.9 g/cm^3 to 1.3 g/cm^3 { evenly = [low, high] }
rules gel {
  conjunction is product
  result is gradual mean
  if firmness is soft then Young's modulus is low weighing WEIGHT
  if firmness is medium then Young's modulus is medium
  if firmness is firm then Young's modulus is high
  if weight is light then density is low and Young's modulus is low weighing 0.2
  if weight is heavy then density is high
}
"""
PLACES = {"LOW": "4 kPa", "MEDIUM": "40 kPa", "HIGH": "300 kPa", "WEIGHT": "0.5"}
LEARN = """
learn gels {
  fit = Young's modulus of all tissues
  adjust words of Young's modulus
  adjust weights of gel
  write "learnt/gels.tis"
}
"""


def vocabulary(**places):
    text = VOCABULARY
    for name, place in (PLACES | places).items():
        text = text.replace(name, place)
    return text


def tissues(text, many=12, seed=1):
    """Return tissues whose numbers are those that the words of a vocabulary give."""
    source = random.Random(seed)
    lines = []
    for number in range(many):
        firmness, weight = (f"{source.uniform(0, 10):.3f}" for _ in range(2))
        facts = f"described in gel; firmness = {firmness}; weight = {weight}"
        lines.append(f"tissue gel {chr(65 + number)} {{ {facts} }}")
    words, _ = read_words(Request(Source("words.tis", text + "\n".join(lines))))
    given = [tissue.concluded["young's modulus"] for tissue in words.tissues.values()]
    return [
        line.replace(" }", f"; Young's modulus = {value:.17g} Pa }}")
        for line, value in zip(lines, given, strict=True)
    ]


def request_of(folder: Path, text: str, more: str = LEARN):
    (folder / "words.tis").write_text(text)
    (folder / "fit.tis").write_text(f'language 1\nuse "./words"\n{more}\n')
    return Request.file(folder / "fit.tis")
