"""Bundles: functions that are shipped and loaded together."""

from collections.abc import Callable

#: Constants of the forces of springs. A form that has some is named after them.
FLAGS = ("VISCOUS", "WATCHED", "OF_LAWS")
#: By bundle: operations of ``kernels.records.Operations``, some in several forms, and others.
BUNDLES: dict[str, tuple[str, ...]] = {
    "core": ("force", "kinetic", "place", "slack"),
    "watched": ("peaks", "tension"),
    "springs": ("springs",),
    "springs_viscous": ("springs_viscous",),
    "springs_viscous_watched": ("springs_viscous_watched",),
    "springs_watched": ("springs_watched",),
    "laws": ("bend_of_passed", "find_sides", "springs_viscous_watched_of_laws"),
    "runs": ("springs_in_runs",),
    "runs_viscous": ("springs_in_runs_viscous",),
    "runs_viscous_watched": ("springs_in_runs_viscous_watched",),
    "runs_watched": ("springs_in_runs_watched",),
    "crossing": ("find_crossings", "place_triangles"),
    "published": ("greatest_force", "greatest_inner_force"),
    "banded": ("assemble_banded", "solve_banded"),
    "iterative": ("assemble_iterative", "solve_iterative"),
    "rate": ("rate",),
    "derivatives": (
        "acceleration", "begin_dues", "combine_stage", "enter_stage", "leave_step",
        "pull_back", "push_forward", "step_back", "step_change", "step_forward", "weigh_stage",
    ),
    "raster": ("fill",),
    "spring_geometry": ("add_pulls", "add_resistance", "measure"),
    "stages": ("blended_errors", "combine"),
    "vectors": (
        "accumulate", "between", "copy_sample", "correct", "distance", "drift", "is_passed",
        "length", "polynomials", "quadrature", "scale", "subtract",
    ),
}  # fmt: skip
BUNDLE_OF = {name: bundle for bundle, names in BUNDLES.items() for name in names}


def of_method(integrator: type) -> str:
    """Return the bundle of the loop over steps of an integrator; its function is "drive"."""
    return f"drive_{integrator.__name__.lower()}"


def of_field(kernel: Callable[..., object]) -> str:
    """Return the bundle of the kernel of a field, named after the module that has it."""
    module = kernel.__module__.rpartition(".")[2]
    return f"field_{module.removesuffix('_kernel')}"
