"""Automatic differentiation: an effect is written once, and all that it needs follows.

A potential is a plain function of numbers. It is traced once (``graph``), differentiated
(``derivatives``, ``potentials``), and written as machine code for several items at a time
(``emission``, ``compiled.loops``). What is imported here is what such functions are made of.
"""

from tissuec.autodiff.angles import Angle
from tissuec.autodiff.derivatives import along, gradient, hessian
from tissuec.autodiff.functions import (
    cos,
    exp,
    in_arrays,
    log,
    maximum,
    minimum,
    ruled,
    sin,
    sqrt,
    where,
)
from tissuec.autodiff.graph import Number, TracingError
from tissuec.autodiff.potentials import Numbers, Potential, StatedForces
from tissuec.autodiff.tensors import (
    TINY,
    Tensor,
    Vector,
    cross,
    determinant,
    deviator,
    dot,
    from_half,
    gram,
    inner,
    largest,
    norm,
    square,
    symmetric,
    symmetric_part,
    trace,
)
from tissuec.autodiff.unknowns import Least, least

__all__ = [
    "TINY", "Angle", "Least", "Number", "Numbers", "Potential", "StatedForces", "Tensor",
    "TracingError", "Vector", "along", "cos", "cross", "determinant", "deviator", "dot", "exp",
    "from_half", "gradient", "gram", "hessian", "in_arrays", "inner", "largest", "least", "log",
    "maximum", "minimum", "norm", "ruled", "sin", "sqrt", "square", "symmetric",
    "symmetric_part", "trace", "where",
]  # fmt: skip
