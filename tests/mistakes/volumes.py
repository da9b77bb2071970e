"""Mistakes with preserved volumes, ``force`` blocks and braces on one line."""

from tests.mistakes import Mistake as M

SCENE = """language 1
param lift = 2 mm between 0 mm and 5 mm
tissue gum { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 10 mg }
tissue wide gum like gum { mass = 20 mg }
body bag { mesh is sphere { centre = (0, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is gum }
body can { mesh is sphere { centre = (50, 0, 0) mm; radius = 10 mm; subdivisions = 1 }
  tissue is wide gum }
body flap {
  mesh is sheet {
    corner = (0, 0, 20) mm; first edge = (9, 0, 0) mm; second edge = (0, 9, 0) mm
    rows = 4; columns = 4; diagonals is both
  }
  tissue is gum
}
set low = nodes of bag where z < -5 mm
set rim = nodes of flap where y < 1 mm
force bed { kind is foundation; acts on low; stiffness = 200 kPa/m }
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: preserve volume of bag with 10 kPa
  from 0.1 s to 0.2 s: inflate bag to 5 ml using smooth profile
  from 0.1 s to 0.2 s: move rim by (0 mm, 0 mm, lift) using smooth profile
}
simulate { duration = 0.3 s }
output { volume of bag every 10 ms }
expect volume(bag) between 4 ml and 6 ml at 0.3 s
"""

MISTAKES = {
    "volume as a length": M("to 5 ml", "to 5 mm", "TIS502", "5 mm", "such as 5 ml"),
    "volume as a force": M("to 5 ml", "to 5 N", "TIS502", "5 N", "such as 5 ml"),
    "volume without a unit": M("to 5 ml", "to 5", "TIS501", "5", '"5 ml"'),
    "volume below zero": M("to 5 ml", "to -5 ml", "TIS308", "-5 ml", '"5 ml"'),
    "volume of zero": M("to 5 ml", "to 0 ml", "TIS308", "0 ml", "for example: to 5 ml"),
    "pressure below zero": M(
        "with 10 kPa", "with -10 kPa", "TIS308", "-10 kPa", '"10 kPa"'
    ),
    "pressure of zero": M(
        "with 10 kPa", "with 0 Pa", "TIS308", "0 Pa", "for example: with 10 kPa"
    ),
    "pressure by another word": M(
        "with 10 kPa", "with soft pressure", "TIS305", "soft pressure", "gentle pressure, firm"
    ),
    "body instead of its volume": M(
        "preserve volume of bag", "preserve bag", "TIS312", "preserve bag with 10 kPa",
        "write preserve volume of bag",
    ),
    "volumes of two bodies": M(
        "volume of bag with 10 kPa", "volume of [bag, can] with 10 kPa", "TIS312",
        "[bag, can]",
        "preserve volume of bag with 10 kPa; preserve volume of can with 10 kPa",
    ),
    "two bodies inflated": M(
        "inflate bag to", "inflate [bag, can] to", "TIS312", "[bag, can]",
        "inflate bag to 5 ml using smooth profile; inflate can to 5 ml using smooth profile",
    ),
    "volume of a sheet": M(
        ("with 10 kPa", "preserve volume"),
        ("with 10 kPa\n  at 0 s: preserve volume of flap with 10 kPa", "preserve volume"),
        "TIS309", "preserve volume of flap with 10 kPa",
        "bodies whose volume can be preserved: bag, can",
    ),
    "limits of an expectation reversed": M(
        "between 4 ml and 6 ml", "between 6 ml and 4 ml", "TIS308", "6 ml",
        '"between 4 ml and 6 ml"',
    ),
    "force without its number": M(
        "; stiffness = 200 kPa/m", "", "TIS304", "force bed", "stiffness = 20 kPa/m"
    ),
    "force on nothing": M("acts on low; ", "", "TIS304", "force bed", "acts on low"),
    "force with on alone": M("acts on low", "on low", "TIS312", "on", '"acts on"'),
    "brace of a tissue missing": M(
        "tissue gum {", "tissue gum", "TIS101", "tissue gum", "tissue gum {"
    ),
    "brace of a tissue with two words missing": M(
        "tissue wide gum like gum {", "tissue wide gum like gum", "TIS101",
        "tissue wide gum like gum", "tissue wide gum like gum {",
    ),
    "brace of a force missing": M(
        "force bed {", "force bed", "TIS101", "force bed", "force bed {"
    ),
    "brace of a single block missing": M(
        "simulate {", "simulate", "TIS101", "simulate", "simulate {"
    ),
}  # fmt: skip
