"""What a program declares, sorted by kind, each name once."""

import re
from collections.abc import Callable, Iterator
from typing import NoReturn, TypeVar

from msgspec import Struct, field

from tissuec.core.errors import Note
from tissuec.core.hints import Edit, Hint, alternatives, did_you_mean, leaving_out, proposal
from tissuec.core.source import Span
from tissuec.core.structs import replace
from tissuec.core.units import SYMBOLS
from tissuec.lang import syntax as s
from tissuec.lang.version import first_line, last_line
from tissuec.scene.program.functions import FUNCTIONS, Functions
from tissuec.scene.program.imports import Program, whole
from tissuec.scene.program.library import SUFFIX, Library
from tissuec.scene.program.metadata import Metadata, is_metadata, with_text
from tissuec.scene.program.repetition import repeated
from tissuec.scene.program.unknown_parts import reject_unknown
from tissuec.scene.reading.findings import Findings
from tissuec.scene.reading.parts import LIKE, PARTS, REPEAT, SCENE, share_names

T = TypeVar("T")

#: What is declared by ``let`` with parameters.
FUNCTION = "function"
#: What a vocabulary is made of; the first of these says most about what it is.
VOCABULARY = ("quantity", "property", "rules", "hedge")


def part_of(kind: str) -> str:
    """Return the word of the part that declares a kind."""
    return "let" if kind == FUNCTION else kind


class Declared(Struct, frozen=True):
    """A named thing and the item that declares it."""

    name: s.Name
    item: s.Item


class Declarations(Struct):
    """Everything that a program declares, by lower-case name.

    ``named`` holds, for each kind ("param", "let", "set", "property", …, "hedge"), its names;
    ``single`` the blocks that occur once.
    """

    library: Library
    named: dict[str, dict[str, Declared]] = field(
        default_factory=dict[str, dict[str, Declared]]
    )
    single: dict[str, s.Block] = field(default_factory=dict[str, s.Block])
    tables: list[s.Table] = field(default_factory=list[s.Table])
    expects: list[s.Expect] = field(default_factory=list[s.Expect])
    metadata: Metadata = Metadata()
    #: Where each of its texts is written.
    described: dict[str, Span] = field(default_factory=dict[str, Span])
    #: Words and rules that a second file declares as well, with their kinds.
    again: list[tuple[str, s.Name]] = field(default_factory=list[tuple[str, s.Name]])

    #: Of params and lets by key: the names in their definitions that are such, too.
    needs: dict[str, tuple[s.Name, ...]] = field(default_factory=dict[str, tuple[s.Name, ...]])
    #: Where the scene itself uses a file, by the name of that file.
    uses: dict[str, Span] = field(default_factory=dict[str, Span])
    #: Of the program, if it has any.
    functions: Functions | None = None
    #: Indices of repetitions.
    indices: list[s.Name] = field(default_factory=list[s.Name])
    #: Entries that ``--set`` has replaced, as they are written.
    replaced: tuple[s.Item, ...] = ()

    def copy(self) -> "Declarations":
        """Return declarations of which some can be replaced."""
        named = {kind: dict(declared) for kind, declared in self.named.items()}
        return replace(self, named=named, single=dict(self.single))

    def required(self, kind: str, example: str, main: s.Module, findings: Findings) -> s.Block:
        """Return a block that every scene has once; a scene without it is rejected.

        Args:
            kind: Its first word.
            example: How it could be written.
            main: The text of the scene.
            findings: Of the scene.
        """
        if kind not in self.single:
            if findings.may_be_misspelt(kind):
                findings.stop()
            findings.reject(
                "TIS304",
                f"the scene has no {kind} block",
                whole(main),
                hint=Hint(f"for example: {example}", last_line(example, main.source)),
            )
        return self.single[kind]

    def of(self, kind: str) -> dict[str, Declared]:
        """Return the declarations of one kind."""
        return self.named.get(kind, {})

    def sharing(self, kind: str) -> Iterator[dict[str, Declared]]:
        """Yield the declarations whose names must differ from those of a kind."""
        word = part_of(kind)
        for other, declared in self.named.items():
            if share_names(word, part_of(other)):
                yield declared

    def read_each(
        self, kind: str, read: Callable[[Declared], T], findings: Findings
    ) -> dict[str, T]:
        """Return the results of ``read`` for each declaration; an error rejects one only.

        Args:
            kind: Kind of the declarations.
            read: Reads a declaration, or rejects it.
        """
        found: dict[str, T] = {}
        for key, declared in self.of(kind).items():
            with findings.item():
                found[key] = read(declared)
        return found

    def find(self, kind: str, name: s.Name, findings: Findings) -> Declared:
        """Return the declaration of a name, or reject the name.

        Args:
            kind: Kind of the declaration.
        """
        known = self.of(kind)
        if name.key not in known:
            findings.pass_over_doubtful(name.key)
            if kind == "tissue" and name.quoted is not None and not findings.are_many:
                self._refuse_file(name, findings)
            few = () if findings.are_many else known.values()
            names = [declared.name.text for declared in few]
            plural = {"rules": "rules", "body": "bodies"}.get(kind, f"{kind}s")
            article = "are no" if kind == "rules" else "is no"
            file = "" if findings.are_many else self.library.declaring(kind, name.key)
            findings.reject(
                "TIS301",
                f'there {article} {kind} called "{name.text}"',
                name.span,
                hint=Hint(f'write: use "{file}"', first_line(f'use "{file}"', name.span.source))
                if file
                else alternatives(name.text, names, what=plural),
            )
        return known[name.key]

    def _refuse_file(self, name: s.Name, findings: Findings) -> None:
        """Reject the name of a file with tissues where the name of a tissue belongs."""
        file = name.text.removesuffix(SUFFIX)
        if not (tissues := self.library.tissues_in(file)):
            return
        hint = Hint(f"its tissues: {', '.join(tissues)}", *map(Edit, tissues))
        if f"{file}{SUFFIX}" not in self.uses:
            source, first = name.span.source, tissues[0]
            line = first_line(f'use "{file}"', source)
            assert line.span is not None
            start, end = line.span.end, name.span.end
            between = source.text[start : name.span.start]
            edit = Edit(f"{line.text}{between}{first}", Span(source, start, end))
            others = f" (also in it: {', '.join(tissues[1:])})" if tissues[1:] else ""
            hint = Hint(f'write: use "{file}" at the top, and {first} here{others}', edit)
        message = f'"{file}" is a file and not a tissue'
        findings.reject("TIS301", message, name.span, hint=hint)


_BASED = re.compile(r"(.+?) (?:extends|inherits|inherits from|copies) (.+)")


def collect(program: Program, findings: Findings) -> Declarations:
    """Return all declarations of a program; duplicates and unknown items become findings.

    Raises:
        CompileError: There are two vocabularies, so that nothing more can be said.
    """
    declarations = Declarations(program.library)
    for item in program.main.items:
        if (
            isinstance(item, s.Sentence)
            and item.name.words.lower() == "use"
            and item.name.quoted
        ):
            declarations.uses[f"{item.name.quoted.removesuffix('.tis')}.tis"] = item.span
    for module in program.modules:
        items = module.items
        if REPEAT[1:] in module.source.text:
            items = repeated(items, findings, declarations.indices)
        for item in items:
            with findings.item():
                _enter(item, declarations, findings, is_main=module is program.main)
                continue
            _doubt(item, findings)
    if declarations.again:
        _reject_vocabulary(declarations, findings)
    _apply_functions(declarations, findings)
    return declarations


def _apply_functions(declarations: Declarations, findings: Findings) -> None:
    """Put the values of functions into everything that is declared."""
    found = {
        key: one.item
        for key, one in declarations.of(FUNCTION).items()
        if isinstance(one.item, s.Definition)
    }
    if not found:
        return
    functions = declarations.functions = Functions(found, findings)
    functions.check()
    for kind, several in declarations.named.items():
        if kind != FUNCTION:
            for key, one in several.items():
                several[key] = replace(one, item=functions.applied(one.item))
    for kind, block in declarations.single.items():
        declarations.single[kind] = functions.applied(block)
    declarations.expects[:] = [functions.applied(one) for one in declarations.expects]


def _doubt(item: s.Item, findings: Findings) -> None:
    """Make doubtful what an item that was rejected declares."""
    if isinstance(item, s.Assign | s.Definition | s.Sentence | s.Block):
        findings.doubt(item.name)
        if did_you_mean(item.name.key.split(" ")[0], ["use"]):
            findings.doubt_all()


def _enter(item: s.Item, to: Declarations, findings: Findings, *, is_main: bool) -> None:
    match item:
        case s.Table():
            to.tables.append(item)
        case s.Expect():
            to.expects.append(item)
        case s.Definition():
            _refuse_taken(item, findings)
            _declare(FUNCTION, item.name, item, to, findings)
        case s.Assign(keyword=keyword) if keyword:
            _declare(keyword, item.name, item, to, findings)
        case s.Assign() if (name := without(item.name, "hedge")) is not None:
            _declare("hedge", name, item, to, findings)
        case s.Block(phrase=None) if _is_single(item.name.key):
            _enter_single(item, to, findings)
        case s.Block(phrase=None) if (found := _named_kind(item.name)) is not None:
            _declare(*found, item, to, findings)
        case s.Sentence() if item.name.words.lower() == "use":
            pass  # followed by the loader
        case s.Sentence() if is_metadata(item):
            if is_main:
                to.metadata = with_text(to.metadata, item, to.described, findings)
        case _:
            reject_unknown(item, findings)


def _enter_single(item: s.Block, to: Declarations, findings: Findings) -> None:
    kind = item.name.key
    if item.clauses:
        findings.reject(
            "TIS303",
            f'"{item.clauses[0].word}" is not allowed after {kind}',
            item.clauses[0].span,
        )
    if kind in to.single:
        first = to.single[kind].head
        findings.reject(
            "TIS503", f"{kind} is given twice", item.head,
            hint=f"move its contents to the end of the first {kind}",
            notes=(Note("first here", first),),
        )  # fmt: skip
    to.single[kind] = item


# Parts are looked up by the words of the text, so that those of others are not imported.


def _is_single(key: str) -> bool:
    part = None if " " in key else PARTS.get(key)
    return part is not None and part.sort == "single"


def _named_kind(name: s.Name) -> tuple[str, s.Name] | None:
    kind = name.words.partition(" ")[0].lower()
    rest = without(name, kind)
    if rest is None or (part := PARTS.get(kind)) is None or part.sort != "named":
        return None
    return kind, rest


def without(name: s.Name, word: str) -> s.Name | None:
    """Return the name after a leading word, None if it does not begin so.

    ``without(tissue "head of pancreas", "tissue")`` is the quoted name alone.
    """
    first, _, rest = name.words.partition(" ")
    if first.lower() != word or not (rest or name.quoted is not None or name.listed):
        return None
    start = name.span.text.find(rest or '"', len(first)) if rest else name.span.text.find('"')
    span = replace(name.span, start=name.span.start + max(start, 0))
    return s.Name(rest, name.quoted, span, name.listed)


def _declare(
    kind: str, name: s.Name, item: s.Item, to: Declarations, findings: Findings
) -> None:
    clauses = getattr(item, "clauses", ())
    word = part_of(kind)
    takes = PARTS[word].clauses
    if PARTS[word].sort == "named" and clauses and "from" not in takes:
        clause = clauses[0]
        if clause.word not in takes or len(clauses) > 1:
            if LIKE in takes and clause.word == "from":
                hint = Hint(
                    f"write {kind} {name.text} like {clause.value.span.text}",
                    Edit(
                        "like",
                        Span(
                            clause.span.source,
                            clause.span.start,
                            clause.span.start + len(clause.word),
                        ),
                    ),
                )
                message = f'a {kind} is based on another with "like"'
                findings.reject("TIS312", message, clause.span, hint=hint)
            if LIKE in takes and clause.word == "of" and name.key.endswith(" copy"):
                new = name.text[: -len(" copy")]
                written = f"{new} like {clause.value.span.text}"
                hint = Hint(f"write {kind} {written}", Edit(written, name.span.to(clause.span)))
                message = f'a {kind} is based on another with "like"'
                findings.reject("TIS312", message, clause.span, hint=hint)
            quoted = f"{name.text} {clause.span.text.partition('{')[0].strip()}"
            findings.reject(
                "TIS115",
                f'a name cannot contain the reserved word "{clause.word}"',
                clause.span,
                hint=Hint(
                    f'write {kind} "{quoted}"', Edit(f'"{quoted}"', name.span.to(clause.span))
                ),
            )
    if LIKE in takes and (based := _BASED.fullmatch(name.words)):
        hint = Hint(
            f"write {kind} {based[1]} like {based[2]}", Edit(f"{based[1]} like {based[2]}")
        )
        findings.doubt(s.Name(based[1], None, name.span))
        findings.reject(
            "TIS312", f'a {kind} is based on another with "like"', name.span, hint=hint
        )
    if name.words in SYMBOLS and name.quoted is None and PARTS[word].names == SCENE:
        hint = 'choose a word, also where it is used, such as "load" or "length of A"'
        findings.reject(
            "TIS507", f'"{name.text}" is a unit and cannot be a name', name.span, hint=hint
        )
    for others in to.sharing(kind):
        if name.key in others:
            first = others[name.key].name.span
            if kind in VOCABULARY and first.source is not name.span.source:
                to.again.append((kind, name))
                findings.stop()
            _refuse_second(name, first, to, findings)
    to.named.setdefault(kind, {})[name.key] = Declared(name, item)


def _refuse_taken(item: s.Definition, findings: Findings) -> None:
    """Reject a function with the name of one that the language has, or of a measure."""
    from tissuec.script.measures import MEASURES  # where a scene has functions
    from tissuec.script.measures.statistics import STATISTICS

    for names, what in (
        (FUNCTIONS, "function"), (MEASURES, "measure"), (STATISTICS, "statistic"),
    ):  # fmt: skip
        if item.name.key in names:
            findings.reject(
                "TIS503",
                f'"{item.name.text}" is a {what} of the language',
                item.name.span,
                hint="choose another name, also where it is called",
            )


def _refuse_second(name: s.Name, first: Span, to: Declarations, findings: Findings) -> NoReturn:
    """Reject a name that is defined twice, at the second ``use`` if files define it."""
    here, there = (place.source.name for place in (name.span, first))
    used = to.uses.get(here)
    if used is None or here == there:
        notes, hint = (Note("first here", first),), ""
        if index := name.span.repetition.partition(" = ")[0]:
            hint = proposal(f"{name.span.text.removesuffix(f'_{index}')} {index}")
        message = f'"{name.text}" is defined twice'
        findings.reject("TIS503", message, name.span, hint=hint, notes=notes)
    hint = leaving_out("use one of the two", used, *filter(None, [to.uses.get(there)]))
    if {here.split("/")[0], there.split("/")[0]} == {"matter", "tissues"}:
        text = "use one of the two: tissues/ describes single springs, matter/ the material"
        hint = Hint(f"{text} of bodies of any shape", *hint.edits[:1])
    message = f'"{name.text}" is defined both in {there} and in {here}'
    findings.reject("TIS503", message, used, hint=hint)


def _reject_vocabulary(declarations: Declarations, findings: Findings) -> None:
    """Report one word that two files declare; the others would only repeat it."""
    kind, name = min(declarations.again, key=lambda again: VOCABULARY.index(again[0]))
    found = (declared.get(name.key) for declared in declarations.sharing(kind))
    first = next(one for one in found if one is not None)
    findings.add(
        "TIS503",
        f'"{name.text}" is defined twice',
        name.span,
        hint='a scene has one vocabulary; the tissues of the library use "fuzzy/soft_tissue"',
        notes=(Note("first here", first.name.span),),
    )
    findings.raise_errors()
