"""Checks of what a scene declares and nothing uses: params, sets, tissues, tools."""

from collections.abc import Iterable, Iterator, Sequence

from tissuec.compiler.checks import check
from tissuec.compiler.compile import Compiled
from tissuec.core.errors import Diagnostic
from tissuec.core.hints import leaving_out
from tissuec.lang import syntax as s
from tissuec.lang.walk import names_in
from tissuec.scene.overrides.idle import tissues_in_use
from tissuec.scene.program.declarations import Declared


@check
def unused_parameters(compiled: Compiled) -> Iterator[Diagnostic]:
    """W501: a param or let that nothing uses; a study or ``--set`` would do nothing.

    A scene does not have to use all params of files, unless they are set.
    """
    constants = compiled.scene.constants
    used = constants.used | _replaced(compiled)
    factors = (f for study in compiled.scene.studies.values() for f in study.factors)
    needed = constants.overrides.keys() | {s.key_of(factor.name) for factor in factors}
    for key, declared in compiled.scene.declarations.of("let").items():
        is_own = declared.item.span.source is compiled.scene.source
        if is_own and isinstance(declared.item, s.Assign) and key not in used:
            yield Diagnostic(
                "W501",
                f'"{declared.name.text}" is never used',
                declared.name.span,
                leaving_out("use it or remove it", declared.item.span),
            )
    for key, declared in compiled.scene.declarations.of("param").items():
        is_own = declared.item.span.source is compiled.scene.source
        if key not in used and (is_own or key in constants.overrides):
            yield Diagnostic(
                "W501",
                f'the param "{declared.name.text}" is never used',
                declared.name.span,
                # Params that are set or varied cannot be removed.
                leaving_out(
                    "use it or remove it; to set or vary it has no effect",
                    *(() if key in needed else (declared.item.span,)),
                ),
            )


@check
def unused_sets(compiled: Compiled) -> Iterator[Diagnostic]:
    """W502: a set that no sentence names; files may declare more than a scene needs."""
    known = compiled.groups.used | _replaced(compiled)
    for key, declared in compiled.scene.declarations.of("set").items():
        is_own = declared.item.span.source is compiled.scene.source
        if key not in known and is_own and isinstance(declared.item, s.Assign):
            yield Diagnostic(
                "W502",
                f'the set "{declared.name.text}" is never used',
                declared.name.span,
                leaving_out(
                    "use it or remove it, unless a study measures it with --measure",
                    declared.item.span,
                ),
            )


def _replaced(compiled: Compiled) -> set[str]:
    """Return the lower-case names in entries that ``--set`` has replaced."""
    entries = compiled.scene.declarations.replaced
    return {
        name.key
        for entry in entries
        for name in names_in(entry)
        if name is not getattr(entry, "name", None)
    }


@check
def unused_tissues(compiled: Compiled) -> Iterator[Diagnostic]:
    """W502: a tissue of the scene's own of which nothing is made, and that no other is like."""
    scene = compiled.scene
    tissues = scene.declarations.of("tissue")
    made = {one.name for one in tissues_in_use(scene)}
    idle = {
        key: one
        for key, one in tissues.items()
        if one.name.text not in made and one.item.span.source is scene.source
    }
    if not idle:
        return
    like = tuple(one.item.clauses for one in tissues.values() if isinstance(one.item, s.Block))
    named = {name.key for name in names_in(like)} | _replaced(compiled)
    # Blocks that learn or vary entries of a tissue name it after other words.
    named |= _within(idle, _items(compiled, "learn", "study"))
    for key, declared in idle.items():
        if key not in named:
            yield _unused("tissue", declared, "make a body or a joint of it")


@check
def unused_tools(compiled: Compiled) -> Iterator[Diagnostic]:
    """W502: a tool of the scene's own that nothing names, and that has no shape to touch with.

    W407 reports shapes that touch nothing.
    """
    scene = compiled.scene
    idle = {
        key: declared
        for key, declared in scene.declarations.of("tool").items()
        if declared.item.span.source is scene.source
        and not (scene.tools[key].shapes and scene.tools[key].may_touch)
    }
    if not idle:
        return
    single = scene.declarations.single.values()
    items = (*_items(compiled, *scene.declarations.named), *single, *scene.declarations.expects)
    named = _within(idle, items) | _replaced(compiled)
    for key, declared in idle.items():
        if key not in named:
            yield _unused("tool", declared, "name it in the script")


def _items(compiled: Compiled, *kinds: str) -> list[s.Item]:
    return [one.item for kind in kinds for one in compiled.scene.declarations.of(kind).values()]


def _within(keys: Iterable[str], items: Sequence[s.Item]) -> set[str]:
    """Return which names are in names inside of items, as the object of a sentence is."""
    own = {id(getattr(item, "name", None)) for item in items}
    names = {f" {name.key} " for name in names_in(tuple(items)) if id(name) not in own}
    return {key for key in keys if any(f" {key} " in name for name in names)}


def _unused(kind: str, declared: Declared, use: str) -> Diagnostic:
    return Diagnostic(
        "W502",
        f'the {kind} "{declared.name.text}" is never used',
        declared.name.span,
        leaving_out(f"{use}, or remove it", declared.item.span),
    )
