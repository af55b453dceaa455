"""Exact stability analysis of the sampled loop of a virtual wall: which stiffness and damping keep it stable.

A linear plant (device and hand),

    x' = A x + b u,      y = c x   the handle's penetration of the wall [m]

is driven by a force that is computed at the instants k T and held for one period. It acts after ``delay``, which is l
whole periods plus f T. From one cycle to the next (Astrom and Wittenmark, Computer-Controlled Systems, 3.2)

    x[k+1] = Phi x[k] + Gamma0 u[k-l] + Gamma1 u[k-l-1],
    Phi = e^(A T),   Gamma0 = int_0^(T-f) e^(A s) ds b,   Gamma1 = e^(A (T-f)) int_0^f e^(A s) ds b

without approximation. U(z) and W(z) are the controller's transfer functions of position and velocity. The wall
u = -(K U y + B W y) has the characteristic equation

    1 + K P(z) + B Q(z) = 0,     P = U G,   Q = W G,   G(z) = c (z - Phi)^-1 (Gamma0 z^-l + Gamma1 z^-(l+1)).

On the unit circle, z = e^(i w T), these are two real equations that are linear in K and B. Each frequency gives one
gain (K, B) at which the loop oscillates with constant amplitude; these gains form the stability boundary (Neimark's
D-decomposition). For a given B, roots leave the circle at K = Re H where Im H = 0, with H(w) = -(1 + B Q) / P. The
smallest such K is the largest stable stiffness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from palpate import _core
from palpate.base.arrays import Array
from palpate.devices.certificate.exponential import expm

Complex = NDArray[np.complex128]
Path = Callable[[Complex], Complex]

_POINTS = 600  # number of logarithmically spaced frequencies
_PER_PERIOD = 30  # number of evenly spaced frequencies per turn of the delay's phase
_LOWEST = 1e-4  # lowest frequency of the grid, as a fraction of the Nyquist frequency
_RESONANT = 0.1  # damping ratio below which the grid is refined around a pole
_REFINEMENTS = 40  # bisection steps per crossing
_SECANTS = 10  # steps of the faster search that is tried first
_REFINED = 4  # number of lowest crossings that are refined
_PERTURBATION = 1e-9  # relative perturbation of A that separates equal poles
_NYQUIST = np.array([-1.0 + 0.0j])  # z at half the rate of the cycle, where all responses are real


def zero_order_hold(A: Array, b: Array, T: float) -> tuple[Array, Array]:
    """``e^(A T)`` (n, n) and ``int_0^T e^(A s) ds b`` (n,) from one matrix exponential."""
    n = len(A)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = A, b
    E = expm(block * T)
    return E[:n, :n], E[:n, n]


#: Eigenvalues (n,) of a matrix, its eigenvectors (n, n) and their inverse.
Modes = tuple[Complex, Complex, Complex]


def modes(A: Array) -> Modes:
    """Modes of A (n, n). Equal poles (critical damping) are separated by a relative perturbation of 1e-9."""
    poles, V = np.linalg.eig(A)
    if np.linalg.cond(V) > 1e10:
        noise = np.random.default_rng(0).normal(size=A.shape)
        poles, V = np.linalg.eig(A + _PERTURBATION * np.linalg.norm(A) * noise)
    return poles.astype(complex), V.astype(complex), np.linalg.inv(V).astype(complex)


def integral(poles: Complex, t: float) -> Complex:
    """``int_0^t e^(poles s) ds``."""
    x = poles * t
    small = np.abs(x) < 1e-8
    return np.where(small, t, np.expm1(np.where(small, 1.0, x)) / np.where(small, 1.0, poles))


def low_pass(T: float, cutoff: float) -> Path:
    """Transfer function of the cycle's first-order low pass with ``cutoff`` [Hz]; 0: no filter."""
    fraction = _core.low_pass_share(cutoff, T)
    return lambda z: fraction / (1.0 - (1.0 - fraction) / z)


def difference(T: float, cutoff: float = 0.0) -> Path:
    """``W(z)`` of the difference of two positions, low-pass filtered with ``cutoff`` [Hz]; 0: no filter."""
    smooth = low_pass(T, cutoff)
    return lambda z: smooth(z) * (1.0 - 1.0 / z) / T


@dataclass(frozen=True)
class SampledLoop:
    """A plant in a sampled loop. All values are in SI units; y > 0 is inside the wall."""

    A: Array
    """System matrix (n, n) of x' = A x + b u, without eigenvalues in the right half-plane."""
    b: Array
    """Input vector (n,) of a force along y."""
    c: Array
    """Output vector (n,) of y = c x."""
    T: float
    """Period of the cycle [s]."""
    delay: float
    """Time from the measurement to the force [s]."""
    position: Path = np.ones_like
    """U(z): transfer function from y to the position that the wall's spring uses."""
    velocity: Path = np.ones_like
    """W(z): transfer function from y, or from d x if d is given, to the velocity that the wall's damper uses."""
    d: Array | None = None
    """Output vector (n,) of a velocity d x that the plant measures directly."""
    force: Path = np.ones_like
    """Transfer function from the wall's force to the commanded force."""
    modes: Modes | None = None
    """``modes(A)`` if already computed."""
    parallel_stiffness: float = 0.0
    """Stiffness of springs (guidance fixtures) that act on y in parallel with the wall [N/m]."""

    def delayed(self, delay: float) -> SampledLoop:
        """This loop with another delay [s]."""
        return replace(self, delay=delay)

    @cached_property
    def _split(self) -> tuple[int, float]:
        """Number of whole periods in the delay, and the remainder [s]."""
        whole = int(np.floor(self.delay / self.T + 1e-9))
        return whole, max(self.delay - whole * self.T, 0.0)

    @cached_property
    def sampled(self) -> tuple[Array, Array, Array]:
        """Phi (n, n), Gamma0 (n,), Gamma1 (n,) from matrix exponentials."""
        f = self._split[1]
        Phi, _ = zero_order_hold(self.A, self.b, self.T)
        late, Gamma0 = zero_order_hold(self.A, self.b, self.T - f)
        return Phi, Gamma0, late @ zero_order_hold(self.A, self.b, f)[1]

    @cached_property
    def _modal(self) -> tuple[Complex, Complex, Complex, Complex, Complex]:
        """Eigenvalues of Phi, and Gamma0, Gamma1, c and d in modal coordinates, each (n,)."""
        poles, V, V_inverse = modes(self.A) if self.modes is None else self.modes
        late = self._split[1]
        early = self.T - late
        drive = V_inverse @ self.b
        Gamma0 = integral(poles, early) * drive
        Gamma1 = np.exp(poles * early) * integral(poles, late) * drive
        return np.exp(poles * self.T), Gamma0, Gamma1, self.c @ V, (self.c if self.d is None else self.d) @ V

    def P_and_Q(self, z: Complex) -> tuple[Complex, Complex]:
        """P(z) [m/N] and Q(z) [m/(N s)] at z (m,)."""
        y, v = self._responses(z)
        return self.position(z) * y, self.velocity(z) * v

    def _responses(self, z: Complex) -> tuple[Complex, Complex]:
        """Responses of y and of the velocity to the wall's force at z (m,), with the parallel springs connected."""
        poles, g0, g1, c, d = self._modal
        z = np.asarray(z, dtype=complex)
        late = self.force(z) * z ** -float(self._split[0])
        states = (g0 + g1 / z[:, None]) / (z[:, None] - poles) * late[:, None]  # (m, n)
        y = states @ c
        left = 1.0 / (1.0 + self.parallel_stiffness * y)
        return y * left, (states @ d) * left

    @cached_property
    def grid(self) -> Array:
        """Ascending w T (m,) below pi, dense enough to resolve the delay's phase and the plant's resonances."""
        turns = self.delay / self.T + 8.0
        wide = np.geomspace(np.pi * _LOWEST, np.pi, _POINTS)[:-1]
        even = np.linspace(0.0, np.pi, int(_PER_PERIOD * turns) + 2)[1:-1]
        poles = np.log(self._modal[0])
        swings = poles.imag[(poles.imag > 0.0) & (-poles.real < _RESONANT * np.abs(poles))]
        near = np.outer(swings, np.linspace(0.95, 1.05, 41)).ravel()
        every = np.sort(np.concatenate([wide, even, near[near < np.pi]]))
        return every[np.diff(every, prepend=0.0) > 0.0]  # np.unique would import numpy.ma

    @cached_property
    def _on_circle(self) -> tuple[Complex, Complex]:
        return self.P_and_Q(np.exp(1j * self.grid))

    def crossings(self, B: float) -> tuple[Array, Array]:
        """Lowest K > 0 [N/m] at which roots cross the circle for this B, ascending, and their frequencies [rad/s]."""

        def H(P: Complex, Q: Complex) -> Complex:
            return -(1.0 + B * Q) / P

        w, K = self._real_where(H(*self._on_circle), lambda z: H(*self.P_and_Q(z)))
        P, Q = self.P_and_Q(np.exp(1j * w))
        there = np.abs(1.0 + K * P + B * Q) < 1e-6  # excludes sign changes at a pole of H (P = 0)
        last = H(*self.P_and_Q(_NYQUIST)).real
        K, w = np.append(K[there], last), np.append(w[there], np.pi)
        order = np.argsort(K)
        order = order[K[order] > 0.0]
        return K[order], w[order] / self.T

    @cached_property
    def B_max(self) -> float:
        """The largest stable damping for K = 0 [N s/m]."""
        _, B = self._real_where(-1.0 / self._on_circle[1], lambda z: -1.0 / self.P_and_Q(z)[1])
        B = np.append(B, (-1.0 / self.P_and_Q(_NYQUIST)[1]).real)
        return float(B[B > 0.0].min(initial=np.inf))

    def _real_where(self, on_grid: Complex, f: Callable[[Complex], Complex]) -> tuple[Array, Array]:
        """w T at which f is real and positive, for the smallest such values, and these values."""
        im, re = on_grid.imag, on_grid.real
        change = np.flatnonzero(np.diff(np.signbit(im)))
        fraction = im[change] / (im[change] - im[change + 1])
        guess = re[change] + fraction * (re[change + 1] - re[change])
        near = np.maximum(re[change], re[change + 1]) > 0.0  # interpolation may give a small positive value below zero
        change = change[near][np.argsort(guess[near])][:_REFINED]
        low, high = self.grid[change], self.grid[change + 1]
        if not len(change):
            return low, low
        found = _illinois(lambda x: f(np.exp(1j * x)).imag, low, high, im[change], im[change + 1])
        there = f(np.exp(1j * found))
        if np.all(np.abs(there.imag) <= 1e-10 * np.abs(there.real)):
            return found, there.real
        below = np.signbit(im[change])  # a sign that changes at a pole, where the secant does not converge
        for _ in range(_REFINEMENTS):
            middle = 0.5 * (low + high)
            same = np.signbit(f(np.exp(1j * middle)).imag) == below
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        return low, f(np.exp(1j * low)).real

    def K_max(self, B: float) -> tuple[float, float]:
        """Largest stable K [N/m] for this B, and the frequency of the oscillation at this limit [rad/s].

        K is 0 if B or the parallel stiffness alone makes the loop unstable, and infinity if every stiffness is stable.
        """
        if self.parallel_stiffness > 0.0:
            alone = replace(self, parallel_stiffness=0.0, position=np.ones_like)
            if alone.K_max(B)[0] <= self.parallel_stiffness:
                return 0.0, 0.0
        if self.B_max <= B:
            return 0.0, 0.0
        K, w = self.crossings(B)
        return (float(K[0]), float(w[0])) if len(K) else (np.inf, 0.0)


def _illinois(f: Callable[[Array], Array], a: Array, b: Array, f_a: Array, f_b: Array) -> Array:
    """Roots of f between a and b (m,) after a few steps of the Illinois method (Dowell and Jarratt 1971, BIT 11)."""
    for _ in range(_SECANTS):
        c = (a * f_b - b * f_a) / (f_b - f_a)
        f_c = f(c)
        crossed = np.signbit(f_c) != np.signbit(f_b)
        a, f_a = np.where(crossed, b, a), np.where(crossed, f_b, 0.5 * f_a)
        b, f_b = c, f_c
    return b
