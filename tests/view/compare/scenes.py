"""Scenes to compare, whose motions are known in closed form."""

from math import sqrt

#: A mass on a spring, let go 1 mm beyond its rest: x = 10 mm + 1 mm cos(ω t).
OSCILLATOR = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 11 }
table springs of pair in mm with columns "a b rest length" { 1 2 10 }
set wall = nodes of pair where id == 1
set bob = nodes of pair where id == 2
environment { gravity = (0, 0, 0) m/s^2 }
script { at 0 s: fix wall }
simulate { duration = 0.3 s; tolerance = 1e-6 }
output { trajectory every 10 ms; position of bob every 1 ms; energy every 10 ms }
"""
AMPLITUDE = 1e-3  # [m]


def omega(constant: float) -> float:
    """Return the angular frequency for a spring constant [N/m]."""
    return sqrt(constant / 0.010)


#: Falls freely: positions are quadratic in time, which a cubic meets exactly.
FALLING = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 10 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 10 }
table springs of pair in mm with columns "a b" { 1 2 }
environment { gravity = (0, 0, -9.81) m/s^2 }
simulate { duration = 0.3 s; tolerance = 1e-9 }
output { trajectory every 10 ms }
"""

#: A chain whose springs stand in a table, and a sheet with a region.
TABLES = """language 1
tissue cord {
  spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g; breaking force = 2 N
}
tissue scar like cord { spring constant = 90 N/m }
body chain { mesh is explicit; tissue is cord; rupture is allowed }
table nodes of chain in mm with columns "id x" { 1 0; 2 10; 3 20; 4 30 }
table springs of chain with columns "a b" { 1 2; 2 3; 2 3; 3 4 }
body flap {
  mesh is sheet { corner = (0, 20, 0) mm; first edge = (20, 0, 0) mm
                  second edge = (0, 10, 0) mm; columns = 5; rows = 3; diagonals is none }
  tissue is cord; interface is softer
  region hard where x > 12 mm { tissue is scar }
}
environment { gravity = (0, 0, 0) m/s^2 }
simulate { duration = 1 ms }
output { trajectory every 1 ms }
"""

#: Springs in a row, of which two break one after the other.
TEARING = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 0 N*s/m; mass = 1 g }
body row { mesh is explicit; tissue is cord; rupture is allowed }
table nodes of row in mm with columns "id x" { 1 0; 2 10; 3 20 }
table springs of row with columns "a b breaking force in mN" { 1 2 40; 1 2 60; 2 3 900 }
set tip = nodes of row where id == 2
set wall = nodes of row where id == 1
environment { gravity = (0, 0, 0) m/s^2; damping = 1 N*s/m }
script { at 0 s: fix wall; from 0 s to 0.1 s: move tip by (2, 0, 0) mm using constant speed }
simulate { duration = 0.1 s }
output { trajectory every 10 ms }
"""
