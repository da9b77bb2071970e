"""Products and sums that are fused, and that nothing else depends on the processor."""

import lzma
import re

import pytest

from tissuec.compiled.fusing import fused
from tissuec.compiled.loading import ENDING, SHIPPED

FUNCTION = """define {kind} @f({kind} %a, {kind} %b, {kind} %c) {{
  %p = fmul {kind} %a, %b
  %s = {sum}
  ret {kind} %s
}}
"""
# By the sum: the arguments of what replaces it, and what is negated.
SUMS = {
    "fadd {kind} %p, %c": ("%a", "%b", "%c", None),
    "fadd {kind} %c, %p": ("%a", "%b", "%c", None),
    "fsub {kind} %p, %c": ("%a", "%b", "N", "%c"),
    "fsub {kind} %c, %p": ("N", "%b", "%c", "%a"),
}


@pytest.mark.parametrize("kind", ["double", "<2 x double>"])
@pytest.mark.parametrize("form", SUMS)
def test_a_product_that_is_added_once_is_fused(form, kind):
    text = fused(FUNCTION.format(kind=kind, sum=form.format(kind=kind)))
    assert not re.search("fmul|fadd|fsub", text)
    *names, negated = SUMS[form]
    (called,) = re.findall(r"%s = call .*fma\.\w+\((.*)\)", text)
    found = [re.sub(r"%negative.*", "N", one.split()[-1]) for one in called.split(", ")]
    assert found == names
    assert re.findall(r"fneg .* (%\S+)", text) == [negated] * (negated is not None)
    assert text.count("declare") == 1


def test_products_that_are_used_twice_stay():
    text = FUNCTION.format(kind="double", sum="fadd double %p, %p")
    assert fused(text) == text
    two = "  %q = fmul double %b, %c\n  %s"
    of_two = FUNCTION.format(kind="double", sum="fadd double %p, %q").replace("  %s", two)
    assert "fma.f64(double %b, double %c, double %p)" in fused(of_two)


#: What the bundles may leave to LLVM: it gives the same on every processor.
EXACT = {
    *("ceil", "copysign", "fabs", "floor", "fma", "rint", "sqrt"),
    *("abs", "smax", "smin", "umax", "umin", "memcpy", "memmove", "memset", "trap"),
    *("experimental", "assume"),
}


@pytest.mark.parametrize("path", sorted(SHIPPED.glob(f"*{ENDING}")), ids=lambda path: path.name)
def test_bundles_leave_no_rounding_to_the_processor_or_to_the_library(path):
    text = lzma.decompress(path.read_bytes()).decode()
    flags = "contract|reassoc|arcp|afn|fast|nnan|ninf|nsz"
    assert not re.search(rf"= (call|f\w+|select|phi) ({flags}) ", text)
    declared = re.findall(r"^declare .*@(?:llvm\.)?(\w+)", text, re.MULTILINE)
    assert set(declared) <= EXACT
