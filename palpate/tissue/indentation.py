"""Closed forms of the force on a rigid, frictionless sphere pressed into elastic tissue.

All functions take the radius `R` [m], the depth `d` [m] (below zero: no contact), Young's modulus `E` [Pa] and
Poisson's ratio `nu` [-], and return the force [N], elementwise. They are theories of small strain: the figures in
their docstrings say how far a Neo-Hookean solid departs from them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.arrays import Array


def hertz(R: float, d: npt.ArrayLike, E: float, nu: float) -> Array:
    """Force on a half-space, sphere taken as a paraboloid (Hertz 1882): 4/3 E/(1 - nu^2) sqrt(R) d^1.5."""
    depth = np.maximum(np.asarray(d, dtype=np.float64), 0.0)
    force: Array = 4.0 / 3.0 * E / (1.0 - nu**2) * np.sqrt(R) * depth**1.5
    return force


def sneddon(R: float, d: npt.ArrayLike, E: float, nu: float) -> Array:
    """Force on a half-space, sphere with its true shape (Sneddon 1965, Int. J. Eng. Sci. 3, 47-57, section 6).

    The radius `a` of the circle of contact follows from d = a/2 ln((R + a)/(R - a)).
    """
    depth = np.maximum(np.asarray(d, dtype=np.float64), 0.0)
    a = R * _contact_radius(depth / R)
    log = np.log((R + a) / (R - a))
    force: Array = E / (1.0 - nu**2) * (0.5 * (a**2 + R**2) * log - a * R)
    return force


def layer(R: float, d: npt.ArrayLike, E: float, nu: float, h: float) -> Array:
    """Force on a layer of thickness `h` [m] bonded to a rigid ground (Dimitriadis and others 2002, Biophys. J. 82).

    Equation 12 there, for frictionless contact: Hertz times a polynomial in chi = sqrt(R d)/h, for chi up to about 1.
    At nu = .5 it gives -.0975 chi^4, where the form printed for that case has +.0975.
    """
    depth = np.maximum(np.asarray(d, dtype=np.float64), 0.0)
    alpha = -(1.2876 - 1.4678 * nu + 1.3442 * nu**2) / (1.0 - nu)
    beta = (0.6387 - 1.0277 * nu + 1.5164 * nu**2) / (1.0 - nu)
    x = np.sqrt(R * depth) / h
    pi = np.pi
    terms = (
        1.0,
        -2.0 * alpha / pi,
        4.0 * alpha**2 / pi**2,
        -8.0 / pi**3 * (alpha**3 + 4.0 * pi**2 / 15.0 * beta),
        16.0 * alpha / pi**4 * (alpha**3 + 3.0 * pi**2 / 5.0 * beta),
    )
    force: Array = hertz(R, depth, E, nu) * np.polynomial.polynomial.polyval(x, terms)
    return force


def _contact_radius(depth: Array) -> Array:
    """Radius of the circle of contact over R, for a depth over R: solves depth = a atanh(a) by Newton's method."""
    t = np.sqrt(depth) + 0.4 * depth  # a = tanh(t), which keeps a below one
    for _ in range(20):
        a = np.tanh(t)
        slope = a + t * (1.0 - a**2)
        t = np.maximum(t - (t * a - depth) / np.maximum(slope, 1e-300), 0.0)
    return np.tanh(t)
