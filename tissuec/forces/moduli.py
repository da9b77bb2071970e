"""Moduli of isotropic tissue, from its shear and bulk moduli."""

from tissuec.model.network import Floats


def young_of(shear: Floats, bulk: Floats) -> Floats:
    """Return Young's modulus 9 K μ/(3 K + μ) [Pa], of the shape of the arguments.

    Args:
        shear, bulk: μ and K [Pa].
    """
    return 9.0 * bulk * shear / (3.0 * bulk + shear)


def poisson_of(shear: Floats, bulk: Floats) -> Floats:
    """Return Poisson's ratio (3 K/2 - μ)/(3 K + μ), of the shape of the arguments.

    Args:
        shear, bulk: μ and K [Pa].
    """
    return (1.5 * bulk - shear) / (3.0 * bulk + shear)


def plane_modulus(shear: Floats, bulk: Floats) -> Floats:
    """Return E/(1 - ν²) = 4 μ (3 K + μ)/(3 K + 4 μ) [Pa], of the shape of the arguments.

    Args:
        shear, bulk: μ and K [Pa].
    """
    return 4.0 * shear * (3.0 * bulk + shear) / (3.0 * bulk + 4.0 * shear)
