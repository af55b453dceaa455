"""Stability of a wall that presses several places of the tool at once, with forces and moments on the handle.

The plant of `loop` has six inputs, the wrench w on the handle, and six outputs, its position and rotation vector y. The
wall adds the wrench -(K U M y + B W N v), where the matrices M and N (6, 6) sum the springs and dampers of all places.
With G and G_v, the responses of y and of the twist v to w, and springs F of fixtures in parallel, the closed loop has
as many unstable poles as

    D(z) = det(I + F G + B W N G_v + K U M G)

has zeros outside the unit circle. D has no poles there, and D(infinity) = 1: the loop is stable if D(e^(i w T))
does not wind around zero (argument principle). For a given B, D is D_0 times the product of 1 + K mu_j with the
eigenvalues mu_j of (I + F G + B W N G_v)^-1 U M G, so that one set of eigenvalues serves all stiffnesses.

Between two frequencies the change of D's phase is known up to a whole turn. The gain at which the winding number
changes is the one at which such a change passes half a turn. If D turns fast there, because an axis is lightly damped,
the number changes too early: the frequencies are refined between these two until the gain no longer depends on them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from palpate.base.arrays import Array
from palpate.devices.certificate.loop import Complex, Modes, Path, SampledLoop, integral

_STIFFNESS = np.geomspace(1e-1, 1e6, 60)  # [N/m]
_DAMPING = np.geomspace(1e-2, 1e5, 60)  # [N s/m]
_BLOCK = 8  # number of gains that are scanned at a time
_FINE = 1.0002  # ratio of the bounds at which a bisection ends
_REFINED, _SAME = 32, 1e-3  # number of frequencies between two, and relative change of the gain at which this ends
_REFINEMENTS = 20  # largest number of intervals that are refined
#: det(I + F G) (m,), W N G_v and U M G (m, r, r) -> D_0 (m,), mu (m, r)
Determinant = Callable[[Any, Any, Any], tuple[Any, Any]]


@dataclass(frozen=True)
class CoupledLoop:
    """A plant in a sampled loop with a wall that acts on several places. All values are in SI units."""

    A: Array
    """System matrix (n, n) of x' = A x + b w, with all eigenvalues in the left half-plane."""
    b: Array
    """Input matrix (n, 6) of the wrench on the handle."""
    c: Array
    """Output matrix (6, n) of position and rotation vector of the handle."""
    d: Array
    """Output matrix (6, n) of its twist."""
    T: float
    """Period of the cycle [s]."""
    delay: float
    """Time from the measurement to the wrench [s]."""
    spring: Array
    """M (6, 6): wrench per displacement of the handle and K."""
    damper: Array
    """N (6, 6): wrench per twist of the handle and B."""
    fixtures: Array
    """F (6, 6): wrench per displacement of the handle of springs in parallel."""
    position: Path
    """U(z)."""
    velocity: Path
    """W(z)."""
    force: Path
    """Transfer function from the wall's wrench to the commanded wrench."""
    modes: Modes
    """``modes(A)``."""

    def delayed(self, delay: float) -> CoupledLoop:
        """This loop with another delay [s]."""
        return replace(self, delay=delay)

    @cached_property
    def _w(self) -> Array:
        """Angles w T on the upper half of the unit circle, from close to z = 1 to z = -1."""
        one = SampledLoop(self.A, self.b[:, 0], self.c[0], self.T, self.delay, modes=self.modes)
        return np.append(one.grid, np.pi)

    def responses(self, z: Complex) -> tuple[Complex, Complex]:
        """G and G_v at z (m,), each (m, 6, 6)."""
        poles, V, V_inverse = self.modes
        whole = int(np.floor(self.delay / self.T + 1e-9))
        late = max(self.delay - whole * self.T, 0.0)
        early = self.T - late
        now, before = integral(poles, early), np.exp(poles * early) * integral(poles, late)
        held = (now + before / z[:, None]) / (z[:, None] - np.exp(poles * self.T))
        held = held * (self.force(z) * z ** -float(whole))[:, None]
        states = held[:, :, None] * (V_inverse @ self.b)
        return (self.c @ V) @ states, (self.d @ V) @ states

    def _on_circle(self, w: Array) -> tuple[Any, Any, Any]:
        """det(I + F G) (m,); W N G_v and U M G, with F connected, on the wrenches that the wall exerts (m, r, r).

        By Sylvester's identity, det(I + Q X) = det(I + X Q) for wrenches Q (6, r). w (m,): angles on the circle.
        """
        z = np.exp(1j * w)
        G, G_v = self.responses(z)
        U, sizes, _ = np.linalg.svd(np.hstack([self.spring, self.damper]))
        Q = U[:, sizes > 1e-9 * sizes[0]]
        start = np.eye(6) + self.fixtures @ G
        wrenches = np.linalg.solve(start, np.broadcast_to(Q, (len(z), *Q.shape)))
        damped = self.velocity(z)[:, None, None] * (Q.T @ self.damper @ G_v @ wrenches)
        sprung = self.position(z)[:, None, None] * (Q.T @ self.spring @ G @ wrenches)
        return np.linalg.det(start), damped, sprung

    @cached_property
    def _on_grid(self) -> tuple[Any, Any, Any]:
        return self._on_circle(self._w)

    @cached_property
    def B_max(self) -> float:
        """The largest stable damping for K = 0 [N s/m]."""
        return self._limit(lambda start, damped, _: (start, np.linalg.eigvals(damped)), _DAMPING)[0]

    def K_max(self, B: float) -> tuple[float, float]:
        """Largest stable K [N/m] for this B, and the frequency of the oscillation at this limit [rad/s].

        K is 0 if B or the parallel springs alone make the loop unstable, and infinity if every stiffness is stable.
        """

        def determinant(start: Any, damped: Any, sprung: Any) -> tuple[Any, Any]:
            before = np.eye(damped.shape[-1]) + B * damped
            return start * np.linalg.det(before), np.linalg.eigvals(np.linalg.solve(before, sprung))

        K, w = self._limit(determinant, _STIFFNESS)
        return K, w / self.T if 0.0 < K < np.inf else 0.0

    def _limit(self, determinant: Determinant, scan: Array) -> tuple[float, float]:
        """Largest stable gain, and the angle w T at which the loop oscillates at this limit."""
        D_0, mu = determinant(*self._on_grid)
        # D is positive at z = 1, or beside a pole there: its phase begins at zero, below the lowest frequency.
        w, D_0, mu = np.insert(self._w, 0, 0.0), np.insert(D_0, 0, 1.0), np.insert(mu, 0, 0.0, axis=0)
        limit, i = _first_unstable(D_0, mu, scan)
        for _ in range(_REFINEMENTS):
            if limit == np.inf:
                break
            before, between = limit, np.linspace(w[i], w[i + 1], _REFINED + 2)[1:-1]
            D_between, mu_between = determinant(*self._on_circle(between))
            w, D_0 = np.insert(w, i + 1, between), np.insert(D_0, i + 1, D_between)
            mu = np.insert(mu, i + 1, mu_between, axis=0)
            limit, i = _first_unstable(D_0, mu, scan)
            if abs(limit - before) <= _SAME * before:
                break
        return limit, float(w[i])


def _first_unstable(D_0: Any, mu: Any, scan: Array) -> tuple[float, int]:
    """The smallest gain k at which D_0 prod(1 + k mu_j) winds around zero, and the interval where this begins.

    D_0 (m,), mu (m, r). In this interval the phase's change passes half a turn.
    """

    def turns(k: Array) -> Array:
        D = D_0 * np.prod(1.0 + k[:, None, None] * mu, axis=2)
        return np.asarray(np.angle(D[:, 1:] / D[:, :-1]))

    gains, low, high = np.concatenate([[0.0], scan]), 0.0, np.inf
    for block in np.array_split(gains, -(-len(gains) // _BLOCK)):
        unstable = np.abs(turns(block).sum(axis=1)) > 0.5 * np.pi
        if unstable.any():
            first = int(np.argmax(unstable))
            low, high = float(block[first - 1]) if first else low, float(block[first])
            break
        low = float(block[-1])
    while scan[0] <= low < high < np.inf and high / low > _FINE:
        middle = float(np.sqrt(low * high))
        stable = np.abs(turns(np.array([middle])).sum()) <= 0.5 * np.pi
        low, high = (middle, high) if stable else (low, middle)
    if high == np.inf:
        return high, 0
    before, after = turns(np.array([low, high]))
    return low if low >= scan[0] else 0.0, int(np.argmax(np.abs(after - before if high > 0.0 else after)))
