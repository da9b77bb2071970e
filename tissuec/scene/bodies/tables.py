"""Tables of nodes and springs: their heads, and which body each belongs to."""

from collections.abc import Mapping

from tissuec.core.errors import Note
from tissuec.core.hints import alternatives
from tissuec.core.source import Span
from tissuec.lang import syntax as s
from tissuec.scene.model import Tables, WrittenLaws
from tissuec.scene.program.declarations import Declarations
from tissuec.scene.reading.block_sentences import SentenceReader
from tissuec.scene.reading.expressions import Scope
from tissuec.scene.reading.findings import Findings
from tissuec.scene.sentences import KINDS, TABLE_KIND, TableWords, WrittenTable

#: Tables by the key of their body and their kind; None is one that was rejected.
TablesOfBodies = Mapping[str, Mapping[str, WrittenTable | None]]


def read_tables(declarations: Declarations, scope: Scope) -> TablesOfBodies:
    """Return all tables of a program; each error rejects one only."""
    findings, found = scope.findings, dict[str, dict[str, WrittenTable | None]]()
    for table in declarations.tables:
        owners = [c.value for c in table.clauses if c.word == "of"]
        key = owners[0].key if owners and isinstance(owners[0], s.Name) else ""
        kinds = found.setdefault(key, {})
        first = kinds.get(table.name.key)
        kinds[table.name.key] = None
        with findings.item():
            read = _read(table, declarations, scope)
            if first is not None:
                findings.reject(
                    "TIS503",
                    f"body {read.said.body.text} has two tables of {table.name.text}",
                    table.name.span,
                    notes=(Note("first here", first.rows.name.span),),
                )
            kinds[table.name.key] = read
    return found


def _read(table: s.Table, declarations: Declarations, scope: Scope) -> WrittenTable:
    """Return a table of a body that is there, so that a misspelt one is not ignored."""
    if table.name.key not in KINDS:
        scope.findings.reject(
            "TIS303",
            f'"{table.name.text}" is not a table of a body',
            table.name.span,
            hint=alternatives(table.name.key, KINDS, what="tables"),
        )
    reader = SentenceReader("table", TABLE_KIND, table, scope)
    said: TableWords = reader.get()
    declarations.find("body", said.body, scope.findings)
    if said.columns.words.lower() != "columns" or said.columns.quoted is None:
        part = reader.form.parts["columns"]
        reader.missing(part, word="with")
    return WrittenTable(said, table, reader.clauses["with"].span)


def explicit_tables(
    body: s.Name,
    head: Span,
    tables: Mapping[str, WrittenTable | None],
    laws: Mapping[str, WrittenLaws],
    findings: Findings,
) -> Tables:
    """Return the tables of an explicit body, or reject it at its ``head``.

    Args:
        head: Head of its block.
        tables: Its tables by kind.
    """
    nodes = tables.get("nodes")
    if nodes is None:
        findings.reject(
            "TIS304",
            f"body {body.text} needs a table of nodes",
            head,
            hint=f'table nodes of {body.text} in mm with columns "id x y z" {{ 1 0 0 0 }}',
        )
    return Tables(nodes, tables.get("springs"), laws)
