"""Module to Scene: the order in which names are bound; each step is a file of its own."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeVar

from tissuec.scene.bodies import check_table, read_body
from tissuec.scene.declarations import Declarations, collect
from tissuec.scene.findings import Findings
from tissuec.scene.imports import Program, whole
from tissuec.scene.model import Body, Scene, Tissue, Tool
from tissuec.scene.parameters import Constants, read_overrides
from tissuec.scene.settings import read_environment, read_simulation, read_tool
from tissuec.scene.tissues import read_tissues
from tissuec.scene.vocabulary import Vocabulary, read_vocabulary

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Words:
    """What a program says without any body: numbers, vocabulary, tissues."""

    declarations: Declarations
    constants: Constants
    vocabulary: Vocabulary
    tissues: dict[str, Tissue]


def resolve_words(program: Program, findings: Findings, overrides: Sequence[str] = ()) -> Words:
    """Return numbers, vocabulary and tissues of a program, which need not be a whole scene."""
    declarations = collect(program, findings)
    constants = Constants(
        declarations, read_overrides(overrides, declarations, findings), findings
    )
    vocabulary = read_vocabulary(declarations, constants)
    tissues = read_tissues(declarations, vocabulary, constants)
    return Words(declarations, constants, vocabulary, tissues)


def resolve(program: Program, findings: Findings, overrides: Sequence[str] = ()) -> Scene:
    """Return the scene that a program describes.

    Raises:
        CompileError: The text is wrong; holds every finding so far.
    """
    words = resolve_words(program, findings, overrides)
    declarations, scope = words.declarations, words.constants
    bodies: dict[str, Body] = {}
    tools: dict[str, Tool] = {}
    for key, declared in declarations.of("body").items():
        with findings.item():
            bodies[key] = read_body(
                declared.name, declared.item, words.tissues, declarations, scope
            )
    for key, declared in declarations.of("tool").items():
        with findings.item():
            tools[key] = read_tool(declared.name, declared.item, scope)
    if not declarations.of("body"):
        hint = "for example: body vessel { mesh is tube { … }; tissue is … }"
        findings.add("TIS304", "the scene has no body", whole(program.main), hint=hint)
    for table in declarations.tables:
        with findings.item():
            check_table(table, declarations, findings)
    environment = simulation = None
    with findings.item():
        environment = read_environment(declarations, program.main, scope)
    with findings.item():
        simulation = read_simulation(declarations, program.main, scope)
    for declared in declarations.of("learn").values():
        findings.add(
            "W701",
            f"the learn block {declared.name.text} is not carried out by this version",
            declared.name.span,
            hint="run, check and validate look at the rest of the scene",
        )
    scope.evaluate_all()
    findings.raise_errors()
    assert environment is not None and simulation is not None
    return Scene(
        source=program.main.source,
        imports=tuple(module.source for module in program.modules[:-1]),
        about=declarations.about,
        declarations=declarations,
        constants=scope,
        vocabulary=words.vocabulary,
        tissues=words.tissues,
        bodies=bodies,
        tools=tools,
        environment=environment,
        simulation=simulation,
    )
