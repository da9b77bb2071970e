"""Which body a table belongs to, and which tables a body has."""

from collections.abc import Mapping

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import Tables, WrittenLaws
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import declare

TABLES = ("nodes", "springs")
declare(
    "table", "Nodes or springs of an explicit mesh, one per row.", 53, "sentence",
    forms=("table nodes of BODY in UNIT with columns",),
)  # fmt: skip


def check_table(table: s.Table, declarations: Declarations, findings: Findings) -> None:
    """Reject a table that belongs to no body, so that a misspelt one is not ignored.

    Args:
        table: The table.
    """
    if table.name.key not in TABLES:
        findings.reject(
            "TIS303",
            f'"{table.name.text}" is not a table of a body',
            table.name.span,
            hint=alternatives(table.name.key, TABLES, what="tables"),
        )
    owner = _owner(table)
    if owner is None:
        findings.reject(
            "TIS304",
            "the body of the table is missing",
            table.name.span,
            hint=f"for example: table {table.name.text} of net …",
        )
    declarations.find("body", owner, findings)


def tables_of(
    body: s.Name, declarations: Declarations, findings: Findings
) -> dict[str, s.Table]:
    """Return the tables that name a body, by their kind; two of one kind are rejected.

    Args:
        body: Name of the body.
    """
    tables: dict[str, s.Table] = {}
    for table in declarations.tables:
        owner = _owner(table)
        if owner is None or owner.key != body.key:
            continue
        if table.name.key not in TABLES:
            findings.stop()  # check_table reports this
        if table.name.key in tables:
            findings.reject(
                "TIS503",
                f"body {body.text} has two tables of {table.name.text}",
                table.name.span,
                notes=(Note("first here", tables[table.name.key].name.span),),
            )
        tables[table.name.key] = table
    return tables


def explicit_tables(
    body: s.Name,
    head: Span,
    tables: dict[str, s.Table],
    laws: Mapping[str, WrittenLaws],
    findings: Findings,
) -> Tables:
    """Return the tables of an explicit body, or reject it at its ``head``.

    Args:
        body: Name of the body.
        head: Head of its block.
        tables: Its tables by kind.
    """
    if "nodes" not in tables:
        findings.reject(
            "TIS304",
            f"body {body.text} needs a table of nodes",
            head,
            hint=f'table nodes of {body.text} in mm with columns "id x y z" {{ 1 0 0 0 }}',
        )
    return Tables(tables["nodes"], tables.get("springs"), laws)


def _owner(table: s.Table) -> s.Name | None:
    """Return the body that a table names, None if it names none."""
    values = [clause.value for clause in table.clauses if clause.word == "of"]
    return values[0] if values and isinstance(values[0], s.Name) else None
