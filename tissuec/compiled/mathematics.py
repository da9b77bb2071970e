"""exp, log, pow, sin and cos, with the same bits on every processor.

The C library has several versions of them, and chooses by the processor. These consist of
operations that IEEE 754 rounds correctly, fused ones among them:

    exp(x) = 2ⁿ exp(r), r = x - n ln 2;   log(2ᵏ z) = k ln 2 + 2 artanh(s), s = (z - 1)/(z + 1);
    xʸ = exp(y log x);   sin(x) and cos(x) from those of r = x - n π/2,

where series replace functions of what is left, and numbers that would lose digits are kept as
sums of two (T. J. Dekker, A floating-point technique for extending the available precision,
1971). Errors are below one unit in the last place; where a power is near the largest or
smallest number, below 40.
"""

from collections.abc import Callable, Sequence
from decimal import Context, Decimal
from fractions import Fraction
from functools import cache
from math import factorial, inf, nan, pi, sqrt
from typing import Any, TypeAlias

from llvmlite import ir

Value: TypeAlias = Any  # of llvmlite
_NUMBER, _WORD, _BIT = ir.DoubleType(), ir.IntType(64), ir.IntType(1)
_SHIFT = 1.5 * 2.0**52  # added to a small number, it leaves a whole one in the lowest bits
_MANTISSA, _BIAS = 52, 1023  # bits of a number, and the exponent of 1
_LEAST_NORMAL = 2.0**-1022
_USUAL = 708.0  # exp of what is within is normal
_OVERFLOW, _UNDERFLOW = 710.0, -746.0  # exp of what is beyond is infinite, or zero
_MOST_TURNS = 2.0**20  # arguments of sin and cos beyond it are reduced by the number 2 π


def _split(number: Decimal, *bits: int) -> list[float]:
    """Return numbers of so many bits whose sum is a number; the last one is rounded."""
    left, parts = Fraction(number), list[float]()
    for count in bits:
        whole = left
        scale = Fraction(2) ** (count - 1)
        while whole * 2 <= 1:
            whole, scale = whole * 2, scale * 2
        parts.append(float(Fraction(int(left * scale)) / scale))
        left -= Fraction(parts[-1])
    return [*parts, float(left)]


# The first parts have so few bits that whole multiples of them are exact.
_LN_2 = _split(Decimal(2).ln(Context(60)), 42)
_HALF_PI = _split(Decimal("1.5707963267948966192313216916397514420985846996875529104"), 33, 33)


class _Code:
    """Writes operations on numbers of double precision, or on as many side by side as lanes."""

    def __init__(self, builder: Any, lanes: int):
        self.builder, self.lanes = builder, lanes

    def kind(self, one: Value) -> Value:
        """Return the type of values, given that of one of them."""
        return _side_by_side(one, self.lanes)

    def number(self, value: Value) -> Value:
        return value if isinstance(value, ir.Value) else self._constant(_NUMBER, float(value))

    def word(self, value: int) -> Value:
        return self._constant(_WORD, value)

    def _constant(self, kind: Value, value: float) -> Value:
        return ir.Constant(self.kind(kind), value if self.lanes == 1 else [value] * self.lanes)

    def intrinsic(self, name: str, *values: Value) -> Value:
        suffix = "f64" if self.lanes == 1 else f"v{self.lanes}f64"
        name = f"llvm.{name}.{suffix}"
        called = declared(self.builder.module, name, len(values), self.lanes)
        return self.builder.call(called, [self.number(value) for value in values])

    def add(self, left: Value, right: Value) -> Value:
        return self.builder.fadd(self.number(left), self.number(right))

    def subtract(self, left: Value, right: Value) -> Value:
        return self.builder.fsub(self.number(left), self.number(right))

    def multiply(self, left: Value, right: Value) -> Value:
        return self.builder.fmul(self.number(left), self.number(right))

    def fused(self, left: Value, right: Value, more: Value) -> Value:
        """Return left right + more, rounded once."""
        return self.intrinsic("fma", left, right, more)

    def negative(self, value: Value) -> Value:
        return self.builder.fneg(value)

    def where(self, test: Value, one: Value, other: Value) -> Value:
        return self.builder.select(test, self.number(one), self.number(other))

    def rarely(self, test: Value, make: Callable[[], Value], usual: Value) -> Value:
        """Return a value that is made in a branch of its own, or the usual one."""
        begun, some = self.builder.block, test
        if self.lanes > 1:
            bits = ir.IntType(self.lanes)
            some = self.builder.icmp_unsigned("!=", self.builder.bitcast(test, bits), bits(0))
        with self.builder.if_then(some, likely=False):
            made = make() if self.lanes == 1 else self.where(test, make(), usual)
            at = self.builder.block
        value = self.builder.phi(self.kind(_NUMBER))
        value.add_incoming(usual, begun)
        value.add_incoming(made, at)
        return value

    def compare(self, left: Value, sign: str, right: Value) -> Value:
        """Return whether this holds; nothing does of what is not a number."""
        return self.builder.fcmp_ordered(sign, left, self.number(right))

    def bits(self, value: Value) -> Value:
        return self.builder.bitcast(self.number(value), self.kind(_WORD))

    def power_of_two(self, exponent: Value) -> Value:
        """Return 2ⁿ for a whole number n of a normal result."""
        biased = self.builder.add(exponent, self.word(_BIAS))
        shifted = self.builder.shl(biased, self.word(_MANTISSA))
        return self.builder.bitcast(shifted, self.kind(_NUMBER))

    def rounded(self, value: Value, factor: float) -> tuple[Value, Value]:
        """Return the nearest whole number to a product, as a number and as a word."""
        shifted = self.fused(value, factor, _SHIFT)
        word = self.builder.sub(self.bits(shifted), self.bits(_SHIFT))
        return self.subtract(shifted, _SHIFT), word

    def series(self, coefficients: Sequence[float], x: Value) -> Value:
        """Return Σ cₖ xᵏ by halves, which do not wait for each other (G. Estrin, 1960)."""
        terms = [self.number(value) for value in coefficients]
        while len(terms) > 1:
            pairs = zip(terms[::2], terms[1::2], strict=False)
            odd = terms[-1:] if len(terms) % 2 else []
            terms = [self.fused(x, high, low) for low, high in pairs] + odd
            x = self.multiply(x, x) if len(terms) > 1 else x
        return terms[0]


def _side_by_side(kind: Value, lanes: int) -> Value:
    return kind if lanes == 1 else ir.VectorType(kind, lanes)


def declared(module: Any, name: str, arguments: int, lanes: int = 1) -> Value:
    """Return a function of numbers, or of lanes of them, that a module knows by name."""
    number = _side_by_side(_NUMBER, lanes)
    kind = ir.FunctionType(number, [number] * arguments)
    return module.globals.get(name) or ir.Function(module, kind, name)


def _exponential(code: _Code, high: Value, low: Value) -> Value:
    """Return exp(high + low)."""
    is_unusual = code.builder.fcmp_unordered(
        ">=", code.intrinsic("fabs", high), code.number(_USUAL)
    )

    def clamped() -> Value:
        value = code.where(code.compare(high, "<", _UNDERFLOW), _UNDERFLOW, high)
        return code.where(code.compare(value, ">", _OVERFLOW), _OVERFLOW, value)

    high = code.rarely(is_unusual, clamped, high)
    n, word = code.rounded(high, 1.0 / float(sum(_LN_2)))
    less = code.negative(n)
    begun = code.fused(less, _LN_2[0], high)
    rest = code.fused(less, _LN_2[1], low)
    r = code.add(begun, rest)
    tail = code.series([1.0 / factorial(k) for k in range(2, 14)], r)
    value, error = _sum(code, code.number(1.0), begun)
    rest = code.fused(code.multiply(r, r), tail, code.add(error, rest))
    value = code.add(value, rest)

    def in_two_steps() -> Value:
        half = code.builder.ashr(word, code.word(1))
        whole = code.multiply(value, code.power_of_two(half))
        return code.multiply(whole, code.power_of_two(code.builder.sub(word, half)))

    # 2ⁿ alone can be too large or too small.
    once = code.multiply(value, code.power_of_two(word))
    return code.rarely(is_unusual, in_two_steps, once)


def _logarithm(code: _Code, x: Value) -> tuple[Value, Value]:
    """Return numbers whose sum is log x, for positive finite numbers."""
    builder = code.builder
    is_small = code.compare(x, "<", _LEAST_NORMAL)
    x = code.where(is_small, code.multiply(x, 2.0**54), x)
    # k is such that z is between the roots of 1/2 and 2.
    word, root = code.bits(x), code.bits(sqrt(0.5))
    k = builder.ashr(builder.sub(word, root), code.word(_MANTISSA))
    z = builder.sub(word, builder.shl(k, code.word(_MANTISSA)))
    z = builder.bitcast(z, code.kind(_NUMBER))
    k = builder.sub(k, builder.select(is_small, code.word(54), code.word(0)))
    exponent = builder.sitofp(k, code.kind(_NUMBER))
    above, below = code.subtract(z, 1.0), code.add(z, 1.0)
    below_low = code.subtract(z, code.subtract(below, 1.0))
    inverse = builder.fdiv(code.number(1.0), below)
    s = code.multiply(above, inverse)
    less = code.negative(s)
    left = code.fused(less, below_low, code.fused(less, below, above))
    s_low = code.multiply(left, inverse)
    square = code.multiply(s, s)
    tail = code.series([2.0 / (2 * j + 1) for j in range(1, 12)], square)
    tail = code.fused(code.multiply(s, square), tail, code.multiply(2.0, s_low))
    tail = code.fused(exponent, _LN_2[1], tail)
    large, small = code.multiply(exponent, _LN_2[0]), code.multiply(2.0, s)
    high, error = _sum(code, large, small)
    return _sum(code, high, code.add(error, tail))


def _sum(code: _Code, large: Value, small: Value) -> tuple[Value, Value]:
    """Return a sum and its error; the first is zero or the larger one."""
    total = code.add(large, small)
    return total, code.subtract(small, code.subtract(total, large))


def _exp(code: _Code, x: Value) -> Value:
    return _exponential(code, x, code.number(0.0))


def _log(code: _Code, x: Value) -> Value:
    value, _ = _logarithm(code, x)
    value = code.where(code.compare(x, ">", 0.0), value, nan)
    value = code.where(code.compare(x, "==", 0.0), -inf, value)
    return code.where(code.compare(x, "==", inf), inf, value)


def _pow(code: _Code, x: Value, y: Value) -> Value:
    """Write xʸ as in C, but what is not a number stays so.

    Powers of -∞ by fractions, and infinite powers of 1 and -1, are no numbers either.
    """
    builder, size = code.builder, code.intrinsic("fabs", x)
    high, low = _logarithm(code, size)
    product = code.multiply(y, high)
    error = code.fused(y, high, code.negative(product))
    error = code.fused(y, low, error)
    is_moderate = code.compare(code.intrinsic("fabs", product), "<", 1000.0)
    value = _exponential(code, product, code.where(is_moderate, error, 0.0))
    is_rising = code.compare(y, ">", 0.0)
    value = code.where(code.compare(size, "==", 0.0), code.where(is_rising, 0.0, inf), value)
    value = code.where(code.compare(size, "==", inf), code.where(is_rising, inf, 0.0), value)
    half = code.multiply(y, 0.5)
    is_even = code.compare(code.intrinsic("floor", half), "==", half)
    is_whole = code.compare(code.intrinsic("floor", y), "==", y)
    signed = code.where(is_even, value, code.negative(value))
    is_below = code.compare(x, "<", 0.0)
    value = code.where(is_below, code.where(is_whole, signed, nan), value)
    is_number = builder.fcmp_ordered("ord", x, y)
    value = code.where(is_number, value, nan)
    return code.where(code.compare(y, "==", 0.0), 1.0, value)


def _turned(code: _Code, x: Value, quarters: int) -> Value:
    """Return sin(x + quarters π/2)."""
    builder = code.builder
    size = code.intrinsic("fabs", x)
    # The remainder is exact, and 2 π off by less than the numbers beside x are.
    is_far = code.compare(size, ">", _MOST_TURNS)
    reduced = code.rarely(is_far, lambda: builder.frem(x, code.number(2.0 * pi)), x)
    n, word = code.rounded(reduced, 2.0 / pi)
    less = code.negative(n)
    first = code.fused(less, _HALF_PI[0], reduced)
    second = code.multiply(n, _HALF_PI[1])
    r = code.subtract(first, second)
    back = code.subtract(r, first)
    error = code.subtract(code.subtract(first, code.subtract(r, back)), code.add(second, back))
    r, low = _sum(code, r, code.fused(less, _HALF_PI[2], error))
    square = code.multiply(r, r)
    square_low = code.fused(r, r, code.negative(square))
    # sin(r + low)
    tail = code.series([(-1.0) ** k / factorial(2 * k + 1) for k in range(1, 9)], square)
    change = code.multiply(low, code.fused(-0.5, square, 1.0))
    sine = code.add(r, code.fused(code.multiply(r, square), tail, change))
    # cos(r + low)
    tail = code.series([(-1.0) ** k / factorial(2 * k) for k in range(2, 10)], square)
    change = code.fused(-0.5, square_low, code.negative(code.multiply(r, low)))
    change = code.fused(code.multiply(square, square), tail, change)
    cosine, left = _sum(code, code.number(1.0), code.multiply(-0.5, square))
    cosine = code.add(cosine, code.add(left, change))
    turns = builder.add(word, code.word(quarters))
    is_odd = builder.trunc(turns, code.kind(_BIT))
    is_negative = builder.trunc(builder.lshr(turns, code.word(1)), code.kind(_BIT))
    value = code.where(is_odd, cosine, sine)
    return code.where(is_negative, code.negative(value), value)


def _sin(code: _Code, x: Value) -> Value:
    return _turned(code, x, 0)


def _cos(code: _Code, x: Value) -> Value:
    return _turned(code, x, 1)


_WRITERS = {"cos": _cos, "exp": _exp, "log": _log, "pow": _pow, "sin": _sin}
#: The functions that ``function`` adds to a module.
FUNCTIONS = tuple(_WRITERS)
PREFIX = "exact_"


def name_of(function: str, lanes: int = 1) -> str:
    """Return the name of one of ``FUNCTIONS`` in code, of numbers or of lanes of them."""
    return f"{PREFIX}{function}" if lanes == 1 else f"{PREFIX}{function}_{lanes}"


def _declared_own(module: Any, name: str, lanes: int) -> Value:
    return declared(module, name_of(name, lanes), 2 if name == "pow" else 1, lanes)


def function(module: Any, name: str, lanes: int = 1) -> Value:
    """Return one of ``FUNCTIONS``, added to a module of llvmlite if it is not there."""
    if found := module.globals.get(name_of(name, lanes)):
        return found
    made = _declared_own(module, name, lanes)
    made.linkage = "internal"
    made.attributes.add("noinline")
    code = _Code(ir.IRBuilder(made.append_basic_block()), lanes)
    code.builder.ret(_WRITERS[name](code, *made.args))
    return made


@cache
def defined(names: tuple[str, ...] = FUNCTIONS, lanes: int = 1) -> str:
    """Return some of the functions in LLVM's intermediate representation."""
    module = ir.Module("mathematics")
    for name in names:
        function(module, name, lanes).linkage = "external"
    return str(module)


@cache
def declarations(names: tuple[str, ...] = FUNCTIONS, lanes: int = 1) -> str:
    """Return the declarations for a module that calls some of these functions."""
    module = ir.Module("declarations")
    return "\n".join(str(_declared_own(module, name, lanes)) for name in names)
