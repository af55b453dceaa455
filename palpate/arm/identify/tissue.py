"""Modulus, nonlinearity and relaxation of tissue from an indentation by a sphere, with confidence intervals.

The force is a hereditary integral of the elastic force of a half-space, or of a layer of known thickness:

    F(t) = F_0 + Fe(d) + sum_i g_i integral exp(-(t - s)/tau_i) dFe        (Lee and Radok 1960)
    Fe(d) = F_small(d - d_0; E) (1 + beta (d - d_0)/R)

F_small is the theory of small strain, which a Neo-Hookean half-space at nu = .45 follows within .5 % up to d = R/2
(`palpate.world.tissue.indentation`, `palpate_lab.verify.tissue`). beta measures stiffening beyond that. F_0 is the
offset of the sensor, which drifts linearly. All parameters are fitted by least squares; those that are linear in the
force are eliminated (variable projection; Golub and Pereyra 1973). The covariance is that of least squares in noise
that is white plus 1/f plus 1/f^2, with the shares that explain the spectrum of the residual, of which the fit has taken
a part.

How many time constants there are, and whether the sensor drifts, is not known. The values are means over these forms,
weighted by Akaike's information criterion (Buckland et al., Biometrics 53, 1997), and the intervals include the spread
over the forms. Stiffening is always a parameter where the press is deep enough: left out where it is not significant,
it would bias the modulus by more than its interval. They cover noise, white or coloured, and drift, not a tissue of
another form: `residual` says how much of the force the model leaves, `coloured` how much more that is than white noise.
Two other forms are named: a force that softens with the depth, as over an edge, and a force with another power of the
depth, as under a cone.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from palpate.arm.identify.coloured_noise import Noise, over_white
from palpate.arm.identify.press_recording import Press
from palpate.base.arrays import Array
from palpate.base.errors import RecordingError
from palpate.world.tissue import indentation, viscosity

MOST_TERMS = 4
_MOST_ROWS = 1500
_SHALLOW = 0.15  # depth over the radius below which stiffening has no effect on the force
_WIDE = 0.5  # relative half width of an interval above which a value counts as not identified
_VAGUE = 0.1  # half width of the interval of the stiffening above which more depths are asked for
_TOUCHES = 12  # depths of the first touch from which the search starts
_HOPELESS = 12.0  # criterion above the best from which on simpler forms are not tried
_SOFTENS = -0.05  # largest stiffening that counts as softening
_CLEARER = 6.0  # Akaike's criterion by which another exponent must fit better, 20 times as probable
_LAYERED = 0.1  # stiffening from which on a layer is named: Hertz's force has that much more than Sneddon's
_TIP = 0.35  # change of the exponent that is a cone's or a punch's rather than stiffening: then any better fit counts
_COLOURED = 1.2  # residual over its white noise from which on a remark is made
_ABOVE = 0.05  # largest height above the tissue from which a press begins [m]


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
    beta: float  #: stiffening over depth/radius [-]; 0 if the press is too shallow to show any
    beta_95: tuple[float, float]  #: infinite if the press is too shallow
    prony: tuple[tuple[float, float], ...]  #: terms (g_i [-], tau_i [s])
    touch: float  #: depth of the first touch in the recording [m]
    offset: float  #: force without contact at the start [N]
    drift: float  #: change of that force over the recording [N]
    residual: float  #: RMS of what the model leaves, over the largest force [-]
    coloured: float  #: RMS of what the model leaves, over that of its white noise [-]; 1 for white noise
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
    forms = [one for one in _forms(press, radius, thickness, poisson) if one.linear[0] > 0.0]
    if not forms:
        raise RecordingError(
            "the force relaxes to nothing, so the tissue has no modulus at rest", where=press.source,
            why="the force falls while the depth is held, to zero or below: the sensor drifts, or the contact slips",
            mend="record again with the sensor zeroed above the tissue; press on a flat place",
        )  # fmt: skip
    share = _shares(forms)
    best = forms[int(np.argmax(share))]
    stiff = best.case.stiffens
    E, rest_of = _mean(share, [one.log_young for one in forms])
    fast, fast_of = _mean(share, [one.log_instantaneous for one in forms])
    beta, beta_of = _mean(share, [one.stiffening for one in forms]) if stiff else (0.0, np.inf)
    E, fast = float(np.exp(E)), float(np.exp(fast))
    r = best.case.residuals(best.y)
    touch = best.touch
    reach = _student(len(r) - len(best.x))
    return TissueFit(
        radius=radius,
        thickness=thickness,
        poisson=poisson,
        young=E,
        young_95=_around(E, reach * rest_of),
        instantaneous=fast,
        instantaneous_95=_around(fast, reach * fast_of),
        beta=beta,
        beta_95=(beta - reach * beta_of, beta + reach * beta_of) if stiff else (-np.inf, np.inf),
        prony=best.prony,
        touch=touch,
        offset=best.offset,
        drift=best.drift,
        residual=float(np.sqrt(np.mean(r**2)) / np.abs(press.force).max()),
        coloured=over_white(r),
        deepest=float((press.depth.max() - touch) / radius),
        seconds=float(np.ptp(press.t)),
        not_identifiable=(*_unidentified(best, reach * rest_of, reach * beta_of), *_other_contact(best, reach)),
        press=press,
        fitted=press.force - r,
    )


@dataclass(frozen=True)
class _Case:
    """A form of the tissue: its number of time constants, and whether it stiffens.

    y = (d_0/R, beta if it stiffens, log tau_1 ...) enters nonlinearly; z = (E, E g_1 ..., F_0, drift) linearly.
    """

    press: Press
    radius: float
    thickness: float
    poisson: float
    terms: int
    stiffens: bool
    drifts: bool = False
    exponent: bool = False  # beta is not the stiffening but what the depth's exponent has more than that of a sphere

    @cached_property
    def table(self) -> tuple[Array, Array]:
        """Roots of depths (k,) [m^.5], and the force of small strain over depth^1.5 there (k,) [N/Pa/m^1.5]."""
        root = np.linspace(1e-3, 1.0, 300) * np.sqrt(float(np.ptp(self.press.depth)) + 0.3 * self.radius)
        return root, _small(self, root**2) / root**3

    def columns(self, y: Array) -> Array:
        """Forces (n, 3 + terms) of the linear parameters."""
        t = self.press.t
        depth = np.maximum(self.press.depth - y[0] * self.radius, 0.0)
        root = np.sqrt(depth)
        beta = y[1] if self.stiffens else 0.0
        part = depth / self.radius
        factor = np.maximum(part, 1e-9) ** beta if self.exponent else 1.0 + beta * part
        elastic = np.interp(root, *self.table) * root**3 * factor
        taus = np.exp(y[len(y) - self.terms :])
        late = [viscosity.hereditary_force([(1.0, tau)], t, elastic) - elastic for tau in taus.tolist()]
        slope = (t - t[0]) / np.ptp(t) if self.drifts else np.zeros(len(t))
        return np.column_stack([elastic, *late, np.ones(len(t)), slope])

    def linear(self, y: Array) -> tuple[Array, Array, Array]:
        """The linear parameters, their columns and the residuals."""
        from scipy.optimize import nnls

        A, b = self.columns(y), self.press.force
        size = np.maximum(np.linalg.norm(A, axis=0), 1e-300)
        Q, R = np.linalg.qr(A / size)
        free = self.terms + 1  # offset and drift may be negative
        both = np.hstack([R, -R[:, free:]])
        found = nnls(both, Q.T @ b)[0]
        z = found[: R.shape[1]]
        z[free:] -= found[R.shape[1] :]
        z = z / size
        return z, A, b - A @ z

    def residuals(self, y: Array) -> Array:
        """Measured minus modelled force (n,), not whitened [N]."""
        return np.asarray(self.press.force - self.columns(y) @ self.linear(y)[0])

    def solve(self) -> _Form:
        """The most probable parameters."""
        from scipy.optimize import least_squares

        deep, R = self.press.depth, self.radius
        times = _time_range(self.press.t)
        edges = np.linspace(np.log(times[0]), np.log(times[1]), self.terms + 1)
        taus = 0.5 * (edges[1:] + edges[:-1])
        extra = [0.0] if self.stiffens else []
        low = np.r_[(deep.min() - 0.3 * R) / R, [-0.9] * len(extra), np.full(self.terms, np.log(times[0]) - 0.7)]
        high = np.r_[
            (deep.min() + 0.95 * np.ptp(deep)) / R, [5.0] * len(extra), np.full(self.terms, np.log(times[1]) + 1.1)
        ]
        tried = [np.r_[d, extra, taus] for d in np.linspace(low[0], high[0], _TOUCHES + 2)[1:-1]]
        start = min(tried, key=lambda y: float(np.square(self.linear(y)[2]).sum()))
        found = least_squares(
            lambda y: self.linear(y)[2], start, bounds=(low, high), x_scale=np.r_[0.1, np.ones(len(start) - 1)]
        )
        if found.x[0] > high[0] - 1e-3:
            raise RecordingError(
                f"the first touch lies outside of the recording, near {1e3 * R * found.x[0]:.3g} mm",
                where=self.press.source, why="the force rises in the last rows only, or never",
                mend="record from above the tissue, and press deeper; check depth and force",
            )  # fmt: skip
        return _Form.of(self, found.x)


@dataclass(frozen=True)
class _Form:
    """A fitted form of the tissue."""

    case: _Case
    y: Array
    x: Array  # y and the linear parameters
    covariance: Array
    criterion: float  # Akaike's

    @staticmethod
    def of(case: _Case, y: Array) -> _Form:
        """Parameters with their covariance by the curvature at the solution."""
        z, A, e = case.linear(y)
        steps = np.eye(len(y)) * 1e-5
        J = np.column_stack([(case.columns(y + h) - case.columns(y - h)) @ z / 2e-5 for h in steps] + [A])
        used = np.r_[np.ones(len(y), bool), z != 0.0]
        for k in range(case.terms):  # a term without share has no time constant
            used[len(y) - case.terms + k] &= z[1 + k] > 0.0
        size = np.where(used, np.maximum(np.linalg.norm(J, axis=0), 1e-300), 1.0)
        N = np.where(used, J / size, 0.0)
        n, p = len(e), int(used.sum())
        H = np.linalg.pinv(N.T @ N, rcond=1e-12, hermitian=True)
        spread = Noise.of(e, np.linalg.qr(N[:, used])[0]).times(N)
        C = H @ (N.T @ spread) @ H / np.outer(size, size)
        criterion = n * np.log(max(float(e @ e) / n, 1e-300)) + 2.0 * p
        return _Form(case, y, np.r_[y, z], np.asarray(0.5 * (C + C.T)), criterion)

    @property
    def rss(self) -> float:
        """Sum of squared residuals [N^2]."""
        return float(np.square(self.case.residuals(self.y)).sum())

    @property
    def touch(self) -> float:
        """Depth of the first touch [m]."""
        return float(self.y[0] * self.case.radius)

    @property
    def linear(self) -> Array:
        """(E, E g_1 ..., F_0, drift over the recording)."""
        return self.x[len(self.y) :]

    @property
    def prony(self) -> tuple[tuple[float, float], ...]:
        """Terms (g_i, tau_i), the shortest time first."""
        E, taus = float(self.linear[0]), np.exp(self.y[len(self.y) - self.case.terms :])
        terms = zip((self.linear[1 : 1 + self.case.terms] / E).tolist(), taus.tolist(), strict=True)
        return tuple(sorted((term for term in terms if term[0] > 0.0), key=lambda term: term[1]))

    @property
    def drift(self) -> float:
        """Drift of the force over the recording [N]."""
        return float(self.linear[-1])

    @property
    def offset(self) -> float:
        """Force without contact at the start [N]."""
        return float(self.linear[-2])

    def _of(self, value: float, gradient: Array) -> tuple[float, float]:
        return value, float(np.sqrt(max(float(gradient @ self.covariance @ gradient), 0.0)))

    @property
    def log_young(self) -> tuple[float, float]:
        """Logarithm of the modulus at rest, and its standard deviation."""
        g = np.zeros(len(self.x))
        g[len(self.y)] = 1.0 / self.linear[0]
        return self._of(float(np.log(self.linear[0])), g)

    @property
    def log_instantaneous(self) -> tuple[float, float]:
        """Logarithm of the modulus before relaxation, and its standard deviation."""
        parts = slice(len(self.y), len(self.y) + 1 + self.case.terms)
        total, g = float(self.x[parts].sum()), np.zeros(len(self.x))
        g[parts] = 1.0 / total
        return self._of(float(np.log(total)), g)

    @property
    def stiffening(self) -> tuple[float, float]:
        """beta and its standard deviation; zero in a form that does not stiffen."""
        if not self.case.stiffens:
            return 0.0, 0.0
        return self._of(float(self.y[1]), np.eye(len(self.x))[1])


def _forms(press: Press, radius: float, thickness: float, poisson: float) -> list[_Form]:
    """Fits of all forms, the richest first."""
    low, high = _time_range(press.t)
    most = int(np.clip(np.ceil(np.log10(high / low)), 0, MOST_TERMS)) if high > low else 0
    case = _Case(press, radius, thickness, poisson, most, float(np.ptp(press.depth)) > _SHALLOW * radius)
    forms = []
    for terms in range(most, -1, -1):
        forms.append(replace(case, terms=terms).solve())
        if forms[-1].criterion > min(one.criterion for one in forms) + _HOPELESS:
            break
    likely = min(forms, key=lambda one: one.criterion)
    drifting = replace(likely.case, drifts=True).solve()
    if drifting.criterion > likely.criterion:
        return [*forms, drifting]
    others = [replace(one.case, drifts=True).solve() for one in forms if one is not likely]
    return [*forms, drifting, *others]


def _shares(forms: list[_Form]) -> Array:
    """Probabilities of the forms."""
    criterion = np.array([one.criterion for one in forms])
    p = np.exp(-0.5 * (criterion - criterion.min()))
    return np.asarray(p / p.sum())


def _mean(share: Array, found: list[tuple[float, float]]) -> tuple[float, float]:
    """Mean over the forms, and the standard deviation within and between them."""
    value, deviation = np.array(found).T
    mean = float(share @ value)
    return mean, float(np.sqrt(share @ (deviation**2 + (value - mean) ** 2)))


def _student(freedom: int) -> float:
    from scipy.special import stdtrit

    return float(stdtrit(max(freedom, 1), 0.975))


def _small(case: _Case | TissueFit, depth: Array) -> Array:
    """Force of small strain for a Young's modulus of one (n,) [N/Pa]."""
    if np.isfinite(case.thickness):
        return indentation.layer(case.radius, depth, 1.0, case.poisson, case.thickness)
    return indentation.sneddon(case.radius, depth, 1.0, case.poisson)


def _time_range(t: Array) -> tuple[float, float]:
    """Shortest and longest time constant that a recording may show [s]."""
    return 3.0 * float(np.median(np.diff(t))), float(np.ptp(t)) / 3.0


def _around(value: float, reach: float) -> tuple[float, float]:
    factor = float(np.exp(min(reach, 50.0)))
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
    if float(np.ptp(press.depth)) > 3.0 * radius + _ABOVE and deep > 3.0 * radius:
        why = f"{1e3 * deep:.3g} mm with a sphere of {1e3 * radius:.3g} mm"
        raise RecordingError(
            "the press is deeper than three radii", where=press.source, why=why, mend="check the units"
        )


def _other_contact(best: _Form, reach: float) -> tuple[str, ...]:
    """Sentences on a force that no stiffening of a half-space under a sphere explains; `reach`: Student's factor.

    Tissue stiffens when it is compressed, and never softens. A tip of another shape changes the exponent of the depth:
    1 for a flat punch, 2 for a cone.
    """
    if not best.case.stiffens:
        return ()
    beta, deviation = best.stiffening
    end = "; the interval of the modulus does not cover that"
    found = []
    if beta + reach * deviation < _SOFTENS:
        found.append(
            f"the form: the force grows more slowly than that of a sphere on a half-space (stiffening {beta:.2f}): the "
            f"sphere slips, stands over an edge, or the tissue yields{end}"
        )
    power = replace(best.case, exponent=True).solve()
    more = power.stiffening[0]
    if power.criterion < best.criterion - (0.0 if abs(more) > _TIP else _CLEARER):
        found.append(
            f"the form: the force grows with the depth to the power {1.5 + more:.2f}, which fits better "
            f"than 1.5 with stiffening {beta:.2f}: a tip that is no sphere (2: a cone, 1: a flat punch){end}"
        )
    return tuple(found)


def _unidentified(best: _Form, young: float, beta: float) -> tuple[str, ...]:
    """What the recording does not determine, in sentences; half widths of the intervals of log E and beta."""
    case, press = best.case, best.case.press
    found = [
        f"Poisson's ratio: {case.poisson:g} is assumed; the force determines E / (1 - nu^2) only",
    ]
    value = best.stiffening[0]
    if not np.isfinite(case.thickness):
        found.append("the thickness: a half-space is assumed, and a thin layer would appear stiffer")
        if case.stiffens and value - beta > _LAYERED:
            found.append(
                f"a layer: one on something harder grows stiffer with the depth, too, as this force does (stiffening "
                f"{value:.2f}); then the modulus is lower than stated, beyond its interval: give the thickness"
            )
    if young > _WIDE:
        found.append("the modulus: its interval is wider than half its value")
    deepest = (float(press.depth.max()) - best.touch) / case.radius
    if deepest < _SHALLOW:
        found.append(f"stiffening: the press ends at {deepest:.2f} radii, and needs {_SHALLOW:g} or more")
    elif beta > _VAGUE:
        found.append(
            f"stiffening: its interval is {100 * beta:.0f} % of the force at a depth of one radius to each side, which "
            "widens that of the modulus; hold several depths"
        )
    if press.depth[-1] > best.touch:
        found.append(
            "a drift that is not even, as of a sensor that warms up: it looks like relaxation; end off the tissue"
        )
    if best.touch < float(press.depth.min()) - 0.29 * case.radius:
        found.append("the first touch: it would lie before the first row; record from above the tissue")
    rate = np.abs(np.gradient(press.depth, press.t))
    rise = 0.3 * float((press.depth.max() - best.touch) / rate.max())  # of 0.3 of the depth, where the press is fastest
    if rise > 2.0 * _time_range(press.t)[0]:
        found.append(f"relaxation faster than {rise:.2g} s: the press is too slow; press faster")
    if not best.prony or np.mean(rate > 0.05 * rate.max()) > 0.8:
        found.append("relaxation: hold the depth for several seconds after the press")
    coloured = over_white(case.residuals(best.y))
    if coloured > _COLOURED:
        found.append(
            f"the form: the residual is {coloured:.2g} times its white noise. Coloured noise of the sensor is in the "
            "intervals; a tissue of another form (layers, an edge, a slope) is not"
        )
    return tuple(found)
