"""Docstrings of public functions: shapes and units of arrays, arguments, errors.

The sources are parsed, not imported. A function is public if its name, the class it belongs to
and that class's name have no leading underscore; nested functions, overloads and setters do not
count, and a property counts only if it returns an array. Such a function needs

- a docstring;
- in the modules that other programs call, with three or more parameters, an ``Args:`` section
  that names each of them, unless its type is a class of the package, which says what it is;
- with arrays among its parameters or results, their shapes, and units if they are not integers
  or Booleans;
- a ``Raises:`` section that names each class of exceptions that its own body raises.

A method needs only the last of these if it overrides a method of a base class, or implements
that of a protocol, with the same name and parameters. Parameters that many functions of a class
or module share may be documented once, in a section ``Shared arguments:`` of the docstring of
the class, the module or its package. Commands of click have their options as documentation.

No entry of ``Args:`` may only repeat the name and the type of its parameter.
"""

import ast
import re
from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from pathlib import Path

from tests.every import every
from tests.modules import ROOT, nodes, trees

#: Modules that only describe another library to the type checker; its manual documents it.
OF_OTHERS = ("view/plots/drawing.py",)
#: Modules that do not follow the rules yet.
NOT_YET: tuple[str, ...] = ()

#: What other programs call.
DOORS = ("api/", "pipeline.py", "example.py")
MANY = 3
#: Words that add nothing to a name.
FILLERS = {"the", "a", "an", "of", "its", "their", "each", "as", "by", "in", "for", "given"}
SHAPE = re.compile(r"\bshapes?\b|\bscalars?\b")
UNIT = re.compile(
    r"\[\(?(1|%|m|mm|s|N|kg|J|W|Pa|rad|deg|Hz|px|pt|pixels|bytes)(?![a-z])[^\[\]]*\]"
    r"|\b(dimensionless|units?)\b"
)
BUILTIN = {"NDArray": True, "ndarray": True, "ArrayLike": True}
PLAIN_DTYPES = re.compile(r"\b(bool|u?int|intp|integer|signedinteger)(\d+|_)?\b")
SECTION = re.compile(r"^( *)([A-Z][A-Za-z ]+):\n((?:\1 +.*\n|\s*\n)*)", re.MULTILINE)
Function = ast.FunctionDef | ast.AsyncFunctionDef


@dataclass
class Class:
    """A class of the package."""

    node: ast.ClassDef
    bases: set[str]
    methods: dict[str, Function] = field(default_factory=dict)

    @property
    def is_protocol(self) -> bool:
        return "Protocol" in self.bases


@dataclass
class Module:
    """A parsed module."""

    path: str  # below the package
    shared: str  # shared arguments of its package
    tree: ast.Module
    nodes: list[ast.AST]

    @property
    def name(self) -> str:
        return f"{ROOT.name}/{self.path}"

    @cached_property
    def classes(self) -> list[Class]:
        return [_class(node) for node in self.nodes if isinstance(node, ast.ClassDef)]


def _class(node: ast.ClassDef) -> Class:
    bases = {_last_name(base) for base in node.bases}
    methods = {each.name: each for each in node.body if isinstance(each, Function)}
    return Class(node, bases, methods)


def _last_name(node: ast.expr) -> str:
    """Return ``C`` for ``C``, ``a.C``, ``C(…)`` and ``C[…]``."""
    match node:
        case ast.Subscript(value=inner) | ast.Call(func=inner):
            return _last_name(inner)
        case ast.Attribute(attr=name) | ast.Name(id=name):
            return name
    return ""


def _section(doc: str, title: str) -> str:
    return "".join(m[3] for m in SECTION.finditer(doc + "\n") if m[2] == title)


@cache
def modules() -> list[Module]:
    def shared(path: str) -> str:
        folders = [(folder / "__init__.py").as_posix() for folder in Path(path).parents]
        docs = [ast.get_docstring(trees()[each]) or "" for each in folders if each in trees()]
        return "\n".join(_section(doc, "Shared arguments") for doc in docs)

    ours = (path for path in trees() if path not in OF_OTHERS)
    return [Module(path, shared(path), trees()[path], nodes(path)) for path in ours]


@cache
def classes() -> dict[str, list[Class]]:
    """Return the classes of all modules by name."""
    found: dict[str, list[Class]] = defaultdict(list)
    for each in (each for module in modules() for each in module.classes):
        found[each.node.name].append(each)
    return found


@cache
def aliases() -> dict[str, dict[str, bool]]:
    """Return the names of array types in each module, and whether entries may have a unit."""
    known = {module.name: dict(BUILTIN) for module in modules()}
    for _ in range(2):  # an alias of an alias that is imported needs a second pass
        for module in modules():
            here = known[module.name]
            for node in module.nodes:
                match node:
                    case ast.Assign(
                        targets=[ast.Name(id=name)], value=ast.Subscript() as value
                    ):
                        outer, first = _last_name(value), value.slice
                        if outer == "Annotated" and isinstance(first, ast.Tuple):
                            outer, first = _last_name(first.elts[0]), first.elts[0]
                        if outer in here:
                            plain = PLAIN_DTYPES.search(ast.unparse(first))
                            here[name] = here[outer] and not plain
                    case ast.ImportFrom(module=str(source), names=names):
                        path = source.replace(".", "/")
                        for other in (f"{path}.py", f"{path}/__init__.py"):
                            found = known.get(other, {})
                            here |= {
                                one.name: found[one.name] for one in names if one.name in found
                            }
    return known


def _arrays(annotation: ast.expr | None, aliases: Mapping[str, bool]) -> tuple[bool, bool]:
    """Return whether an annotation has arrays, and arrays whose entries may have a unit."""
    match annotation:
        case None:
            return False, False
        case ast.Constant(value=str(text)):
            try:
                return _arrays(ast.parse(text, mode="eval").body, aliases)
            except SyntaxError:
                return False, False
        case ast.Subscript(value=outer, slice=inner):
            name = _last_name(outer)
            if name in ("Callable", "Literal"):
                return False, False
            if name == "NDArray":
                return True, not PLAIN_DTYPES.search(ast.unparse(inner))
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name in aliases, aliases.get(name, False)
    parts = [_arrays(each, aliases) for each in ast.iter_child_nodes(annotation)]
    return any(p[0] for p in parts), any(p[1] for p in parts)


def _decorators(node: Function) -> set[str]:
    return {_last_name(each) for each in node.decorator_list}


def _parameters(node: Function, *, method: bool) -> list[ast.arg]:
    given = node.args
    each = [*given.posonlyargs, *given.args, *given.kwonlyargs]
    each += [one for one in (given.vararg, given.kwarg) if one]
    if method and "staticmethod" not in _decorators(node):
        each = each[1:]
    return [one for one in each if not one.arg.startswith("_")]


def _raised(node: ast.AST) -> Iterator[str]:
    """Yield classes of exceptions that a function raises itself."""
    for child in ast.iter_child_nodes(node):
        if isinstance(child, Function | ast.ClassDef | ast.Lambda):
            continue
        if isinstance(child, ast.Raise) and child.exc is not None:
            name = _last_name(child.exc)
            if name[:1].isupper():
                yield name
        yield from _raised(child)


def _is_documented_elsewhere(node: Function, owner: Class) -> bool:
    names = [one.arg for one in _parameters(node, method=True)]
    every = (each for many in classes().values() for each in many)
    protocols = [] if owner.is_protocol else [each for each in every if each.is_protocol]
    seen: set[str] = set()
    bases, queue = [], list(owner.bases)
    while queue:
        name = queue.pop()
        if name not in seen:
            seen.add(name)
            for each in classes().get(name, ()):
                bases.append(each)
                queue += each.bases
    for each in (*bases, *protocols):
        other = each.methods.get(node.name)
        if other is None or each is owner or other is node:
            continue
        same = [one.arg for one in _parameters(other, method=True)] == names
        if same and ast.get_docstring(other):
            return True
    return False


def _missing(node: Function, module: Module, owner: Class | None) -> Iterator[str]:
    """Yield what the docstring of a public function lacks."""
    doc, decorators = ast.get_docstring(node) or "", _decorators(node)
    if decorators & {"overload", "setter", "command", "group"}:
        return
    stated = _section(doc, "Raises")
    for name in sorted(set(_raised(node))):
        if name not in ("NotImplementedError", "AssertionError") and name not in stated:
            yield f"Raises: {name}"
    if owner and _is_documented_elsewhere(node, owner):
        return
    parameters = _parameters(node, method=owner is not None)
    annotations = [each.annotation for each in parameters] + [node.returns]
    known = aliases().get(module.name, BUILTIN)
    arrays = [_arrays(each, known) for each in annotations]
    has_arrays, has_units = map(any, zip(*arrays, strict=True))
    if decorators & {"property", "cached_property"} and not has_arrays:
        return
    if not doc:
        yield "docstring"
        return
    shared = _section(ast.get_docstring(module.tree) or "", "Shared arguments") + module.shared
    if owner:
        shared += _section(ast.get_docstring(owner.node) or "", "Shared arguments")
    stated = _section(doc, "Args") + shared
    unnamed = [
        each.arg
        for each in parameters
        if not _is_of_package(each) and not re.search(rf"\b{each.arg}\b", stated)
    ]
    if module.path.startswith(DOORS) and len(parameters) >= MANY and unnamed:
        yield f"Args: {', '.join(unnamed)}"
    used = [line for line in re.split(r"\n(?=\S)", _dedent(shared)) if _names(line, parameters)]
    text = "\n".join([doc, *used])
    if has_arrays and not SHAPE.search(text):
        yield "shape"
    if has_units and not UNIT.search(text):
        yield "unit"


def _restating(node: Function) -> Iterator[str]:
    """Yield names of parameters whose entries only repeat their names and types."""
    types = {each.arg: each.annotation for each in _parameters(node, method=False)}
    section = _dedent(_section(ast.get_docstring(node) or "", "Args"))
    for entry in re.split(r"\n(?=\S)", section):
        head, _, text = entry.partition(":")
        names = [name.strip(" *") for name in head.split(",")]
        known = {
            word
            for name in names
            for word in _words(f"{name} {ast.unparse(types[name]) if types.get(name) else ''}")
        }
        is_plain = text.isascii() and re.fullmatch(r"[\w\s,.]+", text)
        if is_plain and _words(text) <= known | FILLERS:
            yield ", ".join(names)


def _words(text: str) -> set[str]:
    """Return the words of names and of prose, in the singular."""
    parted = re.findall(r"[A-Z]?[a-z]+|\d+", text)
    return {word.lower().rstrip("s") or word for word in parted}


def _is_of_package(parameter: ast.arg) -> bool:
    return (
        isinstance(annotation := parameter.annotation, ast.Name | ast.Constant)
        and ast.unparse(annotation).strip("'") in classes()
    )


def _dedent(section: str) -> str:
    lines = section.splitlines()
    least = min((len(s) - len(s.lstrip()) for s in lines if s.strip()), default=0)
    return "\n".join(line[least:] for line in lines)


def _names(entry: str, parameters: list[ast.arg]) -> bool:
    head = entry.partition(":")[0]
    return any(re.search(rf"\b{each.arg}\b", head) for each in parameters)


def _public(module: Module) -> Iterator[tuple[str, Function, Class | None]]:
    for node in module.tree.body:
        if isinstance(node, Function) and not node.name.startswith("_"):
            yield node.name, node, None
    for each in module.classes:
        if each.node.name.startswith("_"):
            continue
        for node in each.node.body:
            if isinstance(node, Function) and not node.name.startswith("_"):
                yield f"{each.node.name}.{node.name}", node, each


def findings(module: Module) -> list[str]:
    """Return what docstrings of a module lack, by function."""
    return [
        f"{module.name}:{node.lineno} {name}: {', '.join(lacks)}"
        for name, node, owner in _public(module)
        if (lacks := list(_missing(node, module, owner)))
    ]


def test_entries_say_more_than_names_and_types():
    found = [
        f"{module.name}:{node.lineno} {name}: {restating}"
        for module in modules()
        if not module.path.startswith(DOORS)
        for name, node, _ in _public(module)
        for restating in _restating(node)
    ]
    assert not found, "entries that only repeat a name:\n" + "\n".join(found)


@cache
def lacking() -> dict[str, list[str]]:
    """Return what docstrings lack, by module."""
    return {module.name: findings(module) for module in modules()}


EXAMPLES = {
    "def f(x): pass": "docstring",
    "def f(a, b, c):\n    '''Do it.'''": "Args: a, b, c",
    "def f(a, b, c):\n    '''Do it.\n\n    Args:\n        a, b: Numbers.\n    '''": "Args: c",
    "def f(x: NDArray[np.float64]):\n    '''Do it.'''": "shape, unit",
    "def f(x: NDArray[np.float64]):\n    '''Read words[k] of shape (n,).'''": "unit",
    "def f() -> 'NDArray[np.int64]':\n    '''Return indices.'''": "shape",
    "def f() -> NDArray[np.int64]:\n    '''Return indices, shape (n,).'''": "",
    "def f(x: NDArray[np.float64]):\n    '''Do it with x [m], shape (n,).'''": "",
    "def f():\n    '''Do it.'''\n    raise ValueError('no')": "Raises: ValueError",
    "def f():\n    '''Do it.\n\n    Raises:\n        ValueError: No.\n    '''\n"
    "    raise ValueError('no')": "",
    "def f():\n    '''Do it.'''\n    def g():\n        raise ValueError('no')": "",
    "'''M.\n\nShared arguments:\n    x: Positions [m], shape (n,).\n'''\n"
    "def f(x: NDArray[np.float64]):\n    '''Do it.'''": "",
    "class A:\n    def f(self, a, b, c):\n        '''Do it.'''": "Args: a, b, c",
    "def f(a, b: Network, c: 'State'):\n    '''Do it.'''": "Args: a",
    "class A:\n    @property\n    def f(self) -> int: ...": "",
    "class A:\n    @property\n    def f(self) -> NDArray[np.bool_]: ...": "docstring",
    "def _f(x): pass\nclass _A:\n    def f(self): pass": "",
}


@every(("source", "lacks"), EXAMPLES.items())
def test_examples_lack_what_is_expected(source, lacks):
    tree = ast.parse(source)
    module = Module("example.py", "", tree, list(ast.walk(tree)))
    assert [line.split(": ", 1)[1] for line in findings(module)] == [lacks] * bool(lacks)


def test_public_functions_document_arguments_arrays_and_errors():
    found = [line for name, lines in lacking().items() if name not in NOT_YET for line in lines]
    assert not found, "docstrings lack:\n" + "\n".join(found)


def test_modules_that_do_not_follow_the_rules_yet_exist_and_do_not():
    assert set(NOT_YET) <= {name for name, lines in lacking().items() if lines}
