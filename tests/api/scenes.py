"""Small scenes as texts, and what is known of them."""

#: A mass at the end of a spring, which is stretched along a known profile and then breaks.
PULL = """language 1
param pull = 1 mm between 0 mm and 2 mm
param stretch time = 0.1 s
param way = (1, 0, 0)
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }
body pair { mesh is explicit; tissue is cord; rupture is not allowed }
table nodes of pair in mm with columns "id x" { 4 0; 7 10; 9 20 }
table springs of pair in mm with columns "a b rest length" { 4 7 10; 7 9 10 }
set wall = nodes of pair where id == 4
set bob = nodes of pair where id == 9
set far spring = springs of pair where x > 12 mm
environment { gravity = (0, 0, 0) m/s^2; damping = 0.2 N*s/m }
script {
  at 0 s: fix wall
  from 0 s to stretch time: move bob by pull * way using smooth profile
  at 0.15 s: cut far spring
}
simulate { duration = 0.2 s }
output { trajectory every 10 ms; position of bob every 1 ms; energy every 50 ms }
expect position(bob along (1, 0, 0)) between 20.999 mm and 21.001 mm at 0.12 s
"""

#: It cannot go on: nothing holds what is told to settle.
FLYING = """language 1
tissue cord { spring constant = 40 N/m; viscosity = 10 mN*s/m; mass = 5 g }
body pair { mesh is explicit; tissue is cord }
table nodes of pair in mm with columns "id x" { 1 0; 2 10 }
table springs of pair in mm with columns "a b rest length" { 1 2 10 }
environment { gravity = (0, 0, -9.81) m/s^2 }
script { at 0.1 s: settle pair }
expect speed(pair) >= 0 m/s over run
simulate { duration = 0.2 s }
output { trajectory every 10 ms }
"""
