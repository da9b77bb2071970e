"""Functions of a scene: their values wherever numbers are written, and their mistakes."""

import numpy as np
import pytest

from tests.every import every
from tests.validate.scenes import compiled_scene
from tissuec.core.errors import CompileError
from tissuec.core.source import Source
from tissuec.pipeline import compile_request, read_words
from tissuec.scene.request import Request

REST = """
tissue gel { Young's modulus = 10 kPa; density = 1000 kg/m^3; retardation time = 2 ms }
body bar {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (20, 5, 5) mm }; tissue is gel
}
set left = nodes of bar where x < 0.1 mm
set right = nodes of bar where x > 19.9 mm
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
"""


def value(text, name="found", overrides=()):
    request = Request(Source("f.tis", f"language 1\n{text}\n"), overrides=overrides)
    words, _ = read_words(request)
    return words.constants.definitions.find(name)


def said(text):
    with pytest.raises(CompileError) as error:
        compile_request(Request(Source("f.tis", f"language 1\n{text}\n{REST}")))
    return error.value.diagnostics


@every(
    ("text", "number"),
    [
        ("let f(x) = 2 * x + 1\nlet found = f(3)", 7.0),
        ("let found = f(3)\nlet f(x) = 2 * x + 1", 7.0),
        ("let area(r) = pi * r^2\nlet found = area(2 mm)", 4e-6 * np.pi),
        ("let mix ends(a, first end, last end) = first end + a * (last end - first end)\n"
         "let found = mix ends(0.5, 1 N, 2 N)", 1.5),
        ("param c = 4\nlet scaled(x) = c * x\nlet twice(x) = scaled(x) + scaled(x)\n"
         "let found = twice(twice(1))", 64.0),
        ("let c = 3\nlet f(x, c) = x * c\nlet found = f(2, 5) + c", 13.0),
        ("let f(x) = max(x, 2) + sqrt(x)\nlet found = f(9)", 12.0),
        ("let x = 7\nlet f(y) = x * y\nlet g1(x) = f(x)\nlet found = g1(2)", 14.0),
    ],
)  # fmt: skip
def test_a_call_is_the_value_with_its_arguments(text, number):
    assert float(value(text).amount) == pytest.approx(number, rel=1e-14)


def test_arguments_can_be_vectors():
    found = value("let longer(v, a) = a * v\nlet found = longer((1, 0, 2) mm, 3)")
    np.testing.assert_allclose(found.amount, [3e-3, 0.0, 6e-3])


def test_a_param_in_a_value_can_be_set():
    text = "param c = 4\nlet scaled(x) = c * x\nlet found = scaled(2)"
    assert float(value(text, overrides=("c = 5",)).amount) == 10.0
    assert float(value(text + "\nparam d = 1", "d", ("d = scaled(1)",)).amount) == 4.0


def test_names_where_a_function_is_called_mean_nothing_in_it():
    # In the condition of a set, x is a coordinate; in the function, it is the let.
    text = f"let x = 1 mm\nlet beyond(a) = a - x\n{REST}"
    text += "set far = nodes of bar where beyond(z) > 3 mm\n"
    compiled = compiled_scene(f"language 1\n{text}")
    chosen = compiled.network.position[compiled.nodes_of("far")]
    assert (chosen[:, 2] > 4e-3).all() and len(chosen) == 10


def test_functions_can_be_called_in_conditions_and_the_script():
    text = f"""language 1
let twice(a) = 2 * a
let ratio(a, b) = a / b
{REST}
script {{
  at twice(0.1 ms): fix left
  from 0.2 ms to 0.8 ms: move right by twice(1) * (0.1, 0, 0) mm using smooth profile
  when ratio(distance(left, right), 20 mm) > twice(1): end the run
}}
output {{ force of left every twice(50 us) }}
expect ratio(distance(left, right), 20 mm) between 1.005 and 1.015 at twice(0.45 ms)
"""
    compiled = compiled_scene(text)
    assert [event.time for event in compiled.plan.events] == pytest.approx([2e-4, 2e-4])
    assert len(compiled.plan.expectations) == 1


def test_laws_can_call_functions():
    law = "let stiff(k, s) = k * (exp(8 * s) - 1) / 8\n"
    tissue = (
        "tissue band {{ Young's modulus = 10 kPa; density = 1000 kg/m^3\n"
        "  stress of strain = {} }}\n"
        "body strip {{ tissue is band; mesh is lattice {{\n"
        "  cell = 5 mm; box from (0, 0, 0) mm to (20, 5, 5) mm }} }}\n"
    )
    called = compiled_scene(
        f"language 1\n{law}{tissue.format('stiff(10 kPa, strain)')}{REST}"
    ).network
    written = compiled_scene(
        f"language 1\n{tissue.format('10 kPa * (exp(8 * strain) - 1) / 8')}{REST}"
    ).network
    place = written.position * [1.2, 1.0, 1.0]
    for one, other in zip(called.elements, written.elements, strict=True):
        np.testing.assert_array_equal(one.energies(place), other.energies(place))


def test_an_error_names_the_function_and_the_call():
    first, *_ = said("let longer(x) = x + 1 mm\nlet wrong = longer(2 N)")
    assert first.code == "TIS502"
    assert first.span.text == "1 mm"
    assert [(note.message, note.span.text) for note in first.notes] == [
        ("called here with 2 N", "longer(2 N)")
    ]


def test_a_mistake_that_nobody_calls_is_found():
    (one,) = said("let longer(x) = x + start")
    assert (one.code, one.span.text) == ("TIS301", "start")


def test_values_that_grow_without_end_are_refused():
    lines = ["let f0(x) = x + x"]
    lines += [f"let f{k}(x) = f{k - 1}(x) + f{k - 1}(x)" for k in range(1, 40)]
    first, *_ = said("\n".join([*lines, "let wrong = f39(1)"]))
    assert first.code == "TIS116"


def test_a_chain_that_is_too_long_is_refused():
    lines = ["let f0(x) = x", *(f"let f{k}(x) = f{k - 1}(x) + 1" for k in range(1, 400))]
    for chain in (lines, lines[::-1]):
        first, *_ = said("\n".join([*chain, "let wrong = f399(1)"]))
        assert first.code == "TIS116"


def test_a_long_chain_of_functions_is_worked_out():
    lines = ["let f0(x) = x", *(f"let f{k}(x) = f{k - 1}(x) + 1" for k in range(1, 40))]
    lines.reverse()
    assert float(value("\n".join([*lines, "let found = f39(1)"])).amount) == 40.0
