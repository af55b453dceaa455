"""Modulus, nonlinearity and relaxation of tissue from an indentation by a sphere, with confidence intervals.

The force is a hereditary integral of the elastic force of a half-space, or of a layer of known thickness:

    F(t) = F_0 + Fe(d) + sum_i g_i integral exp(-(t - s)/tau_i) dFe        (Lee and Radok 1960)
    Fe(d) = F_small(d - d_0; E) (1 + beta (d - d_0)/R)

F_small is the theory of small strain, which a Neo-Hookean half-space at nu = .45 follows within .5 % up to d = R/2
(`palpate.tissue.indentation`, `palpate.verify.tissue`). beta measures stiffening beyond that. The time constants tau_i
are fixed, one for each decade between the sampling period and the duration; E, beta, g_i, the position d_0 of the first
touch and the offset F_0 are fitted by nonlinear least squares.

Intervals follow from the curvature at the solution and the autocorrelation of the residual. They cover noise, not a
tissue of another form: `residual` says how much of the force the model leaves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from palpate.arrays import Array
from palpate.errors import RecordingError
from palpate.identify.press_recording import Press
from palpate.tissue import indentation, viscosity

MOST_TERMS = 4
_MOST_ROWS = 1500
_SHALLOW = 0.15  # depth over the radius below which stiffening has no effect on the force
_WIDE = 0.5  # relative half width of an interval above which a value counts as not identified
_Z95 = 1.96


@dataclass(frozen=True)
class TissueFit:
    """The identified tissue. Intervals are 95 %, (low, high), and cover noise."""

    radius: float  #: of the sphere [m]
    thickness: float  #: of the layer; infinity: a half-space [m]
    poisson: float  #: assumed
    young: float  #: Young's modulus at rest and small strain, for the assumed Poisson's ratio [Pa]
    young_95: tuple[float, float]
    instantaneous: float  #: Young's modulus before relaxation, if the shear and bulk moduli relaxed alike [Pa]
    instantaneous_95: tuple[float, float]
    beta: float  #: stiffening over depth/radius [-]; 0 if the recording does not show any
    beta_95: tuple[float, float]  #: infinite if beta is not fitted
    prony: tuple[tuple[float, float], ...]  #: terms (g_i [-], tau_i [s])
    touch: float  #: depth of the first touch in the recording [m]
    offset: float  #: force without contact [N]
    residual: float  #: RMS of what the model leaves, over the largest force [-]
    deepest: float  #: largest depth over the radius [-]
    seconds: float  #: duration of the recording [s]
    not_identifiable: tuple[str, ...] = ()  #: sentences
    press: Press = field(default_factory=lambda: Press(np.zeros(0), np.zeros(0), np.zeros(0)))  #: as fitted
    fitted: Array = field(default_factory=lambda: np.zeros(0))  #: force of the model [N]

    @property
    def yeoh(self) -> float:
        """Yeoh's coefficient of a half-space with this stiffening [-]; 0 for softening."""
        from palpate import _tissue

        return max(self.beta, 0.0) / _tissue.YEOH_GROWTH

    def force(self, t: Array, depth: Array) -> Array:
        """Force (n,) [N] of the identified tissue at times [s] and depths from the first touch [m], (n,)."""
        elastic = _small(self, depth) * self.young * (1.0 + self.beta * np.maximum(depth, 0.0) / self.radius)
        return viscosity.hereditary_force(self.prony, t, elastic)


def fit(press: Press, radius: float, thickness: float = np.inf, poisson: float = 0.45) -> TissueFit:
    """Identify tissue.

    Args:
        press: the recording.
        radius: radius of the sphere [m].
        thickness: thickness of the tissue on a rigid ground, if known [m].
        poisson: assumed Poisson's ratio.

    Raises:
        RecordingError: there is no press in the recording, or the values are not in SI units.
    """
    _require_press(press, radius)
    press = _thinned(press)
    taus = _time_constants(press.t)
    case = _Case(press, radius, thickness, poisson, taus)
    x, J, stiffens = _chosen(case)
    r = case.residuals(x)
    std = _deviations(J, r)
    E, beta, g = float(np.exp(x[0])), float(x[1]), x[4:]
    sums = np.zeros_like(x)  # gradient of log E + log(1 + sum g)
    sums[0], sums[4:] = 1.0, 1.0 / (1.0 + g.sum())
    covariance = _covariance(J, r)
    relative = float(np.sqrt(sums @ covariance @ sums))
    fast = E * (1.0 + float(g.sum()))
    deepest = float((press.depth - x[2]).max() / radius)
    return TissueFit(
        radius=radius,
        thickness=thickness,
        poisson=poisson,
        young=E,
        young_95=_around(E, std[0]),
        instantaneous=fast,
        instantaneous_95=_around(fast, relative),
        beta=beta,
        beta_95=(float(beta - _Z95 * std[1]), float(beta + _Z95 * std[1])) if stiffens else (-np.inf, np.inf),
        prony=tuple((float(gi), float(tau)) for gi, tau in zip(g, taus, strict=True)),
        touch=float(x[2]),
        offset=float(x[3]),
        residual=float(np.sqrt(np.mean(r**2)) / np.abs(press.force).max()),
        deepest=deepest,
        seconds=float(np.ptp(press.t)),
        not_identifiable=_unidentified(press, case, x, std, deepest, stiffens),
        press=press,
        fitted=press.force - r,
    )


@dataclass(frozen=True)
class _Case:
    """A least-squares problem in x = (log E, beta, d_0, F_0, g_1 ...)."""

    press: Press
    radius: float
    thickness: float
    poisson: float
    taus: Array

    @cached_property
    def table(self) -> tuple[Array, Array]:
        """Roots of depths (k,) [m^.5], and the force of small strain over depth^1.5 there (k,) [N/Pa/m^1.5]."""
        root = np.linspace(1e-3, 1.0, 300) * np.sqrt(float(self.press.depth.max()) + 0.3 * self.radius)
        return root, _small(self, root**2) / root**3

    def residuals(self, x: Array) -> Array:
        """Measured minus modelled force (n,) [N]."""
        depth = np.maximum(self.press.depth - x[2], 0.0)
        root = np.sqrt(depth)
        elastic = np.exp(x[0]) * np.interp(root, *self.table) * root**3 * (1.0 + x[1] * depth / self.radius)
        terms = list(zip(x[4:].tolist(), self.taus.tolist(), strict=True))
        return np.asarray(self.press.force - x[3] - viscosity.hereditary_force(terms, self.press.t, elastic))

    def solve(self, stiffens: bool) -> tuple[Array, Array]:
        """The solution and the derivative (n, p) of the residuals there; beta stays zero unless the tissue stiffens."""
        from scipy.optimize import least_squares

        k, R = len(self.taus), self.radius
        push = float(np.abs(self.press.force).max())
        deep = float(self.press.depth.max())
        E = max(push / float(_small(self, np.array([deep]))[0]) / 1.5, 1.0)
        start = np.r_[np.log(E), 0.0, 0.0, 0.0, np.full(k, 0.5 / max(k, 1))]
        low = np.r_[np.log(E) - 6.0, -0.9, -0.3 * R, -push, np.zeros(k)]
        high = np.r_[np.log(E) + 6.0, 5.0, min(0.3 * R, 0.8 * deep), push, np.full(k, 20.0)]
        scale = np.r_[1.0, 1.0, 0.1 * R, push, np.ones(k)]
        if not stiffens:
            low[1], high[1] = -1e-12, 1e-12
        found = least_squares(self.residuals, start, bounds=(low, high), x_scale=scale, method="trf")
        J = np.array(found.jac)
        if not stiffens:
            J[:, 1] = 0.0  # beta is given, so it does not widen the other intervals
        return np.asarray(found.x), J


def _chosen(case: _Case) -> tuple[Array, Array, bool]:
    """Solution, derivative, and whether beta is fitted: only if the residual falls by more than chance explains.

    The gain is judged by Bayes's information criterion (Schwarz 1978), for the number of independent samples.
    """
    x, J = case.solve(stiffens=False)
    if case.press.depth.max() < _SHALLOW * case.radius:
        return x, J, False
    x1, J1 = case.solve(stiffens=True)
    r, r1 = case.residuals(x), case.residuals(x1)
    n = len(r) / _correlated(r1)
    if n * np.log(float(r @ r) / max(float(r1 @ r1), 1e-300)) < np.log(max(n, 3.0)) + _Z95**2:
        return x, J, False
    return x1, J1, True


def _small(case: _Case | TissueFit, depth: Array) -> Array:
    """Force of small strain for a Young's modulus of one (n,) [N/Pa]."""
    if np.isfinite(case.thickness):
        return indentation.layer(case.radius, depth, 1.0, case.poisson, case.thickness)
    return indentation.sneddon(case.radius, depth, 1.0, case.poisson)


def _time_constants(t: Array) -> Array:
    """About one for each decade, between three sampling periods and a third of the duration [s]."""
    low, high = 3.0 * float(np.median(np.diff(t))), float(np.ptp(t)) / 3.0
    if high <= low:
        return np.zeros(0)
    count = int(np.clip(np.ceil(1.3 * np.log10(high / low)), 1, MOST_TERMS))
    edges = np.geomspace(low, high, count + 1)
    taus: Array = np.sqrt(edges[1:] * edges[:-1])
    return taus


def _covariance(J: Array, r: Array) -> Array:
    """Covariance of the parameters: Gauss-Newton curvature, with the correlation time of the residual."""
    n, p = J.shape
    scale = np.linalg.norm(J, axis=0)
    scale[scale == 0.0] = 1.0
    inverse = np.linalg.pinv((J / scale).T @ (J / scale), rcond=1e-12)
    variance = float(r @ r) / max(n - p, 1) * _correlated(r)
    covariance: Array = variance * inverse / np.outer(scale, scale)
    return covariance


def _correlated(r: Array) -> float:
    """Number of samples in a correlation time of the residual: 1 for white noise."""
    r = r - r.mean()
    power = float(r @ r)
    total = 1.0
    for k in range(1, len(r) // 4):
        rho = float(r[:-k] @ r[k:]) / max(power, 1e-300)
        if rho < 0.05:
            break
        total += 2.0 * rho
    return total


def _deviations(J: Array, r: Array) -> Array:
    return np.sqrt(np.maximum(np.diag(_covariance(J, r)), 0.0))


def _around(value: float, relative: float) -> tuple[float, float]:
    factor = float(np.exp(_Z95 * min(relative, 50.0)))
    return value / factor, value * factor


def _thinned(press: Press) -> Press:
    """At most `_MOST_ROWS` evenly spaced rows, as means of neighbouring ones."""
    step = np.diff(press.t)
    if np.ptp(step) > 1e-6 * step.mean():
        t = np.arange(press.t[0], press.t[-1], float(np.median(step)))
        press = Press(t, np.interp(t, press.t, press.depth), np.interp(t, press.t, press.force), press.source)
    every = -(-len(press.t) // _MOST_ROWS)
    if every == 1:
        return press
    n = len(press.t) // every * every
    t, depth, force = (x[:n].reshape(-1, every).mean(axis=1) for x in (press.t, press.depth, press.force))
    return Press(t, depth, force, press.source)


def _require_press(press: Press, radius: float) -> None:
    deep, push = float(press.depth.max()), float(press.force.max())
    if push <= 0.0 or press.depth[np.argmax(press.force)] <= 0.2 * deep:
        signs = f"largest force {push:g} N, largest depth {deep:g} m"
        mend = "force on the sphere and depth into the tissue are positive: change their signs"
        raise RecordingError("there is no press in the recording", where=press.source, why=signs, mend=mend)
    if not (np.isfinite(radius) and radius > 0.0):
        raise RecordingError(f"the radius must be positive, got {radius!r} m", where=press.source)
    if deep > 3.0 * radius:
        why = f"{1e3 * deep:.3g} mm with a sphere of {1e3 * radius:.3g} mm"
        raise RecordingError(
            "the press is deeper than three radii", where=press.source, why=why, mend="check the units"
        )


def _unidentified(press: Press, case: _Case, x: Array, std: Array, deepest: float, stiffens: bool) -> tuple[str, ...]:
    """What the recording does not determine, in sentences."""
    found = [
        f"Poisson's ratio: {case.poisson:g} is assumed; the force determines E / (1 - nu^2) only",
    ]
    if not np.isfinite(case.thickness):
        found.append("the thickness: a half-space is assumed, and a thin layer would appear stiffer")
    if _Z95 * std[0] > _WIDE:
        found.append("the modulus: its interval is wider than half its value")
    if deepest < _SHALLOW:
        found.append(f"stiffening: the press ends at {deepest:.2f} radii, and needs {_SHALLOW:g} or more")
    elif not stiffens:
        found.append(
            "stiffening: it counts as zero, so the modulus is a mean over the depth; hold several depths to see it"
        )
    elif _Z95 * std[1] > _WIDE:
        found.append("stiffening: its interval is wider than half of the force at a depth of one radius")
    rate = np.abs(np.gradient(press.depth, press.t))
    rise = 0.1 * float(press.depth.max() / rate.max())  # of a tenth of the depth, where the press is fastest [s]
    for g, tau, s in zip(x[4:], case.taus, std[4:], strict=True):
        if tau < 3.0 * rise:
            found.append(f"relaxation at {tau:.2g} s: the press is too slow; press faster")
        elif _Z95 * s > max(_WIDE * g, 0.1):
            found.append(f"relaxation at {tau:.2g} s: its term is {g:.2g} +- {_Z95 * s:.2g}")
    if len(case.taus) == 0 or np.mean(rate > 0.05 * rate.max()) > 0.8:
        found.append("relaxation: hold the depth for several seconds after the press")
    return tuple(found)
