"""Make the data of the examples: what runs and formulas with known numbers say, and noise.

    python docs/examples/learning/make_data.py

writes the tables beside this file.
"""

from pathlib import Path

import numpy as np

import tissuec

HERE = Path(__file__).resolve().parent
BAND = {"modulus": "20 kPa", "retardation": "1.2 ms", "weight": "1100 kg/m^3"}
# The words that experts meant, in the place of those of gel.tis.
EVENLY = "evenly = [low, medium, high]"
MEANT = """low = trapezoid(2 N/m, 2 N/m, 5 N/m, 32 N/m)
  medium = triangle(5 N/m, 32 N/m, 120 N/m)
  high = trapezoid(32 N/m, 120 N/m, 200 N/m, 200 N/m)"""


def main() -> None:
    """Write everything."""
    band("pulled.csv", "6 mm", seed=1)
    band("pulled_less.csv", "4 mm", seed=2)
    gels("gels.csv", "5 mN", seed=3)
    gels("gels_pulled_more.csv", "10 mN", seed=4)
    tendon("stretch.csv", seed=5)
    cart("cart.csv", seed=6)


def band(name: str, stretch: str, seed: int) -> None:
    """Force to 0.5 mN, as long as the tip is held, and place of a spot to 20 um."""
    noise = np.random.default_rng(seed)
    run = tissuec.run(HERE / "band.tis", stretch=stretch, **BAND)
    force, spot = run.logs["force of tip"], run.logs["position of spot"]
    force_mN = 1e3 * force.value[:, 0] + 0.5 * noise.standard_normal(len(force.time))
    x_mm = 1e3 * spot.value[:, 0] + 0.02 * noise.standard_normal(len(spot.time))
    rows = zip(force.time, force_mN, x_mm, strict=True)
    lines = [f"{t:.3f},{f'{f:.2f}' if t < 0.15 else ''},{x:.3f}" for t, f, x in rows]
    write(name, "t_s,force_mN,x_mm", lines)


def gels(name: str, pull: str, seed: int) -> None:
    """The places of the ends of all strips, to 2 um."""
    noise = np.random.default_rng(seed)
    _, vocabulary = (HERE / "gel.tis").read_text(encoding="utf-8").split("\n\n", 1)
    scene = (HERE / "gels.tis").read_text(encoding="utf-8")
    text = scene.replace('use "./gel"\n', vocabulary.replace(EVENLY, MEANT))
    run = tissuec.run(text, pull=pull)
    logs = [run.logs[f"position of end {k}"] for k in "abcde"]
    places = 1e3 * np.stack([log.value[:, 0] for log in logs], axis=1)
    places += 0.002 * noise.standard_normal(places.shape)
    rows = zip(logs[0].time, places, strict=True)
    lines = [",".join([f"{t:.2f}", *(f"{x:.4f}" for x in row)]) for t, row in rows]
    write(name, "t_s,a_mm,b_mm,c_mm,d_mm,e_mm", lines)


def tendon(name: str, seed: int) -> None:
    """Four springs in a row, which share what they are drawn out by; forces to 2 mN."""
    constant, stiffening, count, length = 60.0, 9.0, 4, 0.01
    noise = np.random.default_rng(seed)
    way = np.linspace(1e-3, 12e-3, 12)
    strain = way / (count * length)
    force = constant * length / stiffening * np.expm1(stiffening * strain)
    force += 2e-3 * noise.standard_normal(len(way))
    rows = zip(1e3 * way, 1e3 * force, strict=True)
    write(name, "u_mm,force_mN", [f"{u:.0f},{f:.1f}" for u, f in rows])


def cart(name: str, seed: int) -> None:
    """Place of a cart in whole pixels, as a camera of 29.97 Hz sees it; tracked to 0.2 px.

    x'' = -(2 c x + 2 d x') / m has the solution exp(-δ t) (x0 cos ω t + (v0 + δ x0)/ω sin ω t).
    """
    constant, viscosity, mass, start, speed, zero = 3.0, 8e-3, 1.0, -0.18, 0.02, 80.0
    noise = np.random.default_rng(seed)
    time = np.round(np.arange(1, 871) / 29.97, 3)
    decay = viscosity / mass
    omega = np.sqrt(2.0 * constant / mass - decay**2)
    sine, cosine = np.sin(omega * time), np.cos(omega * time)
    swing = start * cosine + (speed + decay * start) / omega * sine
    place = 1e3 * np.exp(-decay * time) * swing + zero + 0.2 * noise.standard_normal(len(time))
    write(name, "t_s,x_px", [f"{t:.3f},{x:.0f}" for t, x in zip(time, place, strict=True)])


def write(name: str, head: str, lines: list[str]) -> None:
    """Write a table."""
    (HERE / name).write_text("\n".join([head, *lines]) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
