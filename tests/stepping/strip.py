"""A strip that forceps pull at one end, for controllers."""

#: Held at its left end; forceps have grasped the right one, and move when they are told to.
STRIP = """language 1
tissue soft {
  spring constant = 2 N/m; viscosity = 20 mN*s/m; mass = 0.1 g; breaking force = 40 mN
}
body strip {
  mesh is sheet {
    corner = (0, 0, 0) mm; first edge = (20, 0, 0) mm; second edge = (0, 10, 0) mm
    columns = 5; rows = 3; diagonals is both
  }
  tissue is soft
  rupture is allowed
}
set left edge = nodes of strip where x < 1 mm
set right edge = nodes of strip where x > 19 mm
tool tongs { kind is forceps }
environment { gravity = (0, 0, 0) m/s^2 }
script {
  at 0 s: fix left edge
  at 0 s: grasp right edge with tongs
}
simulate { duration = 1 s; tolerance = 1e-4 }
output { trajectory every 100 ms }
"""
