"""Laws of springs and dashpots as machine code."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

from llvmlite import ir

from tissuec.compiled import mathematics
from tissuec.compiled.loading import machine_code
from tissuec.compiled.record_tables import layout
from tissuec.kernels.derivative_records import Values
from tissuec.laws import Law, code, partial
from tissuec.laws.formula import (
    ZERO,
    Applied,
    Choice,
    Constant,
    Formula,
    Power,
    Product,
    Quotient,
    Spline,
    Sum,
    Variable,
    VariablePower,
)
from tissuec.laws.partial import constant_name

_NUMBER, _WHOLE, _ADDRESS = ir.DoubleType(), ir.IntType(32), ir.IntType(64)
_LARGEST_EXPONENT = 64  # of whole ones that are multiplied out


@cache
def address(name: str, laws: tuple[Law, ...]) -> int:
    """Return where a function of ``laws.code.functions`` is in memory, for some laws.

    In C, it is ``double name(int law, double …, void *net)``.
    """
    return int(_module(translated(laws)).get_function_address(name))


@cache
def partial_address(name: str, laws: tuple[Law, ...], constants: int) -> int:
    """Return the address of a function of ``laws.partial.formulas``, compiled for some laws.

    In C, it is ``double name(int law, double …, void *laws, void *values)``, where values are
    the table of a ``kernels.derivative_records.Values``; the second argument of
    ``by_constant`` is ``int number``.

    Args:
        name: Name of the function.
        laws: The laws of the scene.
        constants: Number of constants that may change.
    """
    return int(_module(translated_partials(laws, constants)).get_function_address(name))


@cache
def _module(text: str) -> Any:
    return machine_code("of_laws", text.encode(), lambda: text)


@cache
def translated(laws: tuple[Law, ...]) -> str:
    """Return the functions of laws in LLVM's intermediate representation."""
    module = ir.Module("laws")
    for name, members in code.formulas(laws).items():
        builder, (law,), known, _ = _begun(module, name, 1, code.ARGUMENTS[name], 1)
        _choose(builder, law, members, lambda _, known=known: known)
    return str(module)


@cache
def translated_partials(laws: tuple[Law, ...], constants: int) -> str:
    """Return the functions of laws and their derivatives, as ``translated`` does."""
    module = ir.Module("partials")
    for name, members in partial.formulas(laws, constants).items():
        numbers = 2 if name == "by_constant" else 1
        builder, (number, *constant), known, (_, table) = _begun(
            module, name, numbers, partial.ARGUMENTS[name], 2
        )
        if constant:
            row = builder.mul(number, ir.Constant(_WHOLE, constants))
            number = builder.add(row, constant[0])

        def read(inside: Any, known: dict[str, Any] = known, table: Any = table) -> Any:
            return known | _constants(inside, table, constants)

        _choose(builder, number, members or [ZERO], read)
    return str(module)


def _begun(
    module: Any, name: str, numbers: int, arguments: Sequence[str], tables: int
) -> tuple[Any, Sequence[Any], dict[str, Any], Sequence[Any]]:
    """Begin a function of whole numbers, arguments and tables.

    Returns:
        What writes it, the numbers, the arguments by name, and the tables.
    """
    kinds = [_WHOLE] * numbers + [_NUMBER for _ in arguments] + [_ADDRESS] * tables
    function = ir.Function(module, ir.FunctionType(_NUMBER, kinds), name)
    given, stop = function.args, numbers + len(arguments)
    known = dict(zip(arguments, given[numbers:stop], strict=True))
    return ir.IRBuilder(function.append_basic_block()), given[:numbers], known, given[stop:]


def _constants(builder: Any, values: Any, count: int) -> dict[str, Any]:
    """Read constants that may change from the table of ``Values``; what is unused goes."""
    if not count:
        return {}
    place = layout(Values)[0]["constants"].place
    at = builder.inttoptr(values, _ADDRESS.as_pointer())
    word = builder.load(builder.gep(at, [_ADDRESS(place)], source_etype=_ADDRESS))
    first = builder.inttoptr(word, _NUMBER.as_pointer())
    return {
        constant_name(k): builder.load(builder.gep(first, [_ADDRESS(k)], source_etype=_NUMBER))
        for k in range(count)
    }


def _choose(
    builder: Any, number: Any, members: list[Formula], known: Callable[[Any], dict[str, Any]]
) -> None:
    """Write what evaluates the formula of a number.

    Args:
        known: Returns the values of variables, in a block that is given.
    """
    function = builder.function
    chosen = builder.switch(number, function.append_basic_block())
    for place, formula in enumerate(members):
        if place and formula == members[0]:
            continue
        block = function.append_basic_block() if place else chosen.default
        if place:
            chosen.add_case(ir.Constant(_WHOLE, place), block)
        inside = ir.IRBuilder(block)
        inside.ret(_Writer(inside, known(inside)).value(formula))


class _Writer:
    """Writes formulas as instructions; parts that several share are written once."""

    def __init__(self, builder: ir.IRBuilder, known: dict[str, Any]):
        self.builder, self._known = builder, known
        self._written: dict[int, tuple[Formula, Any]] = {}  # by identity, and kept for it

    def value(self, formula: Formula) -> Any:
        """Return the value of a formula."""
        if id(formula) not in self._written:
            self._written[id(formula)] = formula, self._value(formula)
        return self._written[id(formula)][1]

    def _value(self, formula: Formula) -> Any:
        builder = self.builder
        match formula:
            case Constant(value):
                return ir.Constant(_NUMBER, value)
            case Variable(name):
                return self._known[name]
            case Sum(left, right, minus):
                join = builder.fsub if minus else builder.fadd
                return join(self.value(left), self.value(right))
            case Product(left, right):
                return builder.fmul(self.value(left), self.value(right))
            case Quotient(above, below):
                return builder.fdiv(self.value(above), self.value(below))
            case Power(base, exponent):
                return self._power(self.value(base), exponent)
            case VariablePower(base, exponent):
                return self._call("pow", self.value(base), self.value(exponent))
            case Applied(function, argument):
                return self._call(function, self.value(argument))
            case Choice(test, above, below):
                is_above = self._is_at_least(self.value(test), 0.0)
                return builder.select(is_above, self.value(above), self.value(below))
            case Spline():
                return self._spline(formula)
            case _:
                raise TypeError(f"{type(formula).__name__} cannot be translated")

    def _is_at_least(self, value: Any, limit: float) -> Any:
        return self.builder.fcmp_ordered(">=", value, ir.Constant(_NUMBER, limit))

    def _call(self, function: str, *arguments: Any) -> Any:
        module = self.builder.module
        if function in mathematics.FUNCTIONS:
            return self.builder.call(mathematics.function(module, function), arguments)
        called = mathematics.declared(module, f"llvm.{function}.f64", len(arguments))
        return self.builder.call(called, arguments)

    def _power(self, base: Any, exponent: float) -> Any:
        builder, size = self.builder, abs(exponent)
        if exponent != int(exponent) or size > _LARGEST_EXPONENT:
            return self._call("pow", base, ir.Constant(_NUMBER, exponent))
        left, square, result = int(size), base, None
        while left:
            if left & 1:
                result = square if result is None else builder.fmul(result, square)
            left >>= 1
            if left:
                square = builder.fmul(square, square)
        one = ir.Constant(_NUMBER, 1.0)
        if result is None:
            return one
        return result if exponent > 0.0 else builder.fdiv(one, result)

    def _spline(self, spline: Spline) -> Any:
        """Return the value of the piece that the argument is in."""
        builder, x = self.builder, self.value(spline.argument)
        first, *_ = spline.places
        rows = [(spline.pieces[0][0], spline.before, 0.0, 0.0, first)]
        rows += [(*row, at) for row, at in zip(spline.pieces, spline.places, strict=True)]
        chosen = [ir.Constant(_NUMBER, number) for number in rows[0]]
        for row in rows[1:]:
            is_here = self._is_at_least(x, row[-1])
            chosen = [
                builder.select(is_here, ir.Constant(_NUMBER, number), other)
                for number, other in zip(row, chosen, strict=True)
            ]
        value, slope, bend, twist, place = chosen
        z = builder.fsub(x, place)
        total = builder.fadd(bend, builder.fmul(z, twist))
        total = builder.fadd(slope, builder.fmul(z, total))
        return builder.fadd(value, builder.fmul(z, total))
