"""Forms of verbs: each can be written as the reference shows it, and nothing else is taken."""

import re

from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.core.units import suggested_unit
from tissuec.pipeline import check_request
from tissuec.scene.request import Request
from tissuec.script.forms import forms_of, texts_of
from tissuec.script.parts import DirectedClause, NumberClause, RangeClause
from tissuec.script.verbs import VERBS

SCENE = """language 1
tissue gum {
  spring constant = 40 N/m; viscosity = 0.01 N*s/m; mass = 10 mg; breaking force = 10 N
}
body vessel {
  mesh is tube {
    axis from (0, 0, 0) mm to (20, 0, 0) mm; radius = 3 mm; rings = 5; sides = 10
    diagonals is both; interior is crossed
  }
  tissue is gum; rupture is allowed
}
body ball {
  mesh is sphere { centre = (0, 60, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is gum
}
body cord {
  mesh is thread { line from (0, 0, 30) mm to (20, 0, 30) mm; pieces = 5; thickness = 0.2 mm }
  tissue is gum; rupture is allowed
}
set root = nodes of vessel where x < 1 mm
set tip = nodes of vessel where x > 19 mm
set top = nodes of ball where y > 0 mm
set seam = springs of vessel where x < 5 mm
joint stitches { springs from root to tip; tissue is gum }
tool forceps A {
  kind is forceps; radius = 0.5 mm
  upper from (0, 0, 90) mm to (9, 0, 90) mm; lower from (0, 0, 80) mm to (9, 0, 80) mm
}
tool shears { kind is scissors }
tool jet { kind is nozzle; diameter = 2 mm; tip = (0, 60, 40) mm; direction = (0, 0, -1) }
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 s }
script {
ORDERS
}
"""
NAMES = {"SET": "tip", "BODY": "ball", "TOOL": "forceps A", "THREAD": "cord",
         "JOINT": "stitches", "NOZZLE": "jet", "PROFILE": "smooth profile"}  # fmt: skip
#: What is special about some verbs: a name for a place.
OWN = {"cut": {"SET": "seam", "BODY": "vessel", "TOOL": "shears"}, "tie": {"SET": "cord"}}


def written(verb, text):
    """Return a form with names and values for its capital words."""
    forms = sorted(forms_of(verb), key=lambda form: len(form.literal))
    form = [f for f in forms if not f.literal or f" {f.literal} " in f"{text} "][-1]

    def value(found):
        word, part = found[1], form.of_word(found[1])
        unit = suggested_unit(form.dimension_of(word))
        if isinstance(part, DirectedClause) and part.along in text.split():
            return f"{word} 1 {unit}"
        if part is not None and part.example and "…" not in part.example:
            return part.example
        if isinstance(part, NumberClause):
            return f"{word} 1 {unit}"
        return found[0]

    for part in form.parts.values():
        if isinstance(part, RangeClause):
            place = part.placeholder
            text = text.replace(f"{part.word} {place} to {place}", part.example)
    text = re.sub(r"\b([a-z]+) ([A-Z]+)\b", value, text)
    for name, known in {**NAMES, **OWN.get(verb, {})}.items():
        text = re.sub(rf"\b{name}\b", known, text)
    return text


def findings(orders):
    """Return the codes of findings in a scene with orders, at most ten."""
    text = SCENE.replace("ORDERS", "\n".join(orders))
    try:
        _, found = check_request(Request(Source("scene.tis", text)))
    except CompileError as error:
        found = error.diagnostics
    begin = text.index("script {")
    return {one.span.text: one.code for one in found if one.span and one.span.start > begin}


def test_every_form_of_every_verb_can_be_written():
    orders: list[str] = []
    for verb in VERBS:
        for text in texts_of(verb, every=True):
            if "table" not in text:
                order = written(verb, text)
                lasts = "using" in order or "along line" in order
                orders.append(f"{'from 0.1 s to 0.2 s' if lasts else 'at 0.1 s'}: {order}")
    assert len(orders) > 100
    found, allowed = {}, ("TIS309", "TIS401", "TIS402", "W504")
    for first in range(0, len(orders), 8):
        found |= findings(orders[first : first + 8])
    # What is wrong is not the sentence, but what the net or the order of events permits.
    assert {one: code for one, code in found.items() if code not in allowed} == {}
