"""Closed forms of the force on a rigid, frictionless sphere pressed into elastic tissue.

All functions take the radius `R` [m], the depth `d` [m] (below zero: no contact), Young's modulus `E` [Pa] and
Poisson's ratio `nu` [-], and return the force [N], elementwise. They are theories of small strain: the figures in
their docstrings say how far a Neo-Hookean solid departs from them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array


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
    """Force on a layer of thickness `h` [m] bonded to a rigid ground; the sphere has its true shape.

    Exact at small strain, by the integral equation of the layer (Lebedev and Ufliand 1958, J. Appl. Math. Mech. 22):
    the transform phi of the pressure satisfies phi(x) + 2/pi integral_0^a phi(t) k(x, t) dt = E*/pi (d - g(x)), with
    g the transform of the sphere's shape and phi(a) = 0 at the edge `a` of the circle of contact.
    """
    from scipy.interpolate import PchipInterpolator

    depth = np.maximum(np.asarray(d, dtype=np.float64), 0.0)
    # A bonded layer has up to twice the circle of contact of a half-space: that of four times its depth.
    widest = float(_contact_radius(np.array(4.2 * np.max(depth, initial=1e-12) / R)))
    pairs = np.array([(0.0, 1.0), *(_layer_force(a, nu, h / R) for a in np.linspace(0.0, widest, 31)[1:])])
    ratio = PchipInterpolator(np.sqrt(pairs[:, 0]), pairs[:, 1])(np.sqrt(depth / R))
    force: Array = ratio * sneddon(R, depth, E, nu)
    return force


def dimitriadis(R: float, d: npt.ArrayLike, E: float, nu: float, h: float) -> Array:
    """Polynomial approximation of `layer` (Dimitriadis and others 2002, Biophys. J. 82, 2798-2810, equation 12).

    Hertz times a polynomial in chi = sqrt(R d)/h. It lies below the exact force of thin layers, for nu from .3 to .5
    by 4 to 8 % at chi = .5 and by 11 to 20 % at chi = 1. At nu = .5 the equation gives -.0975 chi^4, where the form
    printed for that case has +.0975.
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


def _layer_force(a: float, nu: float, h: float) -> tuple[float, float]:
    """Depth, and force over that on a half-space at this depth, for a circle of contact `a`; lengths over R."""
    x, w = np.polynomial.legendre.leggauss(32)
    x, w = 0.5 * a * (x + 1.0), 0.5 * a * w
    s, ws = np.polynomial.legendre.leggauss(256)
    s, ws = 15.0 * (s + 1.0), 15.0 * ws  # the kernel decays as s^2 exp(-2 s)
    kappa = 3.0 - 4.0 * nu
    layer = (2 * kappa * np.sinh(2 * s) - 4 * s) / (2 * kappa * np.cosh(2 * s) + 4 * s**2 + 1 + kappa**2) - 1.0
    at = np.append(x, a)
    kernel = np.cos(np.outer(at, s) / h) * (layer * ws / h) @ np.cos(np.outer(s, x) / h)  # (33, 32)
    matrix = np.eye(len(x)) + 2.0 / np.pi * kernel[:-1] * w
    right = np.stack([np.ones_like(x), x * np.arctanh(x)], axis=1)  # of unit depth, and of the sphere's shape
    phi = np.linalg.solve(matrix, right)
    edge = np.array([1.0, a * np.arctanh(a)]) - 2.0 / np.pi * (kernel[-1] * w) @ phi
    depth = float(edge[1] / edge[0])
    force = 2.0 * float(w @ (phi @ [depth, -1.0]))  # in units of E* R^2
    return depth, force / float(sneddon(1.0, depth, 1.0, 0.0))


def _contact_radius(depth: Array) -> Array:
    """Radius of the circle of contact over R, for a depth over R: solves depth = a atanh(a) by Newton's method."""
    t = np.sqrt(depth) + 0.4 * depth  # a = tanh(t), which keeps a below one
    for _ in range(20):
        a = np.tanh(t)
        slope = a + t * (1.0 - a**2)
        t = np.maximum(t - (t * a - depth) / np.maximum(slope, 1e-300), 0.0)
    return np.tanh(t)
