"""Mass, damping and stiffness of a hand from a recorded grip, with confidence intervals.

The arm pushes the hand with a broadband force. Along the direction of that force the hand moves as

    F(t + T) = m x_tt + b x_t + k (x - x_path)

F is the force of the arm on the hand, from a load cell that lags by T behind the position x of the handle. x_path is
the position that the person intends: it drifts and trembles, and through the closed loop it moves x and F alike, so
F / x is biased. The intended motion is independent of the excitation u (position of a moving wall, or a force commanded
in open loop), so cross spectra with u are unbiased:

    S_uF(f) = H(f) (m S_ux_tt + b S_ux_t + k S_ux)      u is an instrumental variable (Ljung 1999, section 7.6)

H is that of the load cell: (1 + s T/n)^-n, from a low-pass of first order (n = 1) to a delay (n infinite), or a filter
of second order that overshoots, 1 / (1 + s T + (s T / 2 zeta)^2); others lie between. The fit is least squares over the
spectral lines f, each weighted by its coherence with u, and a mean over the forms of H, by their likelihood. The
confidence intervals come from leaving out one section of the recording at a time (jackknife), with Student's factor,
and the spread over the forms. The residual of each line over its scatter between sections tells a hand of another form.
Without u, x replaces u and the result carries a warning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from palpate.base.arrays import Array
from palpate.base.errors import RecordingError

Spectra = dict[str, NDArray[np.complex128]]

SEGMENT = 4.0  # length of a spectrum's segments, which overlap by half [s]
BAND = (0.4, 30.0)  # in which a hand is approximately of second order [Hz]
COHERENT = 0.6  # spectral lines of less coherence are left out
LEAST_LINES = 6
LEAST_SEGMENTS = 6
LEAST_MOTION = 5e-5  # least RMS motion of the handle [m]
_GOOD_FIT = 0.85  # fraction of the impedance that the second-order model should explain
_WIDE = 0.2  # relative half width of a confidence interval above which a warning is given
_LAG = (-0.004, 0.02)  # range that is searched for the load cell's lag [s]
_LAGS = 13  # lags that are tried at once
_FINEST = 1e-8  # distance of the lags at which the search ends [s]
_BLOCKS = 10  # sections of the jackknife
_IMPROBABLE = 1e-3  # probability of the lines' residuals below which the hand has another form
_EXACT = 1e-3  # error of a line relative to its force that the finite segments cause
_CLIPPED = 0.01  # share of values at the largest force from which on the load cell saturates
_OVERLAP = (2.0 / 3.0, 1.0 / 6.0)  # correlation of Hann's window between lines one and two apart


@dataclass(frozen=True)
class Grip:
    """A recorded grip along one direction."""

    rate: float
    """Sampling rate [Hz]."""
    x: Array
    """(n,) position of the handle [m]."""
    F: Array
    """(n,) force of the arm on the hand [N]."""
    u: Array | None = None
    """(n,) excitation independent of the hand: position of a wall, or a force; None if not recorded."""
    direction: tuple[float, float, float] | None = None
    """Unit vector in the leader's base; None if the recording does not give it."""
    source: str = ""
    """Path of the recording, for messages."""


@dataclass(frozen=True)
class Filter:
    """A form of the load cell's lag T: (1 + s T/order)^-order, or, of second order, with a damping ratio below 1."""

    order: float
    """Infinity: a delay."""
    damping: float = 1.0

    def response(self, f: Array, lag: float | Array) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Response (l,) at frequencies f [Hz], and the derivative of its logarithm by s [s]; (n, l) for lags (n, 1)."""
        x = 2j * np.pi * f * lag
        if self.damping < 1.0:
            second = 0.25 / self.damping**2
            down = 1.0 + x + second * x**2
            return np.asarray(1.0 / down), np.asarray(-lag * (1.0 + 2.0 * second * x) / down)
        if np.isinf(self.order):
            return np.asarray(np.exp(-x)), np.zeros(x.shape, dtype=np.complex128) - lag
        part = 1.0 + x / self.order
        return np.asarray(part**-self.order), np.asarray(-lag / part)

    def __str__(self) -> str:
        if self.damping < 1.0:
            return f"a filter of order 2 and damping {self.damping:g}"
        return "a delay" if np.isinf(self.order) else f"a filter of order {self.order:.2g}"


FILTERS = (
    *(Filter(n) for n in (1.0, 4.0 / 3.0, 2.0, 3.0, 6.0, np.inf)),
    *(Filter(2.0, zeta) for zeta in (0.85, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2, 0.1)),
)
"""Forms of the lag that are tried."""


@dataclass(frozen=True)
class HandFit:
    """The hand identified from a grip."""

    value: Array
    """(3,) mass [kg], damping [N s/m], stiffness [N/m]."""
    std: Array
    """(3,) standard deviations."""
    freedom: int
    """Degrees of freedom of the standard deviations."""
    lag: float
    """Lag of the force behind the position [s]."""
    lag_std: float
    """Its standard deviation [s]."""
    cell: Filter
    """Most probable form of the load cell's lag."""
    f: Array
    """(l,) spectral lines used [Hz]."""
    Z: NDArray[np.complex128]
    """(l,) measured impedance F / x [N/m]."""
    coherence: Array
    """(l,) coherence of each line with the excitation, 0..1."""
    explained: float
    """Fraction of the squared impedance that the second-order model explains."""
    misfit: float
    """Squared residuals of the lines over what their scatter explains; 1 for a hand of this form."""
    p_misfit: float
    """Probability of such residuals for a hand of this form."""
    seconds: float
    """Duration of the recording [s]."""
    warnings: tuple[str, ...]

    @property
    def resonance(self) -> float:
        """Natural frequency sqrt(k / m) / 2 pi [Hz]."""
        return float(np.sqrt(self.value[2] / self.value[0]) / (2 * np.pi))

    @property
    def interval(self) -> Array:
        """(3, 2) 95 % confidence intervals of `value`."""
        reach = self.student * self.std
        return np.stack([self.value - reach, self.value + reach], axis=1)

    @property
    def student(self) -> float:
        """Student's factor of the 95 % intervals."""
        from scipy.special import stdtrit

        return float(stdtrit(self.freedom, 0.975))

    def impedance(self, f: Array) -> NDArray[np.complex128]:
        """Impedance F / x of the fitted hand at frequencies f [Hz], as the load cell shows it, in N/m."""
        m, b, k = self.value
        w = 2 * np.pi * f
        return np.asarray((k - m * w**2 + 1j * w * b) * self.cell.response(f, self.lag)[0])


def fit(grip: Grip) -> HandFit:
    """Identify the hand of a grip.

    Raises:
        RecordingError: the recording is too short or too slow, has too little motion or coherence, has lines on one
            side of the resonance only, or gives a negative parameter. The message names the number and the remedy.
    """
    _check(grip)
    f, parts = _spectra(grip)
    whole = {key: S.sum(axis=0) for key, S in parts.items()}
    used, coherence = _lines(f, whole, grip)
    lines = f[used]
    Z = (whole["uF"] / whole["ux"])[used]
    weight = np.sqrt(coherence / (1.0 - np.minimum(coherence, 0.999))) / np.abs(whole["uF"][used])
    n = len(parts["ux"])
    blocks = np.array_split(np.arange(n), min(n, _BLOCKS))
    sums = [{key: S[block].sum(axis=0)[used] for key, S in parts.items()} for block in blocks]
    total = {key: S[used] for key, S in whole.items()}
    _require_hand(_solve(total, weight), lines, grip, lagging=True)
    forms = [_Lagged.of(total, lines, weight, cell) for cell in FILTERS]
    best = min(forms, key=lambda one: one.cost)
    share = _shares(forms, lines)
    x = np.asarray(share @ [one.x for one in forms])
    _require_hand(x[:3], lines, grip)
    left_out = np.array([_Lagged.of({k: total[k] - S[k] for k in total}, lines, weight, best.cell).x for S in sums])
    g = len(blocks)
    variance = (g - 1) / g * np.square(left_out - left_out.mean(axis=0)).sum(axis=0)
    std = np.sqrt(variance + share @ np.square([one.x - x for one in forms]))
    misfit, p = _lack_of_fit(best, sums, lines)
    bare = HandFit(
        x[:3], std[:3], g - 1, float(x[3]), float(std[3]), best.cell, lines, Z, coherence, 0.0, misfit, p,
        len(grip.x) / grip.rate, (),
    )  # fmt: skip
    apart = np.sum(np.abs(Z - bare.impedance(lines)) ** 2 / np.abs(Z) ** 2) / len(used)
    found = replace(bare, explained=float(1.0 - apart))
    return replace(found, warnings=_warn(found, grip))


def _check(grip: Grip) -> None:
    def refuse(what: str, why: str, mend: str) -> None:
        raise RecordingError(what, where=grip.source, why=why, mend=mend)

    signals = [grip.x, grip.F] + ([] if grip.u is None else [grip.u])
    if any(not np.isfinite(s).all() for s in signals):
        refuse("the recording holds values that are not finite", "", "cut those rows out, or record again")
    if grip.rate < 6.0 * BAND[1]:
        mend = "record at 1000 Hz"
        refuse(f"{grip.rate:g} Hz is too slow for a hand", f"{6 * BAND[1]:g} Hz or more are needed", mend)
    seconds = len(grip.x) / grip.rate
    least = SEGMENT * (LEAST_SEGMENTS + 1) / 2
    if seconds < least:
        refuse(f"{seconds:.1f} s of grip are too short", f"{least:g} s are needed", "hold the handle for 30 s")
    moved = float(np.std(grip.x - np.convolve(grip.x, np.ones(int(grip.rate)) / int(grip.rate), "same")))
    if moved < LEAST_MOTION:
        why = f"{1e3 * moved:.3g} mm rms; {1e3 * LEAST_MOTION:g} mm are needed"
        refuse("the handle hardly moves", why, "push with more force: scenes/grip.yaml does")


def _spectra(grip: Grip) -> tuple[Array, Spectra]:
    """Frequencies (l,) and the cross spectra (segments, l) that the fit needs, by pair."""
    n = round(SEGMENT * grip.rate)
    starts = np.arange(0, len(grip.x) - n + 1, n // 2)
    window, ramp = np.hanning(n), np.linspace(-1, 1, n)
    basis = np.stack([np.ones(n), ramp, ramp**2])
    basis = np.linalg.qr(basis.T)[0]

    def transform(signal: Array) -> NDArray[np.complex128]:
        cut = np.stack([signal[s : s + n] for s in starts])
        return np.asarray(np.fft.rfft(window * (cut - cut @ basis @ basis.T), axis=1))

    v = _derivative(grip.x, grip.rate)
    a = _derivative(v, grip.rate)
    X, V, A, J, F = (transform(signal) for signal in (grip.x, v, a, _derivative(a, grip.rate), grip.F))
    U = X if grip.u is None else transform(grip.u)
    f = np.asarray(np.fft.rfftfreq(n, 1.0 / grip.rate), dtype=np.float64)
    h = 2.0 * np.pi * f / grip.rate
    gain = np.divide(8.0 * np.sin(h) - np.sin(2.0 * h), 6.0 * h, out=np.ones_like(h), where=h > 0.0)
    gain[f > 2.0 * BAND[1]] = 1.0  # not used, and zero at half the rate
    V, A, J = V / gain, A / gain**2, J / gain**3
    pairs = {"ux": (U, X), "uv": (U, V), "ua": (U, A), "uj": (U, J), "uF": (U, F)}
    pairs |= {"uu": (U, U), "xx": (X, X), "FF": (F, F)}
    return f, {key: np.conj(a) * b for key, (a, b) in pairs.items()}


def _lines(f: Array, S: Spectra, grip: Grip) -> tuple[NDArray[np.intp], Array]:
    """Indices of the lines at which motion and force are coherent with the excitation, and their coherence."""

    def coherence(key: str, a: str) -> Array:
        return np.asarray(np.abs(S[key]) ** 2 / np.maximum((S["uu"] * S[a]).real, 1e-300))

    both = np.minimum(coherence("ux", "xx"), coherence("uF", "FF"))
    power = S["uu"].real
    good = (f >= BAND[0]) & (f <= BAND[1]) & (both >= COHERENT)
    good &= power > 1e-4 * power[(f >= BAND[0]) & (f <= BAND[1])].max()
    used = np.flatnonzero(good)
    if len(used) < LEAST_LINES:
        within = both[(f >= BAND[0]) & (f <= BAND[1])]
        raise RecordingError(
            f"only {len(used)} frequencies are coherent enough",
            where=grip.source,
            why=f"their median coherence with the excitation is {np.median(within):.2f}; {COHERENT:g} is needed",
            mend="push with a broadband force of about 1 N rms, as scenes/grip.yaml does, and hold the handle still",
        )
    return used, both[used]


def _derivative(x: Array, rate: float) -> Array:
    """Central differences of fourth order; `_spectra` corrects their gain."""
    padded = np.concatenate([x[:1], x[:1], x, x[-1:], x[-1:]])
    return np.asarray(rate * (padded[:-4] - 8 * padded[1:-3] + 8 * padded[3:-1] - padded[4:]) / 12)


def _solve(S: Spectra, weight: Array) -> Array:
    """(m, b, k) without lag, by weighted least squares of S_uF = m S_ua + b S_uv + k S_ux."""
    A = np.stack([S["ua"], S["uv"], S["ux"]], axis=1) * weight[:, None]
    y = S["uF"] * weight
    return np.asarray(
        np.linalg.lstsq(np.concatenate([A.real, A.imag]), np.concatenate([y.real, y.imag]), rcond=None)[0]
    )


@dataclass(frozen=True)
class _Lagged:
    """Mass, damping, stiffness and lag that fit the cross spectra of some lines."""

    x: Array  #: (4,)
    cell: Filter
    cost: float

    @staticmethod
    def of(S: Spectra, f: Array, weight: Array, cell: Filter) -> _Lagged:
        """Weighted least squares of S_uF = H (m S_ua + b S_uv + k S_ux); linear except for the lag.

        The lag is searched on a grid, then on finer ones between the neighbours of the best.
        """
        y, low, high = S["uF"] * weight, *_LAG
        while True:
            lags = np.linspace(low, high, _LAGS)
            columns = _lagged(S, f, lags[:, None], cell) * weight[:, None]  # (lags, l, 3)
            size = np.linalg.norm(columns, axis=1, keepdims=True)
            unit = columns / size
            adjoint = unit.conj().transpose(0, 2, 1)
            found = np.linalg.solve((adjoint @ unit).real, (adjoint @ y).real[..., None])  # (lags, 3, 1)
            cost = np.square(np.abs(y - (unit @ found)[..., 0])).sum(axis=1)
            k = int(np.argmin(cost))
            if lags[1] - low < _FINEST:
                return _Lagged(np.r_[found[k, :, 0] / size[k, 0], lags[k]], cell, float(cost[k]))
            low, high = lags[max(k - 1, 0)], lags[min(k + 1, _LAGS - 1)]

    def residual(self, S: Spectra, f: Array) -> NDArray[np.complex128]:
        """Residual S_uF - H (m S_ua + b S_uv + k S_ux) of the lines."""
        return np.asarray(S["uF"] - _lagged(S, f, float(self.x[3]), self.cell) @ self.x[:3])


def _lagged(S: Spectra, f: Array, lag: float | Array, cell: Filter) -> NDArray[np.complex128]:
    """Cross spectra (l, 3), or (n, l, 3), with acceleration, velocity and position as the load cell shows them.

    A line holds, within the window's width, motion of other frequencies s': H(s') = H(s) (1 + (s' - s) d ln H / ds),
    and s' times the motion is its derivative.
    """
    s = 2j * np.pi * f
    H, slope = cell.response(f, lag)
    pairs = (("ua", "uj"), ("uv", "ua"), ("ux", "uv"))
    columns = [S[key] + slope * (S[derivative] - s * S[key]) for key, derivative in pairs]
    return np.asarray(np.stack(columns, axis=-1) * H[..., None])


def _shares(forms: list[_Lagged], f: Array) -> Array:
    """Probabilities of the forms of the lag, for residuals of an unknown size."""
    freedom = max(2.0 * _independent(f) - 5.0, 1.0)
    cost = np.array([one.cost for one in forms])
    p = (cost.min() / np.maximum(cost, 1e-300)) ** (0.5 * freedom)
    return np.asarray(p / p.sum())


def _independent(f: Array) -> float:
    """Number of independent lines among f [Hz]: those within the window's width share noise."""
    steps = np.rint(np.abs(np.subtract.outer(f, f)) * SEGMENT)
    shared = sum(float((steps == k).sum()) * rho**2 for k, rho in enumerate(_OVERLAP, start=1))
    return len(f) / (1.0 + shared / len(f))


def _lack_of_fit(found: _Lagged, sums: list[Spectra], f: Array) -> tuple[float, float]:
    """Mean squared residual of the lines over the one that their scatter between sections explains; its probability.

    Each line's ratio follows F(2, 2 (g - 1)) for g sections. Their mean is compared with a gamma distribution of the
    same mean and variance; lines that lie within the window's width are not independent.
    """
    from scipy.special import gammaincc

    e = np.array([found.residual(S, f) for S in sums])  # (g, l)
    g, n = e.shape
    floor = np.square(_EXACT * np.abs(sum(S["uF"] for S in sums))) / g
    scatter = np.square(np.abs(e - e.mean(axis=0))).sum(axis=0) / (g - 1) + floor
    ratio = np.square(np.abs(e.sum(axis=0))) / g / scatter
    nu = 2.0 * (g - 1)
    mean = nu / (nu - 2.0) * (1.0 - 2.0 / n)  # four parameters of 2 n numbers
    variance = nu**2 * nu / ((nu - 2.0) ** 2 * (nu - 4.0))  # of F(2, nu)
    shape = mean**2 * _independent(f) / variance
    found_mean = float(ratio.mean())
    return found_mean / mean, float(gammaincc(shape, shape * found_mean / mean))


def _require_hand(value: Array, f: Array, grip: Grip, lagging: bool = False) -> None:
    """Check that a hand has these parameters and that lines on both sides of its resonance determine them.

    `lagging`: the lag of the force is not yet taken out, which may make one of the parameters negative.
    """
    names = ("mass", "damping", "stiffness")
    negative = [f"{name} {x:.3g}" for name, x in zip(names, value, strict=True) if not x > 0.0]
    if lagging and len(negative) == 1:
        return
    if negative:
        why = (
            "x or F has the wrong sign"
            if len(negative) > 1
            else "the motion was too small, or the person moved the hand"
        )
        mend = "F is the force of the arm on the hand, with x positive along F; hold still while the arm pushes"
        raise RecordingError(f"no hand has {' and '.join(negative)}", where=grip.source, why=why, mend=mend)
    f0 = float(np.sqrt(value[2] / value[0]) / (2 * np.pi))
    if f.min() > 0.7 * f0 or f.max() < 1.4 * f0:
        side, parameter = ("below", "stiffness") if f.min() > 0.7 * f0 else ("above", "mass")
        raise RecordingError(
            f"the {parameter} cannot be identified",
            where=grip.source,
            why=f"the hand resonates at {f0:.2g} Hz; coherent lines go from {f.min():.2g} to {f.max():.2g} Hz",
            mend=f"excite the hand {side} its resonance, too",
        )


def _warn(found: HandFit, grip: Grip) -> tuple[str, ...]:
    warnings = []
    if grip.u is None:
        warnings.append("nothing in the recording says what shook: the hand's own motions bias what is found")
    for name, value, std in zip(("mass", "damping", "stiffness"), found.value, found.std, strict=True):
        reach = found.student * std
        if reach > _WIDE * value:
            warnings.append(f"{name} is known to +-{100 * reach / value:.0f} % only: record longer, push more")
    if found.explained < _GOOD_FIT:
        warnings.append(
            f"a mass with spring and damper explains {100 * found.explained:.0f} % only: the grip changed, or it slid"
        )
    largest = float(np.abs(grip.F).max())
    ends = float(np.mean(np.abs(grip.F) > (1.0 - _EXACT) * largest))
    if ends > _CLIPPED:
        warnings.append(
            f"the load cell saturates: {100 * ends:.2g} % of its values are within a thousandth of {largest:.3g} N"
        )
    if found.p_misfit < _IMPROBABLE:
        warnings.append(
            f"the residuals are {np.sqrt(found.misfit):.2g} times what noise explains: the hand or the load cell has "
            "another form than a mass with spring, damper and lag, and the intervals do not cover that"
        )
    if not _LAG[0] + 1e-4 < found.lag < _LAG[1] - 1e-4:
        warnings.append(
            f"the force lags by {1e3 * found.lag:.3g} ms or more, the end of what is searched: synchronise the "
            "clocks of force and position"
        )
    return tuple(warnings)


@dataclass(frozen=True)
class Figures:
    """The figures of a fit: the documented contract of ``--json`` (docs/json.md). Intervals are (2,)."""

    mass_kg: float
    damping_N_s_per_m: float
    stiffness_N_per_m: float
    mass_kg_95: Array
    damping_N_s_per_m_95: Array
    stiffness_N_per_m_95: Array
    lag_s: float
    """Lag of the force behind the position."""
    lag_s_95: tuple[float, float]
    misfit: float
    """Squared residuals of the lines over what their scatter explains; 1 for a hand of this form."""
    p_misfit: float
    """Probability of such residuals for a hand of this form."""
    resonance_Hz: float
    lines: int
    """Number of spectral lines used."""
    band_Hz: tuple[float, float]
    coherence: float
    """Mean coherence of the lines with the excitation, 0..1."""
    explained: float
    direction: tuple[float, float, float] | None
    seconds: float
    warnings: tuple[str, ...]


def figures(grip: Grip, found: HandFit) -> Figures:
    """The figures of a fit."""
    m, b, k = (float(x) for x in found.value)
    return Figures(
        mass_kg=m,
        damping_N_s_per_m=b,
        stiffness_N_per_m=k,
        mass_kg_95=found.interval[0],
        damping_N_s_per_m_95=found.interval[1],
        stiffness_N_per_m_95=found.interval[2],
        lag_s=found.lag,
        lag_s_95=(found.lag - found.student * found.lag_std, found.lag + found.student * found.lag_std),
        misfit=found.misfit,
        p_misfit=found.p_misfit,
        resonance_Hz=found.resonance,
        lines=len(found.f),
        band_Hz=(float(found.f.min()), float(found.f.max())),
        coherence=float(found.coherence.mean()),
        explained=found.explained,
        direction=grip.direction or None,
        seconds=found.seconds,
        warnings=found.warnings,
    )
