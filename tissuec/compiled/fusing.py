"""Products and sums that are rounded once, said explicitly.

Left to LLVM, a b + c is fused where the processor can and where it happens to be cheap there,
so that results would differ between processors.
"""

import re
from collections import Counter

_DEFINED = re.compile(r"^define .*?^}", re.MULTILINE | re.DOTALL)
_NAME = re.compile(r'%"[^"]+"|%[-\w.$]+')
_KINDS = {"double": "f64", "<2 x double>": "v2f64"}
_OPERATION = re.compile(rf"  (\S+) = (fadd|fmul|fsub) ({'|'.join(_KINDS)}) (.+), ([^,]+)")


def fused(text: str) -> str:
    """Return a module in which products that are only added or subtracted once are fused.

    Args:
        text: Intermediate representation, with values in registers.
    """
    text = _DEFINED.sub(lambda found: _fused(found[0]), text)
    for kind, suffix in _KINDS.items():
        declared = f"declare {kind} @llvm.fma.{suffix}("
        if f"@llvm.fma.{suffix}(" in text and declared not in text:
            text += f"\n{declared}{kind}, {kind}, {kind})\n"
    return text


def _fused(function: str) -> str:
    uses = Counter(_NAME.findall(function))
    products: dict[str, tuple[int, str, str]] = {}  # by name: line and factors
    lines = function.split("\n")
    for place, line in enumerate(lines):
        found = _OPERATION.fullmatch(line)
        if found is None:
            continue
        name, operation, kind, left, right = found.groups()
        if operation == "fmul":
            if uses[name] == 2:  # where it is defined, and once more
                products[name] = place, left, right
            continue
        product, other = (right, left) if right in products else (left, right)
        if product not in products:
            continue
        at, one, two = products.pop(product)
        lines[at] = lines[place] = ""
        if operation == "fsub":
            negative = f"%negative.{place}"
            changed = one if product == right else other
            lines[place] = f"  {negative} = fneg {kind} {changed}\n"
            one, other = (negative, other) if product == right else (one, negative)
        values = ", ".join(f"{kind} {value}" for value in (one, two, other))
        lines[place] += f"  {name} = call {kind} @llvm.fma.{_KINDS[kind]}({values})"
    return "\n".join(lines)
