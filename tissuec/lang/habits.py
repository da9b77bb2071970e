"""What people write out of habit from other languages, and what to write here instead.

A table of forms: each is looked for in the statement that could not be read.
"""

import re

from tissuec.core.errors import Diagnostic
from tissuec.core.hints import Edit, Hint
from tissuec.core.source import Span
from tissuec.core.units import converted
from tissuec.lang.habits_of_blocks import (
    AMOUNT,
    NUMBER,
    OF_BLOCKS,
    TEXT,
    TIMED,
    UNIT,
    UNUSED,
    VALUE,
    WORDS,
    Habit,
)
from tissuec.lang.mistake import Mistake
from tissuec.lang.ranges import MESSAGE, one_of, without_tolerance
from tissuec.lang.token_names import shown
from tissuec.lang.words import CONTINUING

_HABITS = (
    *OF_BLOCKS,
    # outputs and measures
    Habit(
        rf"{TIMED}(?P<wrong>(?P<what>{WORDS}) ?\((?P<whose>{WORDS})\))(?:$| with\b| by\b)",
        "an action has no parentheses", r"\g<what> \g<whose>",
    ),
    Habit(
        rf"^(?:expect|when) (?P<wrong>(?P<what>{WORDS}) of (?P<whose>{WORDS})"
        r"(?P<along>(?: along \([^()]*\))?)) ?(?:[<>=!]|between\b)",
        "in a condition, a measure takes its argument in parentheses",
        r"\g<what>(\g<whose>\g<along>)",
    ),
    Habit(
        rf"^{WORDS} of {WORDS}(?P<wrong> (?P<rate>{NUMBER} ?[kM]?Hz))$",
        'an output is taken "every" so often', None, "for example: force(A) every 1 ms",
    ),
    Habit(
        rf"^{WORDS}(?: ?\([^()]*\))? (?P<wrong>each|per) {AMOUNT}$",
        'an output is taken "every" so often', "every",
    ),
    Habit(
        rf"^{WORDS} of {WORDS}(?P<wrong> and {WORDS}) every\b",
        "an output is of one thing", None, "write an output of its own for each",
    ),
    Habit(
        r"^expect .*?(?P<wrong> always| throughout| all the time| at all times)$",
        "an expectation ends with its time", " over run",
    ),
    # numbers and vectors
    Habit(
        rf"(?P<wrong>(?P<number>{NUMBER}) ?\[(?P<unit>{UNIT})\])",
        "a unit has no brackets", r"\g<number> \g<unit>",
    ),
    Habit(
        r"\b(?:along|facing|by|through|around|at|from|to) "
        rf"(?P<wrong>(?P<x>{NUMBER}),? (?P<y>{NUMBER}),? (?P<z>{NUMBER}))(?!\d)",
        "a vector has round brackets and commas", r"(\g<x>, \g<y>, \g<z>)",
    ),
    Habit(
        rf"{TIMED}(?:moved|move {WORDS})(?<! by)(?<! along)(?P<wrong> ?)\([^()]*\)",
        'the way of a motion follows "by"', " by ", 'write "by" before the vector',
    ),
    Habit(
        rf"^(?P<wrong>adjust ?= ?\[? ?(?P<what>{WORDS}) of (?P<whose>{WORDS})\]?)$",
        "a list holds quantities of the tissue of the block", r"adjust \g<what> of \g<whose>",
    ),
    Habit(
        rf"^vary .*?(?P<wrong>\[{NUMBER}(?:, ?{NUMBER})*\] ?{UNIT})",
        "each number of a list has its own unit", None, "for example: [1 mm, 2 mm]",
    ),
    Habit(
        rf"(?P<wrong>\[(?P<parts>{AMOUNT}, ?{AMOUNT}, ?{AMOUNT})\]) ?{UNIT}",
        "a vector has round brackets", r"(\g<parts>)",
    ),
    Habit(
        rf"(?P<wrong><(?P<parts>{AMOUNT}, ?{AMOUNT}, ?{AMOUNT})>)",
        "a vector has round brackets", r"(\g<parts>)",
    ),
    Habit(
        rf"^(?!vary |expect |when |set |if |param |known ).*?= ?"
        rf"(?P<wrong>between (?P<low>{AMOUNT}) and (?P<high>{AMOUNT}))",
        MESSAGE, None, "range",
    ),
    Habit(
        rf"^(?!vary ).*?(?P<wrong>(?P<low>{AMOUNT}) ?\.\.\.? ?(?P<high>{AMOUNT}))",
        MESSAGE, None, "range",
    ),
    Habit(
        rf"= ?(?P<wrong>(?P<number>{NUMBER}) ?(?P<own>{UNIT})? ?\+/- ?{NUMBER}"
        rf" ?(?P<unit>{UNIT})?)$",
        MESSAGE, None, "tolerance",
    ),
    Habit(
        r"= ?(?P<wrong>(?:about|approximately|approx|ca|circa|roughly|around|some|nearly) "
        rf"(?P<number>{AMOUNT}))$",
        "a number has no tolerance", r"\g<number>",
    ),
    Habit(
        r"^(?!expect |when |set |if |vary ).*?= ?"
        rf"(?P<wrong>(?:[<>]=?|up to|at least|at most) ?(?P<number>{AMOUNT}))$",
        "one number is needed here, not a limit", r"\g<number>",
    ),
    Habit(
        rf"^adjust {WORDS}.*? (?P<wrong>between (?P<low>{AMOUNT}) and (?P<high>{AMOUNT}))$",
        'limits of a parameter have the form "from … to …"', r"from \g<low> to \g<high>",
    ),
    Habit(
        rf"^adjust {WORDS}.*? around {AMOUNT}(?P<wrong> ?(?:\+/-|±|,|within)? ?"
        rf"(?P<part>{NUMBER} ?%))$",
        'a deviation is given with "by"', r" by \g<part>",
    ),
    # sets and files
    Habit(rf"^(?P<wrong>on) {WORDS}$", "a force acts on a set or a body", "acts on"),
    Habit(
        rf"{TIMED}(?P<wrong>(?P<verb>fix|free|hold) (?P<one>{WORDS})(?: and |(?: ?[+&]+ ?))"
        rf"(?P<other>{WORDS}))$",
        "several sets are a list in brackets", r"\g<verb> [\g<one>, \g<other>]",
    ),
    Habit(
        rf"^(?P<verb>[a-z]+) {WORDS}(?P<wrong>,) (?P=verb) ",
        "a comma does not end an action", ";",
    ),
    Habit(
        r"(?P<wrong>(?<![\w\"./-])(?P<file>[\w./-]+\.(?:csv|tsv|txt|h5|trc|sto|obj|stl|ply))\b)",
        "the name of a file must be in quotes", r'"\g<file>"',
    ),
    Habit(
        r"^(?P<wrong>import|include|require|load) [\w./]+$",
        'other files are used with "use"', None, 'for example: use "matter/fat"',
    ),
    Habit(
        r'^(?P<wrong>(?P<word>use|about|author|laboratory|licence|cite) '
        rf'(?P<texts>\[?{TEXT}(?:(?: ?[,;]| and)? ?{TEXT})+\]?))$',
        "one text in quotes is needed here", None, "texts",
    ),
    # words and rules
    Habit(
        r"^(?!if\b|when\b|expect\b|set\b).*\bis "
        rf"(?P<wrong>(?P<low>{WORDS}) or (?P<high>{WORDS}))$",
        '"or" is for conditions only', r"between \g<low> and \g<high>",
    ),
    Habit(
        r"^if (?P<if>.+) then .+?(?P<wrong>,? else (?:then )?(?P<then>.+))$",
        'a rule has no "else"', r"; if not (\g<if>) then \g<then>",
        'write a second rule: "if not (…) then …"',
    ),
    Habit(
        rf"^if .*?(?P<wrong>weighing (?P<weight>{NUMBER}(?: ?%)?) "
        r"(?P<rest>(?:and|or|then) .+))$",
        '"weighing" is at the end of a rule', r"\g<rest> weighing \g<weight>",
    ),
    Habit(r"^if [^:]*? (?P<wrong>=>|->) ", 'a rule concludes with "then"', "then"),
    Habit(
        r"^if [^:]*?(?P<wrong>,)(?! then)(?=.* then )",
        'conditions are joined with "and"', " and",
    ),
    Habit(
        rf"^if .* then {WORDS} (?P<wrong>=.*)$", "a rule concludes words, not numbers", None,
        'write a word of its scale after "is"',
    ),
    Habit(
        rf"^.*\bis (?P<wrong>{NUMBER} ?% {WORDS})$",
        "a word takes a hedge, not a number", None,
        'write the word with a hedge, such as "rather soft"',
    ),
    # studies
    Habit(
        rf"^vary .+?= ?{AMOUNT}(?P<wrong> ?(?::|\.\.\.?|…) ?){AMOUNT}",
        'a range has the form "… to … in 5 steps"', " to ",
    ),
    Habit(
        rf"^vary .+?(?:=|is) ?(?P<wrong>(?P<values>{VALUE}(?:, ?{VALUE})+))$",
        "the values of a factor are a list", r"[\g<values>]",
    ),
    Habit(
        r"^vary .+ in [0-9]+ (?P<wrong>points|values|levels|runs|increments|samples)\b",
        'the number of values is given in "steps"', "steps",
    ),
    Habit(
        r"^vary .+?(?P<wrong>=) ?\{$", "the values of a factor are a list", None,
        "for example: vary NAME = [2 mm, 5 mm]",
    ),
    Habit(rf"^{WORDS}(?P<wrong> ?=) ?\{{$", 'a block begins without "="', "", 'leave out "="'),
    # times and motions
    Habit(r"^(?P<wrong>at (?:t|time) ?=? ?)[0-9]", "a time has no name", "at "),
    Habit(r"^(?P<wrong>(?:t|time) ?={1,2} ?)[0-9][^:]*:", "a time has no name", "at "),
    Habit(
        r"^(?P<wrong>(?:between|during) (?P<start>[0-9][^:]*?) (?:and|to) "
        r"(?P<stop>[0-9][^:]*?)) ?:",
        'an interval has the form "from … to …:"', r"from \g<start> to \g<stop>",
    ),
    Habit(
        rf"^(?P<wrong>(?:over|for|during|within) (?P<time>{AMOUNT})) ?:",
        "an interval has a beginning and an end", None,
        'write when it begins and ends: "from T to T:"',
    ),
    Habit(
        rf"^(?P<wrong>at (?P<start>{AMOUNT})(?:,| and)? (?:for|over) (?P<time>{AMOUNT})) ?:",
        'an interval has the form "from … to …:"', r"from \g<start> to \g<start> + \g<time>",
    ),
    Habit(
        rf"^(?P<wrong>(?:by|before) {AMOUNT}) ?:",
        "an action has the time at which it happens or begins", None,
        'write "at T:", or an interval that ends then: "from T to T:"',
    ),
    Habit(
        r"^(?P<wrong>(?:in|then|later|then at|later at|then after|starting at"
        rf"|beginning at) (?P<time>{AMOUNT})(?: later)?) ?:",
        "an action has a time from the start of the run", r"at \g<time>",
    ),
    Habit(
        rf"^(?P<wrong>(?:after )?(?:another )?(?P<time>{AMOUNT}) (?:later|afterwards)) ?:",
        "times are from the start of the run, not from the line above", None,
        'write "at" and the time since the start of the run: at T: …',
    ),
    Habit(
        rf"^(?P<wrong>after another {AMOUNT}) ?:",
        "times are from the start of the run, not from the line above", None,
        'write "at" and the time since the start of the run: at T: …',
    ),
    Habit(
        rf"^(?P<wrong>(?:during )?(?P<time>{AMOUNT})) ?:",
        'the word "at" is missing before a time', r"at \g<time>",
    ),
    Habit(
        r"^(?P<wrong>if (?P<when>.+?) then )(?!.*\bis\b).*$",
        'a script waits for a condition with "when"', r"when \g<when>: ",
    ),
    Habit(
        r"^(?P<wrong>(?:wait|pause|sleep|delay) .*)$",
        "each action has a time of its own", None,
        "give the next action a later time: at T: …",
    ),
    Habit(
        r"\bby \(.+?(?P<wrong> (?!using smooth profile)(?:using )?(?:smoothly|smooth)"
        r"(?: profile)?)(?:$| \w)",
        'a profile is named with "using"', " using smooth profile",
    ),
    Habit(
        r"\bby \(.+?(?P<wrong> (?:using )?(?:linearly|uniformly|evenly)"
        r"|(?<!using) (?:at |with )?constant speed)(?:$| \w)",
        'a profile is named with "using"', " using constant speed",
    ),
    Habit(
        r"\bthrough \([^()]*\)[^()]*?(?P<wrong>\b(?:with )?normal(?: to)?) ?\(",
        'a plane is turned with "facing"', "facing",
    ),
    Habit(
        rf"(?P<wrong>\b(?:at|along|through|across)(?: (?:the )?(?:line|plane))?"
        rf" (?:x|y|z) ?={{1,2}} ?{AMOUNT})", "a cut follows a plane", None, "along",
    ),
    Habit(
        rf"\bcut {WORDS} (?P<wrong>(?:(?:to|at|by) )?(?:a depth of )?{AMOUNT}"
        r"(?: (?:deep|into|long|wide)\b)?)(?: with | to |$)",
        "a cut has no depth, but a line from where it begins to where it ends", None,
        "for example: cut BODY along line from (20, -1, 0) mm to (20, 5, 0) mm "
        "facing (1, 0, 0)",
    ),
    # comparisons
    *(
        Habit(
            rf"(?P<wrong>(?: is| are)?(?: not)? (?:{words})) ?(?:{NUMBER}|\()",
            f'a comparison is written with "{sign}"', f" {sign}",
        )
        for sign, words in {
            ">": "greater than|more than|larger than|bigger than|above|exceeds",
            "<": "less than|smaller than|lower than|fewer than|below|under",
            ">=": "at least|no less than",
            "<=": "at most|no more than",
            "==": "equal to|equals",
        }.items()
    ),
    *(
        Habit(rf"(?P<wrong>{re.escape(wrong)})", f'"{wrong}" is not a sign', right)
        for wrong, right in {"=>": ">=", "=<": "<=", "<>": "!=", "===": "==", "**": "^"}.items()
    ),
    # programs and comments
    Habit(
        r"^(?P<wrong>for|while|loop|repeat)\b.*",
        "this is not how statements are repeated", None,
        'write "repeat i from 1 to 8 { … }"; for actions at several times, "from T to T every '
        'T: …"; for many runs, a study',
    ),
    Habit(
        rf"^(?P<wrong>(?:(?:def|function|param|set) )?(?P<what>{UNUSED}{WORDS}) ?"
        rf"\((?P<names>{WORDS}(?:, ?{WORDS})*)\)) ?=(?!=)",
        'a function is declared with "let"', r"let \g<what>(\g<names>)",
    ),
    Habit(
        rf"^let (?P<wrong>(?P<what>{WORDS}) ?\( ?\)) ?=",
        "a function has at least one parameter; without one it is a number", r"\g<what>",
    ),
    Habit(
        r"^(?P<wrong>def|function)\b.*",
        'a function is declared with "let"', None, "for example: let f(x) = 2 * x",
    ),
    Habit(
        r"^(?P<wrong>class|return|print)\b.*",
        "a scene says what there is, and not what a program does", None,
        'name a number with "let", and a tissue with "tissue NAME like OTHER"',
    ),
    Habit(r"^(?P<wrong>%+|--+|<!--)(?= )", 'a comment begins with "#"', "#"),
    Habit(
        rf"^(?P<wrong>simulate (?:for )?(?P<time>{AMOUNT})) ?\{{$",
        "a block gives its numbers names", None, "for example: simulate { duration = 1 s }",
    ),
)  # fmt: skip


def habit(m: Mistake) -> Diagnostic | None:
    """Recognise one of the forms above around the wrong token."""
    tokens = [*m.before, m.found, *m.after]
    start, stop = tokens[0].start, max(m.statement.stop, tokens[0].stop)
    line = m.source.text.rfind("\n", 0, m.found.start) + 1
    begun = _CONTINUED.match(m.source.text, line)
    if begun and start < line:  # it was read as the rest of the line above
        start, stop = begun.end(), m.source.text.find("\n", m.found.start)
        stop = len(m.source.text) if stop < 0 else stop
    text = m.source.text[start:stop].rstrip()
    if m.statement.is_head or m.found.type == "LBRACE":
        text += " {"
    if len(text) > _LONGEST or "\n" in text:
        return None
    for one, form in _FORMS:
        found = form.search(text)
        if found is None or not found.start() <= m.found.start - start <= found.end() + 1:
            continue
        place = Span(m.source, start + found.start("wrong"), start + found.end("wrong"))
        if one.hint == "texts":
            hint = _each_text(place, found["word"], re.findall(TEXT, found["texts"]))
        elif one.hint == "range":
            hint = one_of(found["low"], found["high"], place)
        elif one.hint == "tolerance":
            hint = without_tolerance(found["number"], found["own"] or found["unit"], place)
        else:
            hint = _hint(one, found, place)
        return Diagnostic("TIS312", one.message, place, hint)
    return None


def _each_text(place: Span, word: str, texts: list[str]) -> Hint:
    """Return the hint to write a sentence for each text, or one with all of them."""
    text = f'{word} "{", ".join(one.strip(chr(34)) for one in texts)}"'
    if word in ("use", "author"):
        text = "; ".join(f"{word} {one}" for one in texts)
    return Hint(f"write: {text}", Edit(text, place))


def _hint(one: Habit, found: re.Match[str], place: Span) -> Hint:
    if one.hint in ("along", "about"):
        return _plane(place, one.hint)
    if one.instead is None:
        return Hint(one.hint)
    text = found.expand(one.instead)
    written = f": {text.strip()}" if '"' in text else f" {shown(text.strip())}"
    return Hint(one.hint or f"write{written}", Edit(text, place))


def _plane(place: Span, word: str) -> Hint:
    """Return the hint to write a plane, after a word, in place of ``at x = 20 mm``."""
    axis = re.search(r"[xyz]", place.text)
    value = re.search(rf"({NUMBER}) ?({UNIT})?$", place.text)
    assert axis is not None and value is not None
    point, normal = (
        ", ".join(at if axis[0] == one else "0" for one in "xyz") for at in (value[1], "1")
    )
    text = f"{word} plane through ({point}) {value[2] or 'mm'} facing ({normal})"
    return Hint(
        f'write "{text}"', *([Edit(text, place)] if value[2] or value[1] == "0" else [])
    )


def inches(m: Mistake) -> Diagnostic | None:
    """Recognise ``0.2 in`` and ``4 N/in``: "in" is a reserved word."""
    at = m.found if m.found.type == "IN" else m.before[-1] if m.previous == "IN" else None
    if at is None:
        return None
    line = m.source.line_text(m.span(at).line)
    column = m.span(at).column - 1
    found = re.search(rf"({NUMBER}) ?((?:{UNIT}[*/])?in)\Z", line[: column + 2])
    if found is None or (text := converted(found[1], found[2])) is None:
        return None
    start = at.stop - len(found[0])
    place = Span(m.source, start, at.stop)
    message = "inches are not units of the language"
    return Diagnostic("TIS104", message, place, Hint(f'write "{text}"', Edit(text, place)))


_LONGEST = 2000

#: The space before a word that continues the line above.
_CONTINUED = re.compile(rf"[ \t]*(?=(?:{'|'.join(CONTINUING)})\b)")
_FORMS = tuple((one, re.compile(one.form)) for one in _HABITS)
