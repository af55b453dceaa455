"""Mass, damping and stiffness of a hand that is pushed by 12 sinusoids, by their closed forms."""

from __future__ import annotations

import numpy as np

from palpate.arm.identify.hand import Grip, fit
from palpate_lab.verify.coverage.trial import RIGHT, Trial, of_intervals

COMMAND = "calibrate hand"
FORMS = {
    RIGHT: "load cell with a filter of first or second order, 60 to 100 Hz; the hand moves of its own",
    "friction": "0.1 N of friction in the cell; the hand rests",
    "saturation": "the cell saturates",
    "yielding": "fingertips of 2000 N/m in series",
}
_TRUE = np.array([0.2, 6.0, 250.0])  # kg, N s/m, N/m
_LINES = np.array([0.5, 1, 1.75, 2.5, 3.5, 5, 7.25, 9, 12, 15.5, 20, 25])  # Hz
_RATE, _SECONDS = 250.0, 28.0


def trial(form: str, rng: np.random.Generator) -> Trial:
    """One grip of 28 s."""
    t = np.arange(0.0, _SECONDS, 1.0 / _RATE)
    s = 2j * np.pi * np.fft.rfftfreq(len(t), 1.0 / _RATE)
    m, b, k = _TRUE
    Z, arm = m * s**2 + b * s + k, 0.5 * s**2 + 4.0 * s
    spring = 2000.0 if form == "yielding" else np.inf
    seen = Z / (1.0 + Z / spring)
    at = np.rint(_LINES * _SECONDS).astype(int)
    u = np.zeros(len(s), dtype=np.complex128)
    u[at] = 0.15 * len(t) * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, len(at)))
    X = u / (seen + arm)
    own = np.rint(np.array([0.61, 1.4, 3.11, 8.32]) * _SECONDS).astype(int)
    drive = np.zeros_like(u)
    drive[own] = (0.0 if form == "friction" else 5e-4) * len(t) * np.exp(1j * rng.uniform(0.0, 2.0 * np.pi, len(own)))
    moved = (k + b * s) * drive / (seen + arm)  # voluntary motion through the same hand
    part = s / (2.0 * np.pi * rng.uniform(60.0, 100.0))
    cell = 1.0 / (1.0 + part + (rng.choice([0.0, 0.5, 1.5]) * part**2 if form == RIGHT else 0.0))
    F = (u - arm * (X + moved)) * cell
    x, force, push = (np.fft.irfft(spectrum, len(t)) for spectrum in (X + moved, F, u))
    if form == "friction":
        force = force + 0.1 * np.tanh(np.gradient(x, 1.0 / _RATE) / 0.005)
    force = force + rng.normal(0.0, 0.05, len(t))
    if form == "saturation":  # of the amplifier, after the noise
        force = np.clip(force, -1.2 * force.std(), 1.2 * force.std())
    grip = Grip(_RATE, x + rng.normal(0.0, 2e-5, len(t)), force, push)
    found = fit(grip)
    told = any("another form" in text or "saturates" in text for text in found.warnings)
    return of_intervals(found.value, _TRUE, found.student * found.std, told)
