"""Laws as machine code do what their formulas say."""

import ctypes

import numpy as np
import pytest

from tissuec.compiled import laws as compiled_laws
from tissuec.laws import LINEAR, SPRING_LAWS, VISCOSITY_LAWS, C, D, E, Law, W, with_modulus
from tissuec.laws.code import ARGUMENTS, functions
from tissuec.laws.formula import Applied, Choice, Variable, VariablePower, apply, exp

PLACES = np.array([-4e-3, -1e-3, -7e-4, 0.0, 2e-4, 1e-3, 2.6e-3, 5e-3])
SPEEDS = np.array([-0.3, -1e-3, 0.0, 0.02, 0.4])
ENTRIES = {
    "curve": {"elongations": (-1e-3, 0.0, 1e-3, 2e-3), "forces": (-0.1, 0.0, 0.02, 0.3)},
    "dead band": {"slack": 4e-4},
    "exponential": {"stiffening": 12.0},
    "linear": {},
    "polynomial": {"square": 3e3, "cube": 4e5},
    "stress curve": {"strains": (-0.1, 0.0, 0.2), "stresses": (-5e3, 0.0, 15e3)},
    "tension only": {},
    "toe": {"strain": 0.03},
}
FREE = [
    Law("roots", apply("abs", (E,)) ** 0.5 * C, D * W**3),
    Law("inverse", C * E * (1.0 + E) ** -2.0, D * W / (1.0 + 100.0 * E * E)),
    Law("waves", Applied("sin", 900.0 * E) + Applied("cos", E) - 1.0, LINEAR.viscous),
    Law("growth", C * E * exp(E), D * Applied("log", exp(W)) + 0.0 * E),
    Law(
        "variable",
        VariablePower(apply("abs", (E,)), C / 10.0),
        D * apply("max", (W, 0.5 * W, Choice(E, W, -W))),
    ),
]


def named():
    """Return one law of every member of both families."""
    for name, family in SPRING_LAWS.items():
        force = with_modulus(family(**ENTRIES[name]).force(), 10e3)
        yield Law(name, force, LINEAR.viscous)
    power = VISCOSITY_LAWS["power"](exponent=1.5, speed=0.1).force()
    yield Law("power", LINEAR.elastic, power)


LAWS = (LINEAR, *named(), *FREE)


@pytest.mark.parametrize("name", ARGUMENTS)
def test_compiled_laws_do_what_their_formulas_say(name):
    count = len(ARGUMENTS[name])
    kinds = [ctypes.c_int32, *(ctypes.c_double for _ in range(count)), ctypes.c_void_p]
    address = compiled_laws.address(name, LAWS)
    compiled = ctypes.CFUNCTYPE(ctypes.c_double, *kinds)(address)
    plain = functions(LAWS)[name]
    for law in range(len(LAWS)):
        for e in PLACES:
            for w in SPEEDS if count == 4 else (0.0,):
                values = (e, w, 0.3, 0.01) if count == 4 else (e, 20.0, 0.01)
                found = compiled(law, *values, None)
                with np.errstate(all="ignore"):
                    expected = evaluated(plain, law, values)
                # Contracted sums and powers by other products round otherwise.
                assert found == pytest.approx(expected, rel=1e-12, abs=1e-15, nan_ok=True)


def evaluated(function, law, values):
    """Return what a function of Python gives, with infinity where that fails."""
    try:
        return function(law, *values)
    except ZeroDivisionError:
        return np.inf


def test_laws_are_translated_once():
    assert compiled_laws.address("pull", LAWS) == compiled_laws.address("pull", LAWS)
    other = (LINEAR, Law("other", 2.0 * C * E, LINEAR.viscous))
    assert compiled_laws.address("pull", other) != compiled_laws.address("pull", LAWS)


def test_a_formula_of_another_kind_is_refused():
    class Unknown(Variable):
        """No part of the language."""

    law = Law("unknown", C * E + Unknown("x"), LINEAR.viscous)
    with pytest.raises(KeyError):
        compiled_laws.address("pull", (LINEAR, law))
