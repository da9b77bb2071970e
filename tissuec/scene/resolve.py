"""Module to Scene: the order in which names are bound; each step is a file of its own."""

import math
from collections import defaultdict
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from tissuec.core.source import Source
from tissuec.scene.bodies.likeness import read_each_like
from tissuec.scene.bodies.tables import read_tables
from tissuec.scene.environment import Environment, read_environment
from tissuec.scene.members import read_force
from tissuec.scene.model import Glue, Joint, Scene
from tissuec.scene.overrides.entries import read_overrides
from tissuec.scene.program.declarations import Declarations, collect, part_of
from tissuec.scene.program.imports import Program, whole
from tissuec.scene.program.parameters import Constants
from tissuec.scene.program.resolved import ResolvedProgram
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import LIKE, PARTS
from tissuec.scene.settings import read_simulation
from tissuec.scene.tissues.block import read_tissues
from tissuec.scene.tissues.laws import read_laws
from tissuec.scene.words.vocabulary import read_vocabulary
from tissuec.script.plan import AUTOMATIC, Simulation

if TYPE_CHECKING:
    from tissuec.scene.learning.model import VocabularyFit, WrittenFitProblem
    from tissuec.scene.study.model import Study


def resolve_words(
    program: Program,
    findings: Findings,
    overrides: Sequence[str] = (),
    declarations: Declarations | None = None,
) -> ResolvedProgram:
    """Resolve the parts of a program that need no bodies; it need not be a complete scene.

    Args:
        overrides: The arguments of ``--set``.
        declarations: Of the program, if they are collected already; blocks are replaced.
    """
    declarations = declarations or collect(program, findings)
    constants = Constants(
        declarations, read_overrides(overrides, declarations, findings), findings
    )
    vocabulary = read_vocabulary(declarations, constants)
    laws = read_laws(declarations, constants)
    tables = read_tables(declarations, constants)
    tissues = read_tissues(declarations, vocabulary, constants)
    forces = declarations.read_each(
        "force", lambda d: read_force(d.name, d.item, declarations, constants), findings
    )
    return ResolvedProgram(declarations, constants, vocabulary, laws, tables, tissues, forces)


def resolve(
    program: Program,
    findings: Findings,
    overrides: Sequence[str] = (),
    declarations: Declarations | None = None,
) -> Scene:
    """Return the scene that a program describes, as far as it has no errors.

    Erroneous parts are left out or replaced, so that errors of the script are reported too.

    Args:
        overrides: The arguments of ``--set``.
        declarations: Of the program, if they are collected already; blocks are replaced.
    """
    words = resolve_words(program, findings, overrides, declarations)
    declarations, scope = words.declarations, words.constants
    blocks = _read_blocks(words)
    _check_parts(program, declarations, findings)
    environment, simulation = _settings(program, declarations, scope, findings)
    scope.evaluate_all()
    sources = tuple(module.source for module in program.modules)
    fit_problems, vocabulary_fits = _learn_blocks(words, sources)
    if not declarations.of("body"):
        findings.doubt_all()  # sets and the script name what no body is there for
    return Scene(
        source=program.main.source,
        imports=sources[:-1],
        metadata=declarations.metadata,
        declarations=declarations,
        constants=scope,
        vocabulary=words.vocabulary,
        tissues=words.tissues,
        bodies=blocks["body"],
        joints={key: one for key, one in blocks["joint"].items() if isinstance(one, Joint)},
        glues={key: one for key, one in blocks["joint"].items() if isinstance(one, Glue)},
        tools=blocks["tool"],
        forces=words.forces,
        environment=environment,
        simulation=simulation,
        fit_problems=fit_problems,
        vocabulary_fits=vocabulary_fits,
        studies=_studies(declarations, scope),
        overrides=tuple(overrides),
        blocks=blocks,
    )


# Most scenes neither learn nor vary, and need none of what reads such blocks.


def _learn_blocks(
    words: ResolvedProgram, sources: Sequence[Source]
) -> "tuple[dict[str, WrittenFitProblem], dict[str, VocabularyFit]]":
    if not words.declarations.of("learn"):
        return {}, {}
    from tissuec.scene.learning.block import read_learn_blocks
    from tissuec.scene.learning.model import VocabularyFit

    problems: dict[str, WrittenFitProblem] = {}
    fits: dict[str, VocabularyFit] = {}
    for key, one in read_learn_blocks(words, sources).items():
        if isinstance(one, VocabularyFit):
            fits[key] = one
        else:
            problems[key] = one
    return problems, fits


def _studies(declarations: Declarations, scope: Constants) -> "dict[str, Study]":
    if not declarations.of("study"):
        return {}
    from tissuec.scene.study.block import read_studies

    return read_studies(declarations, scope)


def _read_blocks(words: ResolvedProgram) -> dict[str, dict[str, Any]]:
    """Return the contents of blocks whose declarations have a reader, by kind and name."""
    declarations, findings = words.declarations, words.constants.findings
    found = defaultdict[str, dict[str, Any]](dict)  # blocks of other kinds are not declared
    declared = {kind: PARTS[part_of(kind)] for kind in declarations.named}
    for kind, part in sorted(declared.items(), key=lambda one: one[1].place):
        if part.read is not None:
            read = partial(part.read, words)
            if LIKE in part.clauses:
                found[kind] = read_each_like(kind, read, declarations, findings)
            else:
                found[kind] = declarations.read_each(kind, read, findings)
    return found


def _settings(
    program: Program, declarations: Declarations, scope: Constants, findings: Findings
) -> tuple[Environment, Simulation]:
    """Return the environment and how it is simulated, or replacements for wrong ones.

    In a run without end, nothing of the script comes too late.
    """
    environment = Environment.empty(program.main)
    simulation = Simulation(math.inf, AUTOMATIC, None, None, whole(program.main))
    with findings.item():
        environment = read_environment(declarations, program.main, scope)
    with findings.item():
        simulation = read_simulation(declarations, program.main, scope)
    return environment, simulation


def _check_parts(program: Program, declarations: Declarations, findings: Findings) -> None:
    """Report a scene without a body."""
    if not declarations.of("body") and not findings.may_be_misspelt("body"):
        hint = "for example: body vessel { mesh is tube { … }; tissue is … }"
        findings.add("TIS304", "the scene has no body", whole(program.main), hint=hint)
