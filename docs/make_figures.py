"""Draw the figures of the documentation from runs of shipped scenes.

    python docs/make_figures.py

needs matplotlib (``pip install "tissuec[plot]"``) and takes about a minute. Nothing in the
pictures is drawn by hand: nets, forces and pressures are read from the result files of
``sterilisation.tis``, ``bladder.tis``, ``liver.tis``, ``palpation.tis``, ``ligature.tis``,
``tubal_ligation.tis``, ``artery.tis`` and ``suture.tis`` in ``library/scenes`` and of
``stroke.tis`` in the pages of the language, words from ``library/fuzzy/soft_tissue.tis``, laws
from their formulas, and what springs remember from runs of a single spring.
"""

import tempfile
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.colors import Normalize
from PIL import Image

from tissuec.core import palette
from tissuec.core.resources import library
from tissuec.core.scale import AxisUnit
from tissuec.core.source import Source
from tissuec.laws import SPRING_LAWS, VISCOSITY_LAWS
from tissuec.pipeline import compile_request, simulate
from tissuec.results.trajectory import Trajectory
from tissuec.scene.request import Request
from tissuec.view import plots
from tissuec.view.plots.axes import clusters, mark_events
from tissuec.view.plots.curves import look
from tissuec.view.plots.net import draw_skin, draw_springs, tension_colours
from tissuec.view.plots.page import STYLES
from tissuec.view.plots.projection import Projection

FIGURES = Path(__file__).resolve().parent / "figures"
BLUE, RED, GREEN = palette.SERIES[:3]
TENSION = tension_colours()
BESIDE = Projection(
    -100.0, 10.0
)  # from the front, turned a little, so that rings are seen as rings
ABOVE = Projection(-110.8, 21.7)
COLOURS = 256  # of a picture, as many as a palette holds
MOMENTS = (
    (0.0, "0 s: as drawn, under 2 % prestress"),
    (0.6, "0.6 s: grasped and lifted by 6 mm"),
    (1.2, "1.2 s: cut; the loose ends have drawn back"),
)


def main() -> None:
    """Run the scene, draw every figure, and say where they are."""
    FIGURES.mkdir(exist_ok=True)
    plt.rcParams.update(STYLES["screen"].settings)
    with tempfile.TemporaryDirectory() as folder:
        smoothed = "surface of oviduct every 40 ms { subdivisions = 3 }"
        with shipped("sterilisation", folder, output=smoothed) as trajectory:
            save(overview(trajectory), "sterilisation.png")
            save(smooth(trajectory), "surface.png")
        for draw in (artery, bladder, liver, ligature, tubal_ligation, suture):
            with shipped(draw.__name__, folder) as trajectory:
                save(draw(trajectory), f"{draw.__name__}.png")
        stroke = run(on_page("stroke.tis", Path(folder)), Path(folder) / "stroke.vtkhdf")
        with shipped("palpation", folder) as pressed, Trajectory.open(stroke) as stroked:
            save(contact(pressed, stroked), "contact.png")
        save(memory(Path(folder)), "memory.png")
    save(laws(), "laws.png")
    save(words(), "words.png")


def shipped(name: str, folder: str, *, output: str = "") -> Trajectory:
    """Return the result of a scene of the library, with another output."""
    target = Path(folder) / f"{name}.vtkhdf"
    return Trajectory.open(run(library() / "scenes" / f"{name}.tis", target, output=output))


def run(scene: Path, target: Path, *, output: str = "") -> Path:
    """Return the result file of a scene, with another output."""
    text = scene.read_text(encoding="utf-8").replace("output {", f"output {{\n  {output}", 1)
    request = Request(Source(scene.name, text, scene))
    compiled, _ = compile_request(request)
    return simulate(compiled, target, request=request).path


def on_page(name: str, folder: Path) -> Path:
    """Return a file with a scene that a page of the language shows."""
    pages = sorted((FIGURES.parent / "language").glob("*.md"))
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    text = text.split(f"```tis {name}\n")[1].split("```")[0]
    (folder / name).write_text(text, encoding="utf-8")
    return folder / name


def overview(trajectory: Trajectory) -> plt.Figure:
    """Return the net at three moments above the force on the forceps and the gap."""
    figure = plt.figure(figsize=(8.8, 5.3), layout="constrained")
    left, right = figure.subfigures(1, 2, width_ratios=[1.55, 1])
    frames = [int(np.abs(trajectory.times - time).argmin()) for time, _ in MOMENTS]
    largest = 1e3 * max(
        np.percentile(np.abs(trajectory.spring_force(frame)[0]), 99) for frame in frames
    )
    norm = Normalize(-largest, largest)
    nets = left.subplots(3, 1)
    for axes, frame, (_, title) in zip(nets, frames, MOMENTS, strict=True):
        draw_net(axes, trajectory, frame, norm)
        axes.set_title(title, loc="left", fontsize=9, y=0.9)
    colours = plt.cm.ScalarMappable(norm=norm, cmap=TENSION)
    bar = left.colorbar(
        colours, ax=nets, location="bottom", pad=0.0, aspect=35, fraction=0.03, shrink=0.8
    )
    bar.set_label("tension of the springs [mN]; negative: pressed")
    upper, lower = right.subplots(2, 1)
    draw_force(upper, trajectory)
    draw_gap(lower, trajectory)
    return figure


def draw_net(axes: plt.Axes, trajectory: Trajectory, frame: int, norm: Normalize) -> None:
    """Draw every spring from the side."""
    position = 1e3 * trajectory.position[frame]
    tension, springs = trajectory.spring_force(frame)
    ends = position[trajectory.ends[springs]]
    draw_springs(axes, ends, BESIDE, colours=tension_colours()(norm(1e3 * tension)))
    axes.set(xlim=(-2, 64), ylim=(-14.0, 12.0), aspect="equal")
    axes.axis("off")


def draw_force(axes: plt.Axes, trajectory: Trajectory) -> None:
    """Draw what the forceps feel."""
    log = trajectory.logs["force of forceps A"]
    axes.plot(log.time, 1e3 * log.value[:, 0], color=BLUE, lw=1, label="along tube")
    axes.plot(log.time, 1e3 * log.value[:, 2], color=RED, lw=1, label="upwards")
    axes.set(xlabel="time [s]", ylabel="force on the forceps [mN]", xlim=(0, 2))
    mark(axes, trajectory)
    axes.legend(
        frameon=False, fontsize=8, loc="center", bbox_to_anchor=(0.54, 0.5), handlelength=1
    )


def draw_gap(axes: plt.Axes, trajectory: Trajectory) -> None:
    """Draw how far the two stumps are apart."""
    log = trajectory.logs["gap of oviduct"]
    axes.plot(log.time, 1e3 * log.value[:, 0], color=GREEN, lw=1.2)
    axes.set(xlabel="time [s]", ylabel="gap between the stumps [mm]", xlim=(0, 2))
    mark(axes, trajectory)


def mark(axes: plt.Axes, trajectory: Trajectory) -> None:
    """Mark what happened."""
    kept = [event for event in trajectory.events if event.kind in ("grasp", "cut", "release")]
    mark_events([axes], clusters(kept, (0.0, 2.0)), AxisUnit(0, "s"))


def smooth(trajectory: Trajectory) -> plt.Figure:
    """Return the coarse skin beside the smooth surface, lifted and cut."""
    series = trajectory.surfaces["oviduct"]
    figure, rows = plt.subplots(2, 2, figsize=(8.8, 4.6), layout="constrained")
    for axes, (time, title) in zip(rows, MOMENTS[1:], strict=True):
        frame = int(np.abs(trajectory.times - time).argmin())
        net = trajectory.position[frame], trajectory.cells(frame).triangles
        show_skin(axes[0], *net, edges=True)
        axes[0].set_title(title, loc="left", fontsize=9)
        frame = int(np.abs(series.times - time).argmin())
        show_skin(axes[1], series.position(frame), series.triangles(frame), edges=False)
    return figure


def show_skin(
    axes: plt.Axes, position: np.ndarray, triangles: np.ndarray, *, edges: bool
) -> None:
    """Draw a skin in the light of a lamp."""
    place = 1e3 * position - [32.0, 0.0, 0.0]  # from the middle, in mm
    draw_skin(axes, place, triangles, ABOVE, rims=edges)
    axes.set(xlim=(-19, 19), ylim=(-13, 8.5), aspect="equal")
    axes.axis("off")


def laws() -> plt.Figure:
    """Return the forces of the laws against elongation and speed, by their own formulas."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
    strain = np.linspace(-0.1, 0.25, 701)
    values = {"c": np.float64(1.0), "rest": np.float64(1.0), "e": strain}
    chosen: tuple[tuple[str, dict[str, Any]], ...] = (
        ("linear", {}),
        ("exponential", {"stiffening": 8.0}),
        ("toe", {"strain": 0.1}),
        ("tension only", {}),
        ("dead band", {"slack": 0.05}),
        ("curve", {"elongations": (-0.1, 0.0, 0.1, 0.2), "forces": (-0.05, 0.0, 0.15, 0.17)}),
    )
    for number, (name, entries) in enumerate(chosen):
        force = SPRING_LAWS[name](**entries).force().at(values)
        left.plot(100.0 * strain, force, label=name, **look(number))
    left.set(xlabel="elongation in % of the rest length", ylabel="force over c L0")
    left.legend(frameon=False)
    speed = np.linspace(-2.0, 2.0, 401)
    for number, exponent in enumerate((0.5, 1.0, 2.0)):
        law = VISCOSITY_LAWS["power"](exponent=exponent, speed=1.0).force()
        force = law.at({"d": np.float64(1.0), "w": speed})
        right.plot(speed, force, label=f"power, exponent {exponent:g}", **look(number))
    right.set(xlabel="speed over v", ylabel="force over d v")
    right.legend(frameon=False)
    return figure


#: A spring of 20 mm between a wall and a hand, which draws it in some way.
SPRING = """language 1
tissue putty {{ spring constant = 100 N/m; mass = 5 g; {tissue} }}
body strip {{ mesh is explicit; tissue is putty }}
table nodes of strip in mm with columns "id x" {{ 1 0; 2 20 }}
table springs of strip with columns "a b" {{ 1 2 }}
set wall = nodes of strip in [1]
set hand = nodes of strip in [2]
environment {{ gravity = (0, 0, 0) m/s^2 }}
script {{ at 0 s: fix wall; {script} }}
simulate {{ duration = 2 s; tolerance = 1e-6 }}
output {{ tension(strip) every 2 ms; length(strip) every 2 ms }}
"""
HOLD = "from 0 s to 0.1 s: move hand by (4, 0, 0) mm using constant speed"
SWING = "from 0 s to 2 s: move hand by (4, 0, 0) mm using sine of 1 Hz"
RELAXING = "viscosity = 0 N*s/m; relaxing constant = 150 N/m; relaxation time = 0.16 s"
SERIES = (
    "viscosity = 0 N*s/m; relaxing constant = 75 N/m; relaxation time = 20 ms; "
    "second relaxing constant = 75 N/m; second relaxation time = 0.8 s"
)
YIELDING = "viscosity = 0 N*s/m; yield force = 0.2 N; yield viscosity = 1 N*s/m"


def memory(folder: Path) -> plt.Figure:
    """Return how the force of a spring relaxes, and the loops that it goes through."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
    held = (
        ("viscosity alone, 3 N s/m", "viscosity = 3 N*s/m", GREEN),
        ("one branch, 0.16 s", RELAXING, BLUE),
        ("two branches, 20 ms and 0.8 s", SERIES, RED),
    )
    for name, tissue, colour in held:
        time, force, _ = drawn(folder, tissue, HOLD)
        left.plot(time, 1e3 * force, color=colour, label=name)
    left.set(xlabel="time in s", ylabel="force in mN", xlim=(0.0, 1.5))
    left.set_title("drawn by 4 mm in 0.1 s, then held", fontsize=9)
    left.legend(frameon=False)
    for name, tissue, colour in (
        ("one branch, 0.16 s", RELAXING, BLUE),
        ("yield force 200 mN", YIELDING, RED),
    ):
        _, force, length = drawn(folder, tissue, SWING)
        right.plot(1e3 * (length - 0.02), 1e3 * force, color=colour, label=name)
    right.set(xlabel="elongation in mm", ylabel="force in mN")
    right.set_title("drawn and pressed once a second", fontsize=9)
    right.legend(frameon=False, loc="upper left")
    return figure


def drawn(folder: Path, tissue: str, script: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return times [s], forces [N] and lengths [m] of a spring that is drawn."""
    text = SPRING.format(tissue=tissue, script=script)
    request = Request(Source("spring.tis", text))
    compiled, _ = compile_request(request)
    path = simulate(compiled, folder / "spring.vtkhdf", request=request).path
    with Trajectory.open(path) as trajectory:
        force, length = (trajectory.logs[f"{name} of strip"] for name in ("tension", "length"))
        return force.time[:], force.value[:, 0], length.value[:, 0]


def bladder(trajectory: Trajectory) -> plt.Figure:
    """Return volume, pressure and the wall at three times."""
    figure = plt.figure(figsize=(8.0, 3.2), layout="constrained")
    grid = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.0))
    axes = figure.add_subplot(grid[0])
    for name, scale, unit, colour in (
        ("volume", 1e6, "ml", BLUE), ("pressure", 1e-3, "kPa", RED),
    ):  # fmt: skip
        log = trajectory.logs[f"{name} of bladder"]
        axes.plot(log.time, scale * log.value[:, 0], color=colour)
        axes.set(xlabel="time in s")
        axes.set_ylabel(f"{name} in {unit}", color=colour)
        if name == "volume":
            axes = axes.twinx()
            axes.grid(visible=False)
    wall = figure.add_subplot(grid[1], aspect="equal")
    ends = trajectory.network.springs.ends
    moments = (
        (0.0, GREEN, "drawn"),
        (0.39, RED, "filled"),
        (0.41, BLUE, "10 ms after the cut"),
    )
    for time, colour, label in moments:
        frame = int(np.argmin(np.abs(trajectory.times - time)))
        place = 1e3 * trajectory.position[frame]
        near = np.abs(place[:, 1]) < 12.0
        alive = near[ends].all(axis=1)
        lines = place[ends[alive]][:, :, [0, 2]]
        wall.add_collection(
            LineCollection(list(lines), colors=colour, linewidths=0.8, label=label)
        )
    wall.autoscale()
    wall.set(xlabel="x in mm", ylabel="z in mm")
    wall.legend(frameon=False, loc="center")
    return figure


def artery(trajectory: Trajectory) -> plt.Figure:
    """Return pressure against diameter with the measured widening, and a heart beat."""
    figure, (curve, beat) = plt.subplots(1, 2, figsize=(8.0, 3.2), layout="constrained")
    log = trajectory.logs["position of lumen"]
    time, wide = log.time, 2e3 * log.value[:, 0]
    rise = time <= 1.0
    rest = float(np.interp(0.625, time, wide))
    curve.plot(wide[rise], 16.0 * time[rise], color=BLUE, label="artery")
    curve.plot([rest] * 2, [10.0, 16.0], color=GREEN, linestyle=":", label="10 to 16 kPa")
    curve.plot([1.05 * rest, 1.14 * rest], [16.0] * 2, color=RED, label="measured at 16 kPa")
    curve.set(xlabel="inner diameter in mm", ylabel="pressure in kPa")
    curve.legend(frameon=False, loc="lower right")
    late = time >= 1.15
    beat.plot(time[late], wide[late], color=BLUE)
    beat.set(xlabel="time in s", ylabel="inner diameter in mm")
    return figure


def liver(trajectory: Trajectory) -> plt.Figure:
    """Return a slice of the filled surface as drawn and as lifted, by tension."""
    figure, rows = plt.subplots(2, figsize=(8.0, 4.6), layout="constrained", sharex=True)
    ends = trajectory.network.springs.ends
    near = np.abs(trajectory.position[0][:, 1]) < 0.013
    shown = np.flatnonzero(near[ends].all(axis=1))
    norm = Normalize(-0.02, 0.02)
    for axes, time in zip(rows, (0.0, 0.58), strict=True):
        frame = int(np.argmin(np.abs(trajectory.times - time)))
        force, springs = trajectory.spring_force(frame)
        tension = np.zeros(len(ends))
        tension[springs] = force
        lines = 1e3 * trajectory.position[frame][ends[shown]][:, :, [0, 2]]
        collection = LineCollection(list(lines), cmap=TENSION, norm=norm, linewidths=0.8)
        collection.set_array(tension[shown])
        axes.add_collection(collection)
        axes.set(aspect="equal", ylabel="z in mm")
        axes.set_title(f"{time:g} s", loc="left")
        axes.autoscale()
    rows[1].set_xlabel("x in mm")
    figure.colorbar(collection, ax=rows, label="tension in N", shrink=0.7)
    return figure


def ligature(trajectory: Trajectory) -> plt.Figure:
    """Return a tube and its sling from the side at three moments."""
    moments = {
        0.0: "0 s",
        0.5: "0.5 s: drawn in and tied",
        0.8: "0.8 s: cut beside the ligature",
    }
    return ligated(trajectory, moments, width=27.0, height=(-4.6, 7.6))


def tubal_ligation(trajectory: Trajectory) -> plt.Figure:
    """Return a tube and two slings from the side at three moments."""
    moments = {
        0.1: "0.1 s: two slings around the tube",
        0.66: "0.66 s: drawn in and tied",
        1.34: "1.34 s: cut, lifted; the right sling, drawn in further, has slipped",
    }
    return ligated(trajectory, moments, width=65.0, height=(-4.6, 8.6))


def ligated(
    trajectory: Trajectory,
    moments: dict[float, str],
    *,
    width: float,
    height: tuple[float, float],
) -> plt.Figure:
    """Return a tube, the first body, and slings from the side at three moments."""
    figure, rows = plt.subplots(3, figsize=(7.0, 5.4), layout="constrained", sharex=True)
    tube = trajectory.network.bodies[0].springs.stop
    for axes, (time, title) in zip(rows, moments.items(), strict=True):
        frame = int(np.argmin(np.abs(trajectory.times - time)))
        cells = trajectory.cells(frame)
        ends = 1e3 * trajectory.position[frame][cells.lines][:, :, [0, 2]]
        is_tube = cells.line_numbers < tube
        nearer = trajectory.position[frame][cells.lines][:, :, 1].mean(axis=1) < 1e-4
        for some, style in (
            (is_tube & ~nearer, {"colors": "#e8c4bd", "linewidths": 0.7}),
            (is_tube & nearer, {"colors": "#b5523f", "linewidths": 0.8}),
            (~is_tube, {"colors": BLUE, "linewidths": 4.0, "capstyle": "round", "alpha": 0.8}),
        ):
            axes.add_collection(LineCollection(list(ends[some]), **style))
        axes.set(aspect="equal", ylabel="z in mm", xlim=(-1, width), ylim=height)
        axes.set_title(title, loc="left", fontsize=9)
    rows[-1].set_xlabel("x in mm")
    return figure


def suture(trajectory: Trajectory) -> plt.Figure:
    """Return two sheets and the stitches between them from above at three moments."""
    figure, columns = plt.subplots(1, 3, figsize=(8.8, 2.4), layout="constrained", sharey=True)
    titles = ("0 s", "0.4 s: two stitches drawn in", "1.2 s: tied and pulled")
    sheets = trajectory.network.joints[0].springs.start
    for axes, time, title in zip(columns, (0.0, 0.4, 1.2), titles, strict=True):
        frame = int(np.argmin(np.abs(trajectory.times - time)))
        cells = trajectory.cells(frame)
        ends = 1e3 * trajectory.position[frame][cells.lines][:, :, [0, 1]]
        is_sheet = cells.line_numbers < sheets
        axes.add_collection(
            LineCollection(list(ends[is_sheet]), colors="#b5523f", linewidths=0.6)
        )
        axes.add_collection(
            LineCollection(list(ends[~is_sheet]), colors=BLUE, linewidths=3.0, capstyle="round")
        )
        axes.set(aspect="equal", xlabel="x in mm", xlim=(-19, 21), ylim=(-1, 17))
        axes.set_title(title, loc="left", fontsize=9)
    columns[0].set_ylabel("y in mm")
    return figure


def contact(pressed: Trajectory, stroked: Trajectory) -> plt.Figure:
    """Return a pressed net, force against indentation, and force against a stroke."""
    figure = plt.figure(figsize=(8.8, 3.0), layout="constrained")
    net, depth, way = figure.subplots(1, 3, width_ratios=[1.25, 1.0, 1.0])
    frame = int(np.abs(pressed.times - 0.7).argmin())
    place, ends = 1e3 * pressed.position[frame], pressed.ends
    near = np.abs(1e3 * pressed.position[0][:, 1] - 10.0) < 0.1
    shown = near[ends].all(axis=1)
    hard = pressed.network.springs.stiffness > 400.0
    for chosen, colour in ((shown & ~hard, "#c9a58b"), (shown & hard, RED)):
        lines = list(place[ends[chosen]][:, :, [0, 2]])
        net.add_collection(LineCollection(lines, colors=colour, linewidths=1.0))
    log = pressed.logs["position of finger"]
    x, _, z = 1e3 * log.value[np.abs(log.time - pressed.times[frame]).argmin()]
    net.add_patch(plt.Circle((x, z), 8.0, color=BLUE, alpha=0.25, lw=0))
    net.set(aspect="equal", xlabel="x [mm]", ylabel="z [mm]", xlim=(-1, 51), ylim=(-1, 32))
    draw_indentation(depth, pressed)
    draw_stroke(way, stroked)
    return figure


def draw_indentation(axes: plt.Axes, trajectory: Trajectory) -> None:
    """Draw the force on the finger against its depth, at each of its places."""
    force, place = (trajectory.logs[f"{name} of finger"] for name in ("force", "position"))
    every = np.searchsorted(force.time, place.time - 1e-6)
    for count in range(5):
        during = (place.time >= 0.3 * count) & (place.time < 0.3 * count + 0.2)
        deep = 1e3 * (0.023 - place.value[during, 2])
        x = 1e3 * place.value[during][0, 0]
        felt = -force.value[every[during], 2]
        beside = abs(x - 25.0)
        colour = RED if beside < 1.0 else GREEN if beside < 6.0 else BLUE
        style = "--" if x > 26.0 else "-"
        axes.plot(deep, felt, style, color=colour, lw=1.2, label=f"x = {x:.0f} mm")
    axes.set(xlabel="indentation [mm]", ylabel="force on the finger [N]", xlim=(-0.2, 3.2))
    axes.legend(frameon=False, fontsize=7.5, handlelength=1.8)


def draw_stroke(axes: plt.Axes, trajectory: Trajectory) -> None:
    """Draw the force along the stroke of a probe against its way."""
    force, place = (trajectory.logs[f"{name} of probe"] for name in ("force", "position"))
    during = (force.time >= 0.1) & (force.time <= 0.7)
    way = 1e3 * (place.value[during, 0] - place.value[0, 0])
    along, down = force.value[during, 0], -force.value[during, 2]
    half = len(way) // 2
    for part, sign in ((slice(0, half), 1), (slice(half, None), -1)):
        axes.plot(way[part], sign * 0.3 * down[part], color="#999999", lw=0.8)
    axes.plot(way, along, color=BLUE, lw=1.2)
    axes.text(3.0, 0.5, "0.3 x force down", color="#777777", fontsize=7.5)
    axes.set(xlabel="way of the stroke [mm]", ylabel="force along it [N]", ylim=(-1.0, 1.0))


def words() -> plt.Figure:
    """Return the words of a property and of a quantity as sets."""
    return plots.draw(
        "words", "fuzzy/soft_tissue", of=("hardness", "spring constant"), size=(224, 50)
    )


def save(figure: plt.Figure, name: str) -> None:
    """Write a figure as a small picture of few colours."""
    raw = BytesIO()
    figure.savefig(raw, dpi=110)
    plt.close(figure)
    picture = (
        Image.open(raw).convert("RGB").quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE)
    )
    picture.save(FIGURES / name, optimize=True)
    print(f"{FIGURES / name}: {(FIGURES / name).stat().st_size / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
