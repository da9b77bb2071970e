"""Habits about blocks, copies, laws and names, and how any habit is described."""

from typing import NamedTuple

from tissuec.lang.tokens import NUMBER_PATTERN

NUMBER = rf"-?{NUMBER_PATTERN}"
UNIT = r"(?:[^\W\d]|%)[\w*/·^-]*"
AMOUNT = rf"{NUMBER}(?: ?{UNIT})?"
WORDS = r"[^\W\d]\w*(?: [^\W\d]\w*)*"
UNUSED = r"(?!(?:let|expect|when|if|at|after|from)\b)"  # begins statements of other kinds
VALUE = rf"(?:{AMOUNT}|{WORDS})"
TEXT = r'"[^"]*"'
TIMED = r"^(?:(?:at|after|from|when)\b[^:]*: ?)?"


class Habit(NamedTuple):
    """A form that is not part of the language.

    Attributes:
        form: Regular expression of a statement; its group "wrong" is to be replaced.
        message: What is wrong.
        instead: What replaces it, with the other groups; None where that is not clear.
        hint: What to do; empty for ``write "…"``.
    """

    form: str
    message: str
    instead: str | None = None
    hint: str = ""


_LAW = "spring force|viscous force|stress"
_VECTOR = r"\([^()]*\)(?: ?[a-zµ]?m\b)?"

OF_BLOCKS = (
    # blocks and lists
    Habit(
        r"^(?:tool|body|tissue|joint|environment|script|simulate|output|mesh is)"
        rf"(?: {WORDS})? ?"
        r"(?P<wrong>\[(?P<inside>[^\[\]]*)\])$",
        "a block is enclosed in braces", r"{\g<inside>}",
    ),
    Habit(
        r"^(?P<wrong>[-*•] )(?=[^\W\d])", "a statement begins with its first word", "",
        "leave out the dash",
    ),
    Habit(
        r"^(?P<wrong>(?:expects|expected|expecting|except|assert|ensure|require|verify|check):?)"
        r" .*(?:[<>]|==|\bbetween\b|\bruptured\b).*",
        'an expectation begins with "expect"', "expect",
    ),
    Habit(
        r"^(?P<wrong>is (?P<what>forceps|clamp|needle|scissors|probe|hook|plane|nozzle))$",
        'what a tool is follows "kind is"', r"kind is \g<what>",
    ),
    # copies and places
    Habit(
        rf"^(?:body|tissue) [^\W\d].*?(?P<wrong> (?:is like|is as|is a copy of|is|as|equals|="
        rf"|copies|copy of|copied from|same as)) {WORDS} ?\{{$",
        'a copy is declared with "like"', " like",
    ),
    Habit(
        r"^(?:turned\b|.*\bturn\b).*?(?P<wrong>\babout\b) ?\(",
        'the axis of a turn follows "around"', "around",
    ),
    Habit(
        rf"^(?:turned|scaled)(?P<wrong> ?){AMOUNT}", "the amount follows \"by\"", " by ",
        'write "by" before the number',
    ),
    Habit(
        rf"^mirrored (?P<wrong>(?:(?:at|along|about|in|through) )?(?:the )?(?:plane )?"
        rf"[xyz] ?={{1,2}} ?{AMOUNT})", "a body is mirrored about a plane", None, "about",
    ),
    # repetitions
    Habit(
        r"^repeat \w+ from (?P<wrong>(?P<low>\d+) ?(?:\.\.\.?|-|:) ?(?P<high>\d+))",
        'a repetition counts from one number "to" another', r"\g<low> to \g<high>",
    ),
    Habit(
        r"^repeat \w+ (?P<wrong>in \[? ?(?P<low>\d+) ?(?:\.\.\.?|-|:) ?(?P<high>\d+) ?\]?)",
        'a repetition counts from one number "to" another', r"from \g<low> to \g<high>",
    ),
    Habit(
        r"^(?P<wrong>(?:repeat|for) (?P<index>[^\W\d]\w*) ?= ?(?P<low>\d+) ?"
        r"(?:to|\.\.\.?|:|-) ?(?P<high>\d+):?) ?(?:\{|$)",
        "this is not how statements are repeated",
        r"repeat \g<index> from \g<low> to \g<high>",
    ),
    # laws
    Habit(
        rf"^(?P<wrong>(?P<law>{_LAW}) of) ?=", "the argument of a law is missing",
        r"\g<law> of e",
    ),
    Habit(
        rf"^(?P<wrong>(?P<law>{_LAW}) ?\((?P<names>{WORDS}(?:, ?{WORDS})*)\)) ?=",
        'the argument of a law follows "of"', r"\g<law> of \g<names>",
    ),
    # actions
    Habit(
        rf"{TIMED}[a-z]+ (?P<wrong>(?:the )?set )(?=[^\W\d])",
        'the name of a set is written without "set"', "",
        'leave out "set"',
    ),
    Habit(
        rf"{TIMED}(?P<wrong>with|by|along|using) ", "an action begins with its verb", None,
        "for example: grasp SET with TOOL",
    ),
    Habit(
        rf"{TIMED}move (?P<wrong>by (?P<way>{_VECTOR}) (?P<what>{WORDS}?))(?= using\b|$)",
        "what moves follows the verb", r"\g<what> by \g<way>",
    ),
    *(
        Habit(
            rf"{TIMED}move {WORDS} (?P<wrong>(?:by )?(?P<way>{AMOUNT}) {word}(?:wards?)?){end}",
            "a motion is a vector", rf"by (0, 0, {sign}\g<way>){profile}",
        )
        for word, sign in {"up": "", "down": "-"}.items()
        for end, profile in {" ?$": " using smooth profile", r"\b": ""}.items()
    ),
    # numbers
    Habit(
        rf"^vary {WORDS}(?P<wrong> ){AMOUNT}",
        '"=" is missing between a factor and its values', " = ", 'write "=" before the values',
    ),
    Habit(
        rf"(?P<wrong>(?P<number>{NUMBER}) ?[xX×*·⋅] ?10 ?\^ ?(?P<power>-?\d+))",
        'a power of ten is written with "e"', r"\g<number>e\g<power>",
    ),
    Habit(
        rf"(?P<wrong>>=? ?(?P<low>{AMOUNT}) (?:and|,|&&) ?<=? ?(?P<high>{AMOUNT}))",
        "each comparison has two sides", r"between \g<low> and \g<high>",
    ),
    Habit(
        r"(?P<wrong>\b(?P<first>[A-Za-z]+)-(?P<second>[A-Za-z]+)\b)",
        "a name has no hyphen", r"\g<first> \g<second>",
    ),
    Habit(
        r"^mesh is (?P<wrong>\"?(?P<file>[\w./-]+\.(?:obj|stl|ply|off|msh|vtk|vtu|inp))\"?)",
        "a mesh from a file is imported", r'imported { file "\g<file>" in mm }',
    ),
)  # fmt: skip
