"""Sums over principal stretches, by Cauchy's integral around their squares.

With the squares x as zeros of p(x) = x³ - I1 x² + I2 x - 1, a sum S = Σ f(log x) changes by

    ∂S/∂I1 = 1/2πi ∮ e^w f'(w)/p(e^w) e^w dw,    ∂S/∂I2 = -1/2πi ∮ f'(w)/p(e^w) e^w dw

on a circle around the logarithms of the zeros, also where zeros coincide. On a circle, the mean
of equidistant points converges faster than any power of their number (L. N. Trefethen, J. A. C.
Weideman, SIAM Rev. 56:385, 2014).
"""

from collections.abc import Callable
from typing import Any

import numpy as np

_POINTS = 256
_WIDER, _AWAY = 1.3, 0.2  # radius of the circle over that of the zeros


def total(f: Callable[[Any], Any], i1: Any, i2: Any) -> Any:
    """Return S, shape (…).

    Args:
        f: Function of w = log x.
        i1, i2: Invariants, shape (…).
    """
    return f(_zeros(np.asarray(i1), np.asarray(i2))).real.sum(axis=-1)


def slopes(slope: Callable[[Any], Any], i1: Any, i2: Any) -> tuple[Any, Any]:
    """Return the derivatives of S by I1 and I2, each of shape (…).

    Args:
        slope: f', an analytic function of w = log x.
        i1, i2: Invariants, shape (…). What a small imaginary part changes is found to first
            order.
    """
    i1, i2 = np.broadcast_arrays(i1, i2)
    one, two = i1.real[..., None], i2.real[..., None]
    zeros = _zeros(i1.real, i2.real)
    middle = 0.5 * (zeros.real.min(axis=-1) + zeros.real.max(axis=-1))[..., None]
    radius = _WIDER * np.abs(zeros - middle).max(axis=-1)[..., None] + _AWAY
    way = radius * np.exp(2j * np.pi * (np.arange(_POINTS) + 0.5) / _POINTS)
    w = middle + way
    x = np.exp(w)
    inverse = 1.0 / (((x - one) * x + two) * x - 1.0)
    part = slope(w) * x * way * inverse

    def mean(power: int, again: int) -> Any:
        return (part * x**power * inverse**again).mean(axis=-1).real

    first, second = mean(1, 0), -mean(0, 0)
    if np.iscomplexobj(i1) or np.iscomplexobj(i2):
        both = -mean(2, 1)
        first = first + 1j * (mean(3, 1) * i1.imag + both * i2.imag)
        second = second + 1j * (both * i1.imag + mean(1, 1) * i2.imag)
    return first, second


def _zeros(i1: Any, i2: Any) -> Any:
    """Return the logarithms of the zeros of p, shape (…, 3)."""
    companion = np.zeros((*np.broadcast_shapes(i1.shape, i2.shape), 3, 3))
    companion[..., 0, 0], companion[..., 0, 1] = i1, -i2
    companion[..., 0, 2] = companion[..., 1, 0] = companion[..., 2, 1] = 1.0
    return np.log(np.linalg.eigvals(companion).astype(complex))
