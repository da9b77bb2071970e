"""``repeat``: the same as its copies written out, and findings with the line and the index."""

import numpy as np

from tests.findings import finding_of
from tests.validate.scenes import compiled_scene
from tests.whole_runs import carried_out
from tissuec.core.errors import as_dict
from tissuec.core.source import Source
from tissuec.lang.parser import parse
from tissuec.lang.printer import format_source
from tissuec.scene.program.repetition import repeated
from tissuec.scene.reading.findings import Findings

WOUND = """language 1
tissue skin { spring constant = 40 N/m; viscosity = 0.02 N*s/m; mass = 10 mg }
tissue silk { spring law is tension only; spring constant = 90 N/m; viscosity = 0.1 N*s/m }
body lip { mesh is sheet { corner = (0, 0, 0) mm; first edge = (40, 0, 0) mm
  second edge = (0, 10, 0) mm; columns = 9; rows = 3; diagonals is both }; tissue is skin }
body other lip like lip { moved by (0, 13, 0) mm }
environment { gravity = (0, 0, 0) m/s^2; damping = 20 mN*s/m }
BODY
simulate { duration = 20 ms; integrator is dop853; tolerance = 1e-5 }
"""


def written(items):
    return parse(Source("items.tis", items), has_heading=False).items


def names(items):
    findings = Findings()
    found = [item.name.text for item in repeated(written(items), findings)]
    findings.raise_errors()
    return found


def test_copies_are_those_that_are_written_out():
    several = WOUND.replace("BODY", """
repeat i from 1 to 3 {
  set bite i = nodes of lip where y > 9 mm and within 0.1 mm of (i * 10 mm, 10 mm, 0 mm)
  set exit i = nodes of other lip where y < 14 mm
    and within 0.1 mm of (i * 10 mm, 13 mm, 0 mm)
  joint stitch i { springs from bite i to exit i; tissue is silk }
}
script {
  at 0 s: fix [lip, other lip]
  repeat i from 1 to 3 { at i * 2 ms: tighten stitch i to 1 mm }
}
output { repeat i from 1 to 3 { tension of "stitch {i}" every 5 ms }; trajectory every 5 ms }
""")  # fmt: skip
    copies = "".join(
        f"""
set "bite {i}" = nodes of lip where y > 9 mm and within 0.1 mm of ({i} * 10 mm, 10 mm, 0 mm)
set "exit {i}" = nodes of other lip where y < 14 mm
  and within 0.1 mm of ({i} * 10 mm, 13 mm, 0 mm)
joint "stitch {i}" {{ springs from "bite {i}" to "exit {i}"; tissue is silk }}
"""
        for i in (1, 2, 3)
    )
    orders = "".join(f'  at {i} * 2 ms: tighten "stitch {i}" to 1 mm\n' for i in (1, 2, 3))
    logs = "".join(f'tension of "stitch {i}" every 5 ms; ' for i in (1, 2, 3))
    script = f"script {{\n  at 0 s: fix [lip, other lip]\n{orders}}}\n"
    once = WOUND.replace("BODY", f"{copies}{script}output {{ {logs}trajectory every 5 ms }}\n")
    recordings = [carried_out(compiled_scene(text))[1] for text in (several, once)]
    for one, other in zip(*(r.frame_arrays() for r in recordings), strict=True):
        assert np.array_equal(one, other, equal_nan=True)
    for log in ("tension of stitch 1", "tension of stitch 3"):
        one, other = (r.log_arrays(log)[1] for r in recordings)
        assert np.array_equal(one, other) and (one > 0.0).any()


def test_the_index_is_a_word_of_names_and_a_number_elsewhere():
    assert names("repeat i from 2 to 3 { set part i here = nodes of a in [i] }") == [
        "part 2 here", "part 3 here",
    ]  # fmt: skip
    (one, two) = repeated(
        written("repeat k from -1 to 0 { let step k = k * 2 mm }"), Findings()
    )
    assert (one.name.text, two.name.text) == ("step -1", "step 0")
    assert str(one.value) != str(two.value)


def test_quotes_take_the_index_in_braces_with_a_number_added_or_subtracted():
    text = 'repeat i from 1 to 2 { let "gap {i - 1} to {i + 1}" = i; let "plain i" = 1 }'
    assert names(text) == ["gap 0 to 2", "plain i", "gap 1 to 3", "plain i"]


def test_the_index_can_be_one_of_some_words_or_numbers():
    text = "repeat side in [left, far right] { let edge side = 1; let both side ends = 2 }"
    assert names(text) == [
        "edge left", "both left ends", "edge far right", "both far right ends",
    ]  # fmt: skip
    assert names("repeat k in [5, 3] { let n k = k }") == ["n 5", "n 3"]


def test_repetitions_can_be_inside_of_one_another_and_of_blocks():
    text = "repeat i from 1 to 2 { repeat j from 1 to i { let cell i and j = 1 } }"
    found = names(text.replace("cell i and j", "cell i j"))
    assert found == ["cell 1 1", "cell 2 1", "cell 2 2"]
    (block,) = repeated(
        written("script { repeat i from 1 to 2 { at i * 1 s: fix base i } }"), Findings()
    )
    assert len(block.items) == 2


def test_what_repeats_nothing_remains_the_same():
    items = written("let a = 1 mm\nscript { at 0 s: fix base }")
    assert all(
        one is other for one, other in zip(repeated(items, Findings()), items, strict=True)
    )


def test_a_mistake_in_one_copy_is_reported_with_its_index():
    text = WOUND.replace("BODY", """
repeat i from 1 to 5 { set bite i = nodes of lip where within 1 mm of (i * 10 mm, 0 mm, 0 mm) }
""")  # fmt: skip
    found = finding_of(compiled_scene, text)
    assert found.code == "TIS302" and '"bite 5" is empty' in found.message
    assert found.span.line == 9 and "where i = 5" in str(found)
    assert as_dict(found)["notes"][-1]["message"] == "where i = 5"


def test_a_mistake_in_all_copies_is_reported_once():
    text = WOUND.replace(
        "BODY", "repeat i from 1 to 5 { set b i = nodes of lib where x > 1 mm }"
    )
    found = finding_of(compiled_scene, text)
    assert "where i = 1" in str(found) and "bodies: lip, other lip" in found.hint


def test_layout_and_syntax_keep_a_repetition_as_it_is_written():
    text = "language 1\nrepeat i   from 1 to 8 {let a i=i*2 mm}\n"
    printed = format_source(Source("a.tis", text))
    assert printed == "language 1\nrepeat i from 1 to 8 { let a i = i * 2 mm }\n"
    assert parse(Source("a.tis", printed)) == parse(Source("a.tis", text))


def test_what_is_measured_in_copies_has_a_name_with_the_index():
    text = WOUND.replace("BODY", """
repeat i from 1 to 2 { set b i = nodes of lip where within 1 mm of (i * 10 mm, 0 mm, 0 mm) }
param way = 1 mm
study pulls {
  vary way = [1 mm, 2 mm]
  repeat i from 1 to 2 { measure = max(speed("b {i}")); measure top i = max(speed(b i)) }
}
""")  # fmt: skip
    (study,) = compiled_scene(text).scene.studies.values()
    assert [one.name for one in study.measures] == [
        'max(speed("b 1"))', "top 1", 'max(speed("b 2"))', "top 2",
    ]  # fmt: skip
