"""One program compiled repeatedly with other values: unchanged parts are kept."""

from collections.abc import Sequence
from operator import is_

from msgspec import Struct

from tissuec.compiler.compile import Bodies, Compiled, build_bodies, compile_scene
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.scene.model import Scene
from tissuec.scene.program.declarations import Declarations, collect
from tissuec.scene.program.imports import Program
from tissuec.scene.reading.findings import Findings
from tissuec.scene.resolve import resolve

#: Kinds of declarations that no body is made of; of numbers, the values count.
_ELSEWHERE = ("param", "let", "set", "joint", "tool", "force", "learn", "study")


class Recompiler:
    """Compiles a program with other values each time.

    Declarations are collected once. Bodies are drawn and built again if a text that they are
    made of was replaced, or a number named in it has another value; otherwise those of the last
    time are taken, and their warnings are not repeated.

    Args:
        program: Without mistakes in what it declares.
    """

    def __init__(self, program: Program):
        self._program = program
        self._declarations: Declarations | None = None
        self._kept: _KeptBodies | None = None

    def compile(self, overrides: Sequence[str], findings: Findings) -> Compiled:
        """Return the scene with other values.

        Args:
            overrides: Texts of ``--set``.

        Raises:
            CompileError: As of ``compile_scene``.
        """
        if self._declarations is None:
            self._declarations = collect(self._program, findings)
        declarations = self._declarations.copy()
        scene = resolve(self._program, findings, overrides, declarations)
        return compile_scene(scene, findings, self._bodies(scene, findings))

    def _bodies(self, scene: Scene, findings: Findings) -> Bodies:
        """Return the bodies of a scene: those of the last one if they are the same."""
        kept, items = self._kept, _made_of(scene.declarations)
        is_same = kept is not None and len(items) == len(kept.items)
        if kept is not None and is_same and all(map(is_, items, kept.items)):
            if kept.numbers == _numbers(scene, kept.names):
                return kept.bodies
            names = kept.names
        else:
            known = scene.constants.declared
            found = dict.fromkeys(name.key for name in names_in(items))
            names = tuple(key for key in found if key in known)
        bodies, errors = build_bodies(scene, findings), len(findings.errors)
        # Errors are reported each time.
        whole = not errors and len(bodies.built) == len(scene.declarations.of("body"))
        self._kept = None
        if whole:
            self._kept = _KeptBodies(items, names, _numbers(scene, names), bodies)
        return bodies


class _KeptBodies(Struct, frozen=True, eq=False):
    """Bodies and their materials.

    Attributes:
        items: Declarations and tables.
        names: Keys of the numbers named there.
        numbers: Their values.
    """

    items: tuple[s.Item, ...]
    names: tuple[str, ...]
    numbers: tuple[object, ...]
    bodies: Bodies


def _made_of(declarations: Declarations) -> tuple[s.Item, ...]:
    """Return all that bodies can be made of."""
    declared = (
        one.item
        for kind, named in declarations.named.items()
        if kind not in _ELSEWHERE
        for one in named.values()
    )
    return (*declared, *declarations.tables)


def _numbers(scene: Scene, names: Sequence[str]) -> tuple[object, ...]:
    """Return everything that distinguishes one value of each number from another."""
    values = (scene.constants.definitions.values[name] for name in names)
    return tuple(
        value and (value.dimension, value.is_vector, value.is_literal, value.amount.tobytes())
        for value in values
    )
