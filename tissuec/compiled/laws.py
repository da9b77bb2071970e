"""Laws of springs and dashpots as machine code."""

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from tissuec.autodiff.emission import Writer
from tissuec.autodiff.graph import Graph
from tissuec.compiled.generated import linked_code
from tissuec.compiled.loops.frame import LoopText, declarations
from tissuec.laws import Law, code
from tissuec.laws.formula import Formula
from tissuec.laws.tracing import traced


@cache
def address(name: str, laws: tuple[Law, ...]) -> int:
    """Return where a function of ``laws.code.formulas`` is in memory, for some laws.

    In C, it is ``double name(int law, double …, void *net)``.
    """
    return int(_functions(laws).get_function_address(name))


@cache
def _functions(laws: tuple[Law, ...]) -> Any:
    return linked_code("of_laws", _written(code.formulas(laws), code.ARGUMENTS))


def _written(
    members: Mapping[str, Sequence[Formula]], arguments: Mapping[str, Sequence[str]]
) -> LoopText:
    """Return functions of the number of a law, and of what its formula depends on.

    Args:
        members: By the name of each function, the formulas of all laws.
        arguments: By the name of each function, the variables of its formulas.
    """
    lines, called = list[str](), set[tuple[str, int]]()
    for name, formulas in members.items():
        writer, given = Writer(1), arguments[name]
        different = {k: each for k, each in enumerate(formulas) if not k or each != formulas[0]}
        cases = " ".join(f"i32 {k}, label %law.{k}" for k in different if k)
        writer.line(f"switch i32 %law, label %law.0 [ {cases} ]")
        for k, formula in different.items():
            writer.label(f"law.{k}")
            graph = Graph()
            number = traced(formula, {each: graph.input(each) for each in given})
            (value,) = writer.write([number], {each: f"%{each}" for each in given})
            writer.line(f"ret double {value}")
        numbers = ", ".join(f"double %{each}" for each in given)
        lines += [f"define double @{name}(i32 %law, {numbers}, i64 %net) {{", "entry:"]
        lines += [*writer.lines, "}"]
        called |= writer.called
    text = "\n".join([*lines, *declarations(1)]) + "\n"
    return LoopText(text, tuple(sorted(called)), "of_laws", ())
