"""Functions of a scene: ``let f(x) = 2 * x + 1 mm``, put in place of their calls.

A function is one of numbers or vectors. Its value is made of its parameters, of params and lets
of the scene, and of other functions; names where it is called mean nothing in it. Each call
becomes an ``Applied`` node that contains the value, so that whatever reads an expression knows
what it depends on. Dimensions are checked at each call, with the arguments that it has.
"""

from collections.abc import Iterator, Mapping
from typing import Any, NoReturn, TypeVar, cast

from msgspec import Struct

from tissuec.core.errors import Note, counted
from tissuec.core.hints import did_you_mean
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.scene.reading.findings import Findings, Rejected

LARGEST = 10_000  # nodes of a value with those of the functions that it calls
DEEPEST = 50  # functions that call one another

#: Functions that the language has; also in ``scene.reading.expressions``.
FUNCTIONS = ("sqrt", "abs", "min", "max", "sin", "cos", "exp", "log")
T = TypeVar("T")


class FunctionValue(Struct, frozen=True):
    """The value of a function, with calls and parameters replaced.

    Attributes:
        size: How many nodes it has, with those of the functions that it calls.
        depth: How many functions call one another in it, with itself.
    """

    value: s.Expression
    size: int
    depth: int


class Functions:
    """The functions of a scene.

    Args:
        definitions: By key.
        findings: Takes diagnostics.
    """

    def __init__(self, definitions: Mapping[str, s.Definition], findings: Findings):
        self._definitions, self._findings = definitions, findings
        self._values: dict[str, FunctionValue | None] = {}  # None where one is wrong
        self._path: list[str] = []

    def applied(self, node: T) -> T:
        """Return a node, or a tuple of nodes, in which calls contain values of functions.

        Args:
            node: A part of the tree of a text; the same if it calls no function.
        """
        return cast(T, self._replaced(node, ())) if self._definitions else node

    def check(self) -> None:
        """Report the errors of functions, including those that are never called."""
        for key in self._definitions:
            with self._findings.item():
                self._value(key)

    @property
    def known(self) -> list[str]:
        """Return the names of all functions, as they are written."""
        return [one.name.text for one in self._definitions.values()]

    def names(self) -> Iterator[s.Name]:
        """Yield the names in values that are no parameters."""
        for found in self._values.values():
            if found is not None:
                yield from names_in(found.value)

    def _replaced(self, node: Any, parameters: tuple[str, ...]) -> Any:
        """Return a part of a tree with values in calls, and parameters by number.

        Args:
            node: A node, a tuple, or any other value.
            parameters: Keys of the names of parameters.
        """
        match node:
            case tuple():
                parts = [self._replaced(part, parameters) for part in cast(Any, node)]
                same = all(new is old for new, old in zip(parts, cast(Any, node), strict=True))
                return cast(Any, node) if same else tuple(parts)
            case s.Name() if node.key in parameters:
                return s.FormalParameter(parameters.index(node.key), node.span)
            case s.Call() if node.function.key in self._definitions:
                return self._call(node, parameters)
            case s.Call():
                arguments = self._replaced(node.arguments, parameters)
                return (
                    node if arguments is node.arguments else replace(node, arguments=arguments)
                )
            case s.Definition() | s.Table() | s.Name():
                return node
            case s.Node():
                changed: dict[str, Any] = {}
                for name in node.__struct_fields__:
                    old = getattr(node, name)
                    if isinstance(old, tuple | s.Node):
                        new = self._replaced(old, parameters)
                        if new is not old:
                            changed[name] = new
                return replace(node, **changed) if changed else node
            case _:
                return node

    def _call(self, call: s.Call, parameters: tuple[str, ...]) -> s.Applied:
        """Return a call with the value of its function; without one if anything is wrong."""
        key = call.function.key
        definition = self._definitions[key]
        given = tuple(self._replaced(one.value, parameters) for one in call.arguments)
        value: s.Expression | None = None
        try:
            self._check_arguments(call, definition)
            value = self._value(key, call.function).value
        except Rejected:
            self._findings.failures += 1
        return s.Applied(call.function, given, value, definition.span, call.span)

    def _check_arguments(self, call: s.Call, definition: s.Definition) -> None:
        wanted, given = len(definition.parameters), len(call.arguments)
        note = (Note("defined here", _head(definition)),)
        name = call.function.text
        for argument in call.arguments:
            if argument.clauses:
                message = f"{name} takes plain numbers"
                self._findings.reject("TIS312", message, argument.span, notes=note)
        if wanted != given:
            numbers = counted(wanted, "number")
            form = ", ".join(one.text for one in definition.parameters)
            self._findings.reject(
                "TIS312",
                f"{name} takes {numbers}, not {given}",
                call.span,
                hint=f"its form is {name}({form})",
                notes=note,
            )

    def _value(self, key: str, name: s.Name | None = None) -> FunctionValue:
        """Return the value of a function.

        Args:
            key: Of the function.
            name: Where it is called; None where it is checked.
        """
        definition = self._definitions[key]
        if key in self._path:
            circle = " -> ".join((*self._path[self._path.index(key) :], key))
            self._findings.reject(
                "TIS506",
                f"circular definition of functions: {circle}",
                definition.name.span if name is None else name.span,
                hint="a function cannot call itself, nor one that calls it",
                notes=(Note("defined here", _head(definition)),),
            )
        if key not in self._values:
            if len(self._path) >= DEEPEST:
                self._refuse_deep(definition)
            self._values[key] = None
            self._path.append(key)
            try:
                self._values[key] = self._worked_out(definition)
            finally:
                self._path.pop()
        found = self._values[key]
        if found is None:
            self._findings.stop()
        return found

    def _refuse_deep(self, definition: s.Definition) -> NoReturn:
        self._findings.reject(
            "TIS116",
            f"more than {DEEPEST} functions call one another in a row",
            definition.name.span,
            hint="write the values of some functions into those that call them",
        )

    def _worked_out(self, definition: s.Definition) -> FunctionValue:
        keys = tuple(one.key for one in definition.parameters)
        for number, one in enumerate(definition.parameters):
            if one.key in keys[:number]:
                first = definition.parameters[keys.index(one.key)].span
                self._findings.reject(
                    "TIS307",
                    f'the parameter "{one.text}" is given twice',
                    one.span,
                    hint="call one of them by another name, also in the value",
                    notes=(Note("first here", first),),
                )
        value, failures = definition.value, self._findings.failures
        value = self._replaced(value, keys)
        if self._findings.failures > failures:
            self._findings.stop()
        size, depth = self._size(value, definition)
        if depth > DEEPEST:
            self._refuse_deep(definition)
        if size > LARGEST:
            self._findings.reject(
                "TIS116",
                f"the value of {definition.name.text} is too long, with the functions that it "
                "calls",
                definition.name.span,
                hint="write shorter functions",
            )
        return FunctionValue(value, size, depth)

    def _size(self, value: s.Expression, definition: s.Definition) -> tuple[int, int]:
        """Return the size and depth of a value; rejects calls of anything but functions."""
        waiting: list[Any] = [value]
        size, depth = 0, 1
        while waiting:
            match waiting.pop():
                case [*parts]:
                    waiting.extend(parts)
                case s.Applied() as applied:
                    known = self._values[applied.name.key]
                    assert known is not None  # or this function would be wrong, too
                    size, depth = size + known.size, max(depth, known.depth + 1)
                    waiting.append(applied.arguments)
                case s.Call() as call:
                    size += 1
                    waiting.append(call.arguments)
                    if call.function.key not in FUNCTIONS:
                        self._no_function(call, definition)
                case s.Node() as node:
                    size += 1
                    waiting += [getattr(node, name) for name in node.__struct_fields__]
                case _:
                    pass
        return size, depth

    def _no_function(self, call: s.Call, definition: s.Definition) -> None:
        name = call.function.text
        self._findings.pass_over_doubtful(call.function.key)
        self._findings.reject(
            "TIS301",
            f'there is no function called "{name}"',
            call.function.span,
            hint=did_you_mean(name, (*self.known, *FUNCTIONS))
            or "functions take numbers; to use a measure, pass it as an argument, as in "
            f"{definition.name.text}({call.span.one_line})",
        )


def _head(definition: s.Definition) -> Span:
    """Return the place of a function without its value."""
    last = definition.parameters[-1].span.end + 1
    return Span(definition.span.source, definition.span.start, last)
