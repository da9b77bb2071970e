# ruff: noqa: E501  # texts as they are
"""Mistakes that new users made in a scene of two layers, a joint and three tools."""

from tests.mistakes import Mistake as M

SCENE = """language 1
about "A strip of skin on a block of fat, forceps and a probe."
use "matter/skin"
use "matter/fat"
use "fuzzy/soft_matter"

param lift = 6 mm between 0 mm and 12 mm
let side = 40 mm

tissue graft like own { elasticity is big }
tissue own { described in soft matter; hardness is soft; elasticity is medium; weight is medium; shiftability is low; consistency is smooth }
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 mg; breaking force = 1 N }

body strip {
  mesh is sheet {
    corner = (0, 0, 20) mm; first edge = (40, 0, 0) mm; second edge = (0, 20, 0) mm
    columns = 9; rows = 5
  }
  tissue is skin
  thickness = 2 mm
}
body pad {
  mesh is lattice { cell = 5 mm; box from (0, 0, 0) mm to (40, 20, 10) mm }
  tissue is fat
  region lump where x < 10 mm { tissue is graft }
  rupture is allowed
}
joint anchors { springs from lower side to pad; reach = 25 mm; tissue is cord; rupture is allowed }
set left edge = nodes of strip where x < 1 mm
set right edge = nodes of strip where x > 39 mm
set floor = nodes of pad where z < 0.1 mm
set lower side = nodes of strip where y < 1 mm
tool forceps A { kind is forceps }
tool shears { kind is scissors }
tool probe { kind is probe; radius = 4 mm; centre = (20, 10, 30) mm }

environment { gravity = (0, 0, -9.81) m/s^2; contact is tools only; damping = 1 mN*s/m }
script {
  at 0 s: { fix left edge; fix floor }
  at 0.1 s: grasp right edge with forceps A
  from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile
  at 0.4 s: cut strip along plane through (20, 0, 0) mm facing (1, 0, 0) with shears
  from 0.1 s to 0.3 s: move probe by (0, 0, -3) mm using smooth profile
}
simulate { duration = 0.5 s; tolerance = 1e-3 }
output {
  trajectory every 20 ms
  force of forceps A every 1 ms
  position of right edge every 5 ms
}
expect force(forceps A along (0, 0, 1)) > 1 mN at 0.3 s
expect count(pieces of strip) == 2 at 0.45 s
expect distance(left edge, right edge) < 2 * side over run

"""

MISTAKES = {
    "assert for expect": M(
        "expect count(pieces", "assert count(pieces", "TIS312", "assert", 'write "expect"'
    ),
    "a colon after expect": M(
        "expect count(pieces", "expect: count(pieces", "TIS312", ":", 'leave out ":"'
    ),
    "a tool without kind": M(
        "{ kind is scissors }",
        "{ is scissors }",
        "TIS312",
        "is scissors",
        'write "kind is scissors"',
    ),
    "bars of an absolute value": M(
        "nodes of strip where x > 39 mm",
        "nodes of strip where |x - 20 mm| > 19 mm",
        "TIS114",
        "|",
        'write "abs(x - 20 mm)"',
    ),
    "a copy that is moved by a number": M(
        "tool forceps A",
        "body further like pad { moved by 60 mm }\nset end = nodes of further where x > 99 mm\n"
        "tool forceps A",
        "TIS312",
        "by 60 mm",
        "by (0, 0, 60 mm)",
    ),
    "thickness without a unit": M(
        "thickness = 2 mm", "thickness = 2", "TIS501", "2", 'write "2 mm"'
    ),
    "unit in capitals": M(
        "radius = 4 mm", "radius = 4 MM", "TIS104", "MM", 'did you mean "mm"?'
    ),
    "kpa": M(
        "tissue own { described",
        "tissue own { Young's modulus = 5 kpa; described",
        "TIS104",
        "kpa",
        'did you mean "kPa"?',
    ),
    "mmhg": M(
        "tissue own { described",
        "tissue own { Young's modulus = 40 mmhg; described",
        "TIS104",
        "mmhg",
        'did you mean "mmHg"?',
    ),
    "temperature": M(
        "param lift",
        "param warm = 37 C\nparam lift",
        "TIS104",
        "C",
        "temperatures are not part of the language",
    ),
    "inches": M("radius = 4 mm", "radius = 0.2 in", "TIS104", "0.2 in", 'write "5.08 mm"'),
    "decimal comma in a density": M(
        "tissue own { described",
        "tissue own { density = 1,06 g/cm^3; described",
        "TIS108",
        ",",
        'write "density = 1.06 g/cm^3"',
    ),
    "decimal comma in a vector": M(
        "corner = (0, 0, 20) mm",
        "corner = (0,5, 0, 20) mm",
        "TIS312",
        "(0,5, 0, 20) mm",
        "write decimals with a point",
    ),
    "decimal comma in a time": M(
        "at 0.4 s: cut",
        "at 0,4 s: cut",
        "TIS108",
        ",",
        'write "at 0.4 s: cut strip along plane through (20, 0, 0) mm facing (1',
    ),
    "unit twice": M(
        "duration = 0.5 s", "duration = 500ms s", "TIS104", "s", 'write one unit: "500ms"'
    ),
    "sec": M("duration = 0.5 s", "duration = 0.5 sec", "TIS104", "sec", 'did you mean "s"?'),
    "viscosity as of a fluid": M(
        "viscosity = 10 mN*s/m",
        "viscosity = 10 mPa*s",
        "TIS502",
        "10 mPa*s",
        "write a force per speed, such as 10 mN*s/m",
    ),
    "product for a quotient": M(
        "spring constant = 40 N/m",
        "spring constant = 0.04 N mm",
        "TIS104",
        "mm",
        'write "N/mm" or "N*mm"',
    ),
    "gravity as a number": M(
        "gravity = (0, 0, -9.81) m/s^2",
        "gravity = 9.81 m/s^2",
        "TIS312",
        "9.81 m/s^2",
        "for example: gravity = (0, 0, -9.81) m/s^2",
    ),
    "gravity missing": M(
        "gravity = (0, 0, -9.81) m/s^2; ",
        "",
        "TIS304",
        "environment",
        "for example: gravity = (0, 0, -9.81) m/s^2",
    ),
    "gravity in g": M(
        "(0, 0, -9.81) m/s^2",
        "(0, 0, -1) g",
        "TIS502",
        "(0, 0, -1) g",
        '1 g is 9.80665 m/s^2: write "(0, 0, -9.80665) m/s^2"',
    ),
    "point of two numbers": M(
        "centre = (20, 10, 30) mm",
        "centre = (20, 10) mm",
        "TIS312",
        "(20, 10) mm",
        "write 0 for an unused component",
    ),
    "square brackets": M(
        "by (0, 0, -3) mm", "by [0, 0, -3] mm", "TIS312", "[0, 0, -3]", 'write "(0, 0, -3)"'
    ),
    "property misspelt": M(
        "hardness is soft;",
        "hardnes is soft;",
        "TIS202",
        "hardnes",
        'did you mean "hardness"?  entries: hardness, elasticity, weight, shift',
    ),
    "word misspelt": M(
        "hardness is soft;",
        "hardness is softly;",
        "TIS201",
        "softly",
        'did you mean "soft"?  words for hardness: soft, medium, hard; hedges: ',
    ),
    "word of another property": M(
        "weight is medium",
        "weight is soft",
        "TIS201",
        "soft",
        "words for weight: low, medium, high; hedges: very, extremely, markedly",
    ),
    "synonym of a word": M(
        "hardness is soft;",
        "hardness is stiff;",
        "TIS201",
        "stiff",
        "words for hardness: soft, medium, hard; hedges: very, extremely, marke",
    ),
    "equals before a word": M(
        "hardness is soft;",
        "hardness = soft;",
        "TIS312",
        "hardness = soft",
        'write "hardness is soft"',
    ),
    "is before a number": M(
        "thickness = 2 mm", "thickness is 2 mm", "TIS312", "is", 'write "thickness = 2 mm"'
    ),
    "hedge unknown": M(
        "hardness is soft;",
        "hardness is quite soft;",
        "TIS201",
        "quite soft",
        "words for hardness: soft, medium, hard; hedges: very, extremely, marke",
    ),
    "second in capitals": M(
        "duration = 0.5 s", "duration = 0.5 S", "TIS104", "S", 'did you mean "s"?'
    ),
    "tissue unknown": M(
        "tissue is skin\n",
        "tissue is dermis\n",
        "TIS301",
        "dermis",
        "tissues: skin, aged skin, fat, graft, own, cord",
    ),
    "file that does not exist": M(
        'use "matter/fat"',
        'use "matter/stomach"',
        "TIS601",
        'use "matter/stomach"',
        "there are: matter/artery_wall, matter/bladder_wall, matter/bowel_wall,",
    ),
    "folder left out": M(
        'use "matter/fat"', 'use "fat"', "TIS601", 'use "fat"', 'did you mean "matter/fat"?'
    ),
    "entry in the wrong block": M(
        "columns = 9;",
        "thickness = 2 mm; columns = 9;",
        "TIS303",
        "thickness",
        "entries: corner, first edge, second edge, columns, rows, diagonals, se",
    ),
    "friction of a tool": M(
        "kind is probe; ",
        "kind is probe; friction = 0.2; ",
        "TIS303",
        "friction",
        "entries: radius, centre, axis",
    ),
    "integrator in the environment": M(
        "contact is tools only; ",
        "contact is tools only; integrator is dop853; ",
        "TIS303",
        "integrator",
        "entries: gravity, contact, contact places, friction, contact stiffness",
    ),
    "brace of a body missing": M(
        "  rupture is allowed\n}\njoint",
        "  rupture is allowed\njoint",
        "TIS101",
        "",
        'add "}" at the end of the block',
    ),
    "brace too many in the script": M(
        "  from 0.1 s to 0.3 s: move probe",
        "  }\n  from 0.1 s to 0.3 s: move probe",
        "TIS102",
        "}",
        "remove it",
    ),
    "brace too many after the head": M(
        "script {\n", "script {\n  }\n", "TIS102", "}", "remove it"
    ),
    "colon missing": M(
        "at 0.4 s: cut",
        "at 0.4 s cut",
        "TIS105",
        "cut",
        'write "at 0.4 s: cut strip along plane through (20, 0, 0) mm facing (1',
    ),
    "place of a tool as a time": M("centre = ", "at ", "TIS105", "at", 'write "centre = '),
    "two verbs on a line": M(
        "fix left edge; fix floor",
        "fix left edge fix floor",
        "TIS107",
        "fix",
        'put ";" or a line break before "fix"',
    ),
    "action without a time": M(
        "  at 0 s: { fix left edge; fix floor }",
        "  fix left edge\n  at 0 s: fix floor",
        "TIS304",
        "fix left edge",
        "for example: at 0 s: fix left edge",
    ),
    "times reversed": M(
        "from 0.1 s to 0.3 s: move forceps",
        "from 0.3 s to 0.1 s: move forceps",
        "TIS403",
        "from 0.3 s to 0.1 s",
        'write "from 0.1 s to 0.3 s"',
    ),
    "profile missing": M(
        " using smooth profile\n  at 0.4",
        "\n  at 0.4",
        "TIS304",
        "move forceps A by (0 mm, 0 mm, lift)",
        "profiles after using: constant speed, ramp, smooth profile, sine, tabl",
    ),
    "moved before grasped": M(
        "at 0.1 s: grasp",
        "at 0.35 s: grasp",
        "W401",
        "move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "write before the motion: grasp … with forceps A",
    ),
    "moved at a moment": M(
        "from 0.1 s to 0.3 s: move probe",
        "at 0.1 s: move probe",
        "TIS304",
        "using smooth profile",
        "use from … to …: instead of at …:",
    ),
    "grasp with a probe": M(
        "grasp right edge with forceps A",
        "grasp right edge with probe",
        "TIS405",
        "with probe",
        'write "with forceps A"',
    ),
    "cut with forceps": M(
        "with shears", "with forceps A", "TIS405", "with forceps A", 'write "with shears"'
    ),
    "plane without facing": M(
        " facing (1, 0, 0) with shears",
        " with shears",
        "TIS304",
        "cut strip along plane through (20, 0, 0) mm with shears",
        "for example: facing (1, 0, 0)",
    ),
    "expected after the end": M(
        "at 0.3 s\nexpect",
        "at 0.9 s\nexpect",
        "TIS703",
        "0.9 s",
        "write an earlier time, or a longer duration in simulate",
    ),
    "equals as a test": M("== 2 at", "= 2 at", "TIS111", "=", 'write "=="'),
    "expected at no time": M(
        "> 1 mN at 0.3 s",
        "> 1 mN",
        "TIS304",
        "expect force(forceps A along (0, 0, 1)) > 1 mN",
        "end with: at TIME, from TIME to TIME, until TIME or over run",
    ),
    "set in the wrong unit": M(
        "x > 39 mm",
        "x > 39 cm",
        "TIS302",
        "right edge",
        "x runs from 0 m to 40 mm, y runs from 0 m to 20 mm, z runs from 20 mm ",
    ),
    "set by an exact number": M(
        "pad where z < 0.1 mm",
        "pad where z == 0.1 mm",
        "TIS302",
        "floor",
        "the nearest have z == 0 m and z == 5 mm",
    ),
    "chained comparison": M(
        "nodes of strip where x > 39 mm",
        "nodes of strip where 30 mm < x < 50 mm",
        "TIS100",
        "<",
        'write "x between 30 mm and 50 mm"',
    ),
    "and of a program": M(
        "pad where z < 0.1 mm",
        "pad where z < 0.1 mm && x > 3 mm",
        "TIS114",
        "&&",
        'write "and"',
    ),
    "node in the singular": M(
        "set floor = nodes of pad where z < 0.1 mm",
        "set floor = node of pad",
        "TIS312",
        "node",
        'write "nodes"',
    ),
    "body misspelt": M(
        "nodes of pad where",
        "nodes of pads where",
        "TIS301",
        "pads",
        'did you mean "pad"?  bodies: strip, pad',
    ),
    "mass below zero": M("mass = 5 mg", "mass = -5 mg", "TIS308", "-5 mg", 'write "5 mg"'),
    "incompressible": M(
        "tissue own { described",
        "tissue own { Poisson's ratio = 0.5; described",
        "TIS308",
        "0.5",
        'write "0.4999"',
    ),
    "mesh far too fine": M(
        "cell = 5 mm",
        "cell = 0.05 mm",
        "TIS310",
        "body pad",
        "at most 50 000 000 of each are possible",
    ),
    "cell that does not fit": M(
        "cell = 5 mm",
        "cell = 3 mm",
        "TIS309",
        "box from (0, 0, 0) mm to (40, 20, 10) mm",
        'mesh lattice: "box" is 40 mm long in x, which is not a whole number of',
    ),
    "thickness missing": M(
        "  thickness = 2 mm\n", "", "TIS304", "body strip", "for example: thickness = 1 mm"
    ),
    "circle of tissues": M(
        "tissue graft like own { elasticity is big }",
        "tissue allograft like graft { }\ntissue graft like allograft { elasticity is big }",
        "TIS506",
        "tissue allograft like graft",
        "circular inheritance of tissues: allograft -> graft -> allograft",
    ),
    "circle of numbers": M(
        "let side = 40 mm",
        "let side = width\nlet width = side / 2",
        "TIS506",
        "side",
        "circular definition of numbers: side -> width -> side",
    ),
    "param beyond its limits": M(
        "lift = 6 mm between",
        "lift = 60 mm between",
        "TIS308",
        "60 mm",
        "write a number between its limits, or other limits",
    ),
    "is after a param": M(
        "param lift = 6 mm",
        "param lift is 6 mm",
        "TIS312",
        "is",
        'write "param lift = 6 mm between 0 mm and 12 mm"',
    ),
    "output in the plural": M(
        "force of forceps A every",
        "forces of forceps A every",
        "TIS701",
        "forces",
        'did you mean "force"?  outputs: trajectory, precision, compress, blocks, surfa',
    ),
    "output unknown": M(
        "force of forceps A every",
        "colour of strip every",
        "TIS701",
        "colour",
        "outputs: trajectory, precision, compress, blocks, surface, energy, applied pressure",
    ),
    "output at a rate": M(
        "force of forceps A every 1 ms",
        "force of forceps A at 1 kHz",
        "TIS303",
        "at 1 kHz",
        'write "every 1 ms"',
    ),
    "measure as an output": M(
        "expect force(forceps A along (0, 0, 1)) >",
        "expect force of forceps A along (0, 0, 1) >",
        "TIS312",
        "force of forceps A along (0, 0, 1)",
        'write "force(forceps A along (0, 0, 1))"',
    ),
    "verb unknown": M(
        "move forceps A by", "lift forceps A by", "TIS404", "lift", 'did you mean "move"?'
    ),
    "comment of a program": M(
        "body pad {", "// the fat below\nbody pad {", "TIS312", "//", 'write "#"'
    ),
    "curly quotes": M('use "matter/fat"', "use “matter/fat”", "TIS114", "“", 'type " instead'),
    "language missing": M(
        "language 1\n", "", "TIS117", "about", 'write "language 1" as the first line'
    ),
    "contact off with a probe": M(
        "contact is tools only",
        "contact is off",
        "W407",
        "tool probe",
        "write: environment { contact is tools only; … }",
    ),
    "nothing fixed": M(
        "  at 0 s: { fix left edge; fix floor }\n",
        "",
        "W310",
        "body strip",
        'hold it, for example with "at 0 s: fix SET"',
    ),
    "contact on": M(
        "contact is tools only",
        "contact is on",
        "TIS305",
        "on",
        "choices: off, tools only, bodies too, everywhere",
    ),
    "fibres missing": M(
        ('use "matter/fat"\n', "tissue is skin\n"),
        ('use "matter/fat"\nuse "matter/tendon"\n', "tissue is tendon\n"),
        "TIS304",
        "body strip",
        "for example: fibres = (1, 0, 0)",
    ),
    "word over a number": M(
        "tissue graft like own {",
        "tissue stiff fat like fat { hardness is hard }\ntissue graft like own {",
        "W206",
        "hardness is hard",
        'write "Young\'s modulus is concluded", so that the words count, or "You',
        ("W208",),
    ),
    "number with a tolerance": M(
        "mass = 5 mg",
        "mass = 5 ± 1 mg",
        "TIS114",
        "±",
        'a number has no tolerance: write "5 mg", and vary it in a study',
    ),
    "percent twice": M(
        "damping = 1 mN*s/m",
        "damping = 1 mN*s/m; friction = 30 %%",
        "TIS100",
        "%",
        'a unit follows a number: "5 %"',
    ),
    "superscript": M("m/s^2", "m/s²", "TIS114", "²", "type ^2 instead"),
    "minus of a word processor": M(
        "(0, 0, -9.81)", "(0, 0, −9.81)", "TIS114", "−", "type - instead"
    ),
    "path without quotes": M(
        'use "matter/fat"', "use matter/fat", "TIS312", "/", 'write use "matter/fat"'
    ),
    "moment without a unit": M(
        "at 0.4 s: cut", "at 0.4: cut", "TIS501", "0.4", 'write "0.4 s"'
    ),
    "rule in a tissue": M(
        "tissue graft like own {",
        "tissue graft like own { if hardness is soft then density is low;",
        "TIS303",
        "if hardness is soft then density is low",
        "rules belong in a block of their own: rules NAME { if … then … }",
    ),
    "else": M(
        "tissue graft",
        "rules more { if hardness is soft then density is low else density is high }\ntissue graft ",
        "TIS312",
        " else density is high",
        'write a second rule: "if not (…) then …"',
        ("W202",),
    ),
    "weighing in the middle": M(
        "tissue graft",
        "rules more { if hardness is high weighing 0.3 and density is heavy then density is low }\ntissue graft ",
        "TIS312",
        "weighing 0.3 and density is heavy then density is low",
        'write "and density is heavy then density is low weighing 0.3"',
        ("TIS201",),
    ),
    "range without units": M(
        "expect count(pieces",
        "study s { vary lift = 2 to 10 in 5 steps; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS501",
        "2",
        'write "2 mm"',
        ("TIS501",),
    ),
    "maximum": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm to 10 mm in 5 steps; measure pull = maximum(force of forceps A) }\nexpect count(pieces",
        "TIS701",
        "maximum",
        'did you mean "max"?',
    ),
    "study of an unknown word": M(
        "expect count(pieces",
        "study s { vary hardness of own = [soft, tough]; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS201",
        "tough",
        "words for hardness: soft, medium, hard; hedges: very, extremely, marke",
    ),
    "study without a measure": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm to 10 mm in 5 steps }\nexpect count(pieces",
        "TIS304",
        "study s",
        "for example: measure pull = max(force(forceps A))",
    ),
    "learn in a scene that is not saved": M(
        "expect count(pieces",
        'learn cord { data = ["a.csv"]; adjust spring constant }\nexpect count(pieces',
        "TIS604",
        '"a.csv"',
        "save the scene to a file",
    ),
    "learn from a folder, not saved": M(
        "expect count(pieces",
        'learn cord { data = ["t/a.csv"]; fit = force(right edge along (1, 0, 0)) using column "f" in N; adjust spring constant }\nexpect count(pieces',
        "TIS604",
        '"t/a.csv"',
        "save the scene to a file",
    ),
    "cut at a place": M(
        "along plane through (20, 0, 0) mm facing (1, 0, 0) with",
        "at x = 20 mm with",
        "TIS312",
        "at x = 20 mm",
        'write "along plane through (20, 0, 0) mm facing (1, 0, 0)"',
    ),
    "or between words": M(
        "hardness is soft;",
        "hardness is soft or medium;",
        "TIS312",
        "soft or medium",
        'write "between soft and medium"',
    ),
    "measure of a union with a tool": M(
        "expect force(forceps A along (0, 0, 1)) > 1 mN",
        "expect force([floor, forceps A]) > 1 mN",
        "TIS312",
        "forceps A",
        "measure forceps A on its own",
    ),
    "two libraries with the same tissue": M(
        'use "matter/fat"',
        'use "matter/fat"\nuse "tissues/skin"',
        "TIS503",
        'use "tissues/skin"',
        "use one of the two: tissues/ describes single springs, matter/ the mat",
    ),
    "name with of, used": M(
        ("set floor =", "fix floor"),
        ('set "base of wall" = nodes of pad where z < 1 mm\nset floor =', "fix base of wall"),
        "TIS115",
        "base of wall",
        'write the name in quotes: "base of wall"',
    ),
    "measure of a name with of": M(
        ("set floor =", "expect force(forceps A along (0, 0, 1)) > 1 mN at 0.3 s"),
        (
            'set "base of wall" = nodes of pad where z < 1 mm\nset floor =',
            "expect distance(base of wall, floor) < 1 m at 0.3 s",
        ),
        "TIS115",
        "base of wall",
        'write the name in quotes: "base of wall"',
    ),
    "action at the end": M(
        "at 0.4 s: cut",
        "at end: cut",
        "TIS301",
        "end",
        "a time is a number, such as 0.5 s, or one with a name: let end = 0.5 s",
    ),
    "output at the end": M(
        "position of right edge every 5 ms",
        "position of right edge at end",
        "TIS303",
        "at end",
        "write how often, such as: every 10 ms; a log has the end of the run, too",
    ),
    "duration until the end": M(
        "duration = 0.5 s;",
        "duration = 0.5 s at end;",
        "TIS303",
        "at end",
        'an entry ends with its value: remove "at end"',
    ),
    "simulate without a block": M(
        "simulate { duration = 0.5 s; tolerance = 1e-3 }",
        "simulate until 0.5 s",
        "TIS312",
        "simulate until 0.5 s",
        "write: simulate { duration = 1 s }",
    ),
    "name with of": M(
        "set floor =",
        "set base of wall = nodes of pad where z < 1 mm\nset floor =",
        "TIS115",
        "of",
        'write the name in quotes: "base of wall"',
    ),
    "joint to a name with of": M(
        "springs from lower side to pad",
        "springs from end of a to pad",
        "TIS115",
        "end of a",
        'write a name with "of" in quotes: "end of a"',
        ("TIS301",),
    ),
}
