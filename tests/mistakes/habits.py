# ruff: noqa: E501  # texts as they are
"""Mistakes from other languages, other units and other programs, in the same scene."""

from tests.mistakes import Mistake as M

MISTAKES = {
    "weight in pounds": M(
        "mass = 5 mg", "mass = 0.01 lb", "TIS104", "lb", 'write "4.535924 g"'
    ),
    "pressure in psi": M(
        "tissue own { described",
        "tissue own { Young's modulus = 2 psi; described",
        "TIS104",
        "psi",
        'write "13.78951 kPa"',
    ),
    "pressure in cmH2O": M(
        "tissue own { described",
        "tissue own { Young's modulus = 30 cmH2O; described",
        "TIS104",
        "cmH2O",
        'write "2.941995 kPa"',
    ),
    "force in grams-force": M(
        "breaking force = 1 N", "breaking force = 50 gf", "TIS104", "gf", 'write "490.3325 mN"'
    ),
    "force in kgf": M(
        "breaking force = 1 N",
        "breaking force = 0.1 kgf",
        "TIS104",
        "kgf",
        'write "980.665 mN"',
    ),
    "pressure in bar": M(
        "tissue own { described",
        "tissue own { Young's modulus = 0.05 bar; described",
        "TIS104",
        "bar",
        'write "5 kPa"',
    ),
    "mm Hg apart": M(
        "tissue own { described",
        "tissue own { Young's modulus = 40 mm Hg; described",
        "TIS104",
        "Hg",
        'write "mmHg"',
    ),
    "density per cc": M(
        "tissue own { described",
        "tissue own { density = 1.06 g/cc; described",
        "TIS104",
        "1.06 g/cc",
        'write "1060 kg/m^3"',
    ),
    "stiffness per inch": M(
        "spring constant = 40 N/m",
        "spring constant = 1 N/in",
        "TIS104",
        "1 N/in",
        'write "39.37008 N/m"',
    ),
    "duration in hours": M(
        "duration = 0.5 s", "duration = 0.001 h", "TIS104", "h", 'write "3.6 s"'
    ),
    "micron": M("radius = 4 mm", "radius = 4000 microns", "TIS104", "microns", 'write "4 mm"'),
    "units multiplied to a number": M(
        "radius = 4 mm", "radius = 4*mm", "TIS104", "4*mm", 'write "4 mm"'
    ),
    "unit in brackets": M(
        "radius = 4 mm", "radius = 4 [mm]", "TIS312", "4 [mm]", 'write "4 mm"'
    ),
    "degrees celsius sign": M(
        "param lift",
        "param warm = 37 °C\nparam lift",
        "TIS114",
        "°",
        "temperatures are not part of the language",
    ),
    "frequency in rpm": M(
        "using smooth profile\n  at 0.4",
        "using sine of 60 rpm\n  at 0.4",
        "TIS104",
        "rpm",
        'write "1 Hz"',
    ),
    "time with a name": M(
        "at 0.1 s: grasp", "at t = 0.1 s: grasp", "TIS312", "at t = ", 'write "at"'
    ),
    "assignment of the time": M(
        "at 0.1 s: grasp", "t = 0.1 s: grasp", "TIS312", "t = ", 'write "at"'
    ),
    "time without at": M(
        "at 0.1 s: grasp", "0.1 s: grasp", "TIS312", "0.1 s", 'write "at 0.1 s"'
    ),
    "between for an interval": M(
        "from 0.1 s to 0.3 s: move forceps",
        "between 0.1 s and 0.3 s: move forceps",
        "TIS312",
        "between 0.1 s and 0.3 s",
        'write "from 0.1 s to 0.3 s"',
    ),
    "until for to": M(
        "from 0.1 s to 0.3 s: move forceps",
        "from 0.1 s until 0.3 s: move forceps",
        "TIS403",
        "from 0.1 s until 0.3 s",
        'write "from 0.1 s to 0.3 s"',
    ),
    "dash for to": M(
        "from 0.1 s to 0.3 s: move forceps",
        "from 0.1 s - 0.3 s: move forceps",
        "TIS403",
        "from 0.1 s - 0.3 s",
        'write "from 0.1 s to 0.3 s"',
    ),
    "clamp for grasp": M(
        "at 0.1 s: grasp right edge with forceps A",
        "at 0.1 s: clamp right edge with forceps A",
        "TIS404",
        "clamp",
        'did you mean "grasp"?',
    ),
    "incise for cut": M(
        "0.4 s: cut", "0.4 s: incise", "TIS404", "incise", 'did you mean "cut"?'
    ),
    "if then in the script": M(
        "at 0.1 s: grasp right edge with forceps A",
        "if force(forceps A) > 1 N then release forceps A\n  at 0.1 s: grasp right edge with forceps A",
        "TIS312",
        "if force(forceps A) > 1 N then ",
        'write "when force(forceps A) > 1 N:"',
    ),
    "loop": M(
        "at 0.1 s: grasp right edge with forceps A",
        "for i in 1 to 5: fix floor\n  at 0.1 s: grasp right edge with forceps A",
        "TIS312",
        "for",
        'write "repeat i from 1 to 8 { … }"',
    ),
    "profile first": M(
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "from 0.1 s to 0.3 s: move forceps A using smooth profile by lift",
        "TIS312",
        "by lift",
        "its three components, for example: by (0, 0, lift)",
    ),
    "move by a number": M(
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "from 0.1 s to 0.3 s: move forceps A by lift using smooth profile",
        "TIS312",
        "by lift",
        "its three components, for example: by (0, 0, lift)",
    ),
    "move along a direction": M(
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "from 0.1 s to 0.3 s: move forceps A by lift along (0, 0, 1) using smooth profile",
        "TIS312",
        "by lift",
        "its three components, for example: by (0, 0, lift)",
    ),
    "move to for by": M(
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "from 0.1 s to 0.3 s: move forceps A to (0 mm, 0 mm, lift) using smooth profile",
        "TIS303",
        "to (0 mm, 0 mm, lift)",
        "for example: by (0, 0, 1) mm",
    ),
    "profile without using": M(
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) using smooth profile",
        "from 0.1 s to 0.3 s: move forceps A by (0 mm, 0 mm, lift) smoothly",
        "TIS312",
        " smoothly",
        'write "using smooth profile"',
    ),
    "grasp by a tool": M(
        "at 0.1 s: grasp right edge with forceps A",
        "at 0.1 s: grasp right edge by forceps A",
        "TIS304",
        "grasp right edge by forceps A",
        "write: grasp SET with TOOL",
    ),
    "cut with a line": M(
        "along plane through (20, 0, 0) mm facing (1, 0, 0)",
        "along (20, 0, 0) mm",
        "TIS312",
        "along (20, 0, 0) mm",
        "write: cut BODY along plane through POINT facing VECTOR with TOOL",
    ),
    "normal for facing": M(
        "facing (1, 0, 0)", "normal (1, 0, 0)", "TIS312", "normal", 'write "facing"'
    ),
    "comma for semicolon in an action": M(
        "fix left edge; fix floor", "fix left edge, fix floor", "TIS312", ",", 'write ";"'
    ),
    "and for semicolon in an action": M(
        "fix left edge; fix floor",
        "fix left edge and floor",
        "TIS312",
        "fix left edge and floor",
        'write "fix [left edge, floor]"',
    ),
    "wait": M(
        "at 0.1 s: grasp right edge with forceps A",
        "wait 0.1 s\n  at 0.1 s: grasp right edge with forceps A",
        "TIS312",
        "wait 0.1 s",
        "give the next action a later time: at T: …",
    ),
    "greater than in words": M(
        "x > 39 mm", "x is greater than 39 mm", "TIS312", " is greater than", 'write ">"'
    ),
    "above in words": M("x > 39 mm", "x above 39 mm", "TIS312", " above", 'write ">"'),
    "at least in words": M(
        "x > 39 mm", "x is at least 39 mm", "TIS312", " is at least", 'write ">="'
    ),
    "arrow for at least": M("x > 39 mm", "x => 39 mm", "TIS312", "=>", 'write ">="'),
    "not equal of SQL": M(
        "count(pieces of strip) == 2",
        "count(pieces of strip) <> 2",
        "TIS312",
        "<>",
        'write "!="',
    ),
    "power of a program": M(
        "let side = 40 mm", "let side = 2 ** 3", "TIS312", "**", 'write "^"'
    ),
    "all nodes": M(
        "nodes of strip where x > 39 mm",
        "all nodes of strip",
        "TIS312",
        "all nodes",
        'write "nodes"',
        ("W409",),
    ),
    "range with to": M(
        "where x > 39 mm",
        "where x from 39 mm to 41 mm",
        "TIS312",
        "nodes",
        "for example: nodes of BODY where x between 1 mm and 2 mm",
    ),
    "in range": M(
        "where x > 39 mm",
        "where x in [39 mm, 41 mm]",
        "TIS312",
        "x",
        'a condition compares numbers: "a < b" or "a between b and c"',
    ),
    "colon in a tissue": M(
        "hardness is soft;", "hardness: soft;", "TIS312", ":", 'write "hardness is soft"'
    ),
    "percent of a word": M(
        "hardness is soft;",
        "hardness is 80 % soft;",
        "TIS312",
        "80 % soft",
        'write the word with a hedge, such as "rather soft"',
    ),
    "vague hedge": M(
        "hardness is soft;",
        "hardness is a bit soft;",
        "TIS201",
        "a bit soft",
        "words for hardness: soft, medium, hard; hedges: very, extremely, marke",
    ),
    "two words with to": M(
        "hardness is soft;",
        "hardness is soft to medium;",
        "TIS312",
        "hardness is soft to medium",
        'write "between soft and medium"',
    ),
    "inherits with from": M(
        "tissue graft like own",
        "tissue graft from own",
        "TIS312",
        "from own",
        "write tissue graft like own",
    ),
    "extends": M(
        "tissue graft like own",
        "tissue graft extends own",
        "TIS312",
        "graft extends own",
        "write tissue graft like own",
    ),
    "rule with a number": M(
        "tissue graft",
        "rules more { if hardness is soft then density = 900 kg/m^3 }\ntissue graft",
        "TIS312",
        "= 900 kg/m^3",
        'write a word of its scale after "is"',
    ),
    "rule with arrow": M(
        "tissue graft",
        "rules more { if hardness is soft => density is low }\ntissue graft",
        "TIS312",
        "=>",
        'write "then"',
        ("W202",),
    ),
    "rule with a comma": M(
        "tissue graft",
        "rules more { if hardness is soft, weight is low then density is low }\ntissue graft",
        "TIS312",
        ",",
        'write "and"',
        ("W202",),
    ),
    "range with a colon": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm : 10 mm; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS312",
        " : ",
        'write "to"',
    ),
    "range with dots": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm .. 10 mm; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS312",
        " .. ",
        'write "to"',
    ),
    "values without brackets": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm, 5 mm, 10 mm; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS312",
        "2 mm, 5 mm, 10 mm",
        'write "[2 mm, 5 mm, 10 mm]"',
    ),
    "points for steps": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm to 10 mm in 5 points; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS312",
        "points",
        'write "steps"',
    ),
    "numpy range": M(
        "expect count(pieces",
        "study s { vary lift = linspace(2 mm, 10 mm, 5); measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS301",
        "linspace",
        "a range is for a study: vary NAME = 2 mm to 10 mm in 5 steps",
    ),
    "normal with plus minus": M(
        "expect count(pieces",
        "study s { vary lift = 5 mm ± 1 mm; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS114",
        "±",
        'a number has no tolerance: write "5 mm", and vary it in a study',
    ),
    "factor unknown": M(
        "expect count(pieces",
        "study s { vary height = 2 mm to 10 mm in 5 steps; measure pull = max(force of forceps A) }\nexpect count(pieces",
        "TIS505",
        "vary height",
        "params: lift",
    ),
    "measure peak": M(
        "expect count(pieces",
        "study s { vary lift = 2 mm to 10 mm in 5 steps; measure pull = peak force of forceps A }\nexpect count(pieces",
        "TIS701",
        "peak force",
        "for example: max(force(A))",
    ),
    "output with equals": M(
        "force of forceps A every 1 ms",
        "force of forceps A = every 1 ms",
        "TIS100",
        "=",
        'leave out "="',
    ),
    "output every without a unit": M(
        "force of forceps A every 1 ms",
        "force of forceps A every 1",
        "TIS501",
        "1",
        'write "1 s"',
        ("W405",),
    ),
    "output per second": M(
        "force of forceps A every 1 ms",
        "force of forceps A 1000 Hz",
        "TIS312",
        " 1000 Hz",
        "for example: force(A) every 1 ms",
    ),
    "output of two tools": M(
        "force of forceps A every 1 ms",
        "force of forceps A and probe every 1 ms",
        "TIS312",
        " and probe",
        "write an output of its own for each",
    ),
    "output with a comma": M(
        "force of forceps A every 1 ms",
        "force of forceps A, position of floor every 1 ms",
        "TIS107",
        ",",
        'put ";" between two sentences; several names are a list: [A, B]',
    ),
    "output displacement": M(
        "position of right edge",
        "displacement of right edge",
        "TIS701",
        "displacement",
        "outputs: trajectory, precision, compress, blocks, surface, energy, applied pressure",
    ),
    "direction without brackets": M(
        "force of forceps A every 1 ms",
        "force(forceps A along 0 0 1) every 1 ms",
        "TIS312",
        "0 0 1",
        'write "(0, 0, 1)"',
    ),
    "motion without by": M(
        "move forceps A by (0 mm, 0 mm, lift)",
        "move forceps A (0 mm, 0 mm, lift)",
        "TIS312",
        " ",
        'write "by" before the vector',
    ),
    "expect about": M(
        "> 1 mN at 0.3 s",
        "≈ 5 mN at 0.3 s",
        "TIS114",
        "≈",
        'write a range: "between 4 mN and 6 mN"',
    ),
    "expect at the end": M(
        "> 1 mN at 0.3 s", "> 1 mN at end", "TIS301", "end", "let end = 0.5 s (of exp"
    ),
    "expect always": M(
        "> 1 mN at 0.3 s", "< 1 N always", "TIS312", " always", 'write "over run"'
    ),
    "body radius": M(
        "thickness = 2 mm",
        "thickness = 2 mm; diameter = 5 mm",
        "TIS303",
        "diameter",
        "entries: mesh, made, tissue, region, springs, rupture, bending, fibres",
    ),
    "tool by size": M(
        "radius = 4 mm",
        "diameter = 8 mm",
        "TIS303",
        "diameter",
        "entries: radius, centre, axis",
    ),
    "tool position": M(
        "centre = (20, 10, 30) mm",
        "position = (20, 10, 30) mm",
        "TIS303",
        "position",
        "entries: radius, centre, axis",
    ),
    "gravity direction only": M(
        "gravity = (0, 0, -9.81) m/s^2",
        "gravity is down",
        "TIS312",
        "gravity is down",
        "for example: gravity = (0, 0, -9.81) m/s^2",
    ),
    "gravity off": M(
        "gravity = (0, 0, -9.81) m/s^2",
        "gravity is off",
        "TIS312",
        "gravity is off",
        "for example: gravity = (0, 0, 0) m/s^2",
    ),
    "contact true": M(
        "contact is tools only",
        "contact is true",
        "TIS305",
        "true",
        "choices: off, tools only, bodies too, everywhere",
    ),
    "duration alone": M(
        "simulate { duration = 0.5 s;",
        "simulate 0.5 s {",
        "TIS312",
        "simulate 0.5 s",
        "for example: simulate { duration = 1 s }",
    ),
    "time step": M(
        "tolerance = 1e-3",
        "dt = 1 ms",
        "TIS303",
        "dt",
        "entries: duration, integrator, tolerance, step",
    ),
    "percent tolerance": M(
        "tolerance = 1e-3", "tolerance = 0,1 %", "TIS108", ",", 'write "tolerance = 0.1 %"'
    ),
    "comment with percent": M(
        "body pad {", "% the fat\nbody pad {", "TIS312", "%", 'write "#"'
    ),
    "comment of html": M(
        "body pad {", "<!-- fat -->\nbody pad {", "TIS312", "<!--", 'write "#"'
    ),
    "comment with dashes": M(
        "body pad {", "-- the fat\nbody pad {", "TIS312", "--", 'write "#"'
    ),
    "include": M(
        'use "matter/fat"', 'include "matter/fat"', "TIS312", "include", 'write "use"'
    ),
    "import": M(
        'use "matter/fat"',
        "import matter.fat",
        "TIS312",
        "import",
        'for example: use "matter/fat"',
    ),
    "german quotes": M('use "matter/fat"', "use „matter/fat“", "TIS114", "„", 'type " instead'),
    "nbsp": M(
        "duration = 0.5 s", "duration = 0.5\xa0s", "TIS114", "\xa0", "type an ordinary blank"
    ),
    "semicolon at the block": M(
        "environment {",
        "environment; {",
        "TIS100",
        "{",
        'put "{" on the line of the name of its block',
    ),
    "equals before the block": M(
        "environment {", "environment = {", "TIS312", " =", 'leave out "="'
    ),
    "keyword body missing": M(
        "body pad {",
        "pad {",
        "TIS303",
        "pad",
        "parts: use, about, author, laboratory, licence, cite, hedge, property, quantity, rules, law, tissue, body",
    ),
    "tissue given twice": M(
        "tissue is fat\n",
        "tissue is fat; tissue is skin\n",
        "TIS307",
        "tissue is skin",
        "remove one of them",
    ),
}
