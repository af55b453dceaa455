"""Stability of a wall that presses several places of the tool at once, with forces and moments on the handle.

The plant of `loop` has six inputs, the wrench w on the handle, and six outputs, its position and rotation vector y. The
wall adds the wrench -(K U M y + B W N v), where the matrices M and N (6, 6) sum the springs and dampers of all places.
With G and G_v, the responses of y and of the twist v to w, and springs F of fixtures in parallel, the closed loop has
as many unstable poles as

    D(z) = det(I + F G + B W N G_v + K U M G)

has zeros outside the unit circle. D has no poles there, and D(infinity) = 1: the loop is stable if D(e^(i w T))
does not wind around zero (argument principle). For a given B, D is D_0 times the product of 1 + K mu_j with the
eigenvalues mu_j of (I + F G + B W N G_v)^-1 U M G, so that one set of eigenvalues serves all stiffnesses.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from palpate.arrays import Array
from palpate.certificate.loop import Complex, Modes, Path, SampledLoop, integral

_STIFFNESS = np.geomspace(1e-1, 1e6, 60)  # [N/m]
_DAMPING = np.geomspace(1e-2, 1e5, 60)  # [N s/m]
_FINE = 1.0002  # ratio of the bounds at which a bisection ends


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
    def _z(self) -> Complex:
        """Points on the upper half of the unit circle, from close to z = 1 to z = -1."""
        one = SampledLoop(self.A, self.b[:, 0], self.c[0], self.T, self.delay, modes=self.modes)
        return np.exp(1j * np.append(one.grid, np.pi))

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

    @cached_property
    def _on_circle(self) -> tuple[Any, Any, Any]:
        """det(I + F G) (m,); W N G_v and U M G, with F connected, on the wrenches that the wall exerts (m, r, r).

        By Sylvester's identity, det(I + Q X) = det(I + X Q) for wrenches Q (6, r).
        """
        z = self._z
        G, G_v = self.responses(z)
        U, sizes, _ = np.linalg.svd(np.hstack([self.spring, self.damper]))
        Q = U[:, sizes > 1e-9 * sizes[0]]
        start = np.eye(6) + self.fixtures @ G
        wrenches = np.linalg.solve(start, np.broadcast_to(Q, (len(z), *Q.shape)))
        damped = self.velocity(z)[:, None, None] * (Q.T @ self.damper @ G_v @ wrenches)
        sprung = self.position(z)[:, None, None] * (Q.T @ self.spring @ G @ wrenches)
        return np.linalg.det(start), damped, sprung

    @cached_property
    def B_max(self) -> float:
        """The largest stable damping for K = 0 [N s/m]."""
        start, damped, _ = self._on_circle
        return _first_unstable(start, np.linalg.eigvals(damped), _DAMPING)

    def K_max(self, B: float) -> tuple[float, float]:
        """Largest stable K [N/m] for this B, and the frequency of the oscillation at this limit [rad/s].

        K is 0 if B or the parallel springs alone make the loop unstable, and infinity if every stiffness is stable.
        """
        start, damped, sprung = self._on_circle
        before = np.eye(damped.shape[-1]) + B * damped
        mu = np.linalg.eigvals(np.linalg.solve(before, sprung))
        K = _first_unstable(start * np.linalg.det(before), mu, _STIFFNESS)
        if not 0.0 < K < np.inf:
            return K, 0.0
        nearest = np.argmin(np.abs(1.0 + K * mu).min(axis=1))
        return K, float(np.angle(self._z[nearest])) / self.T


def _first_unstable(D_0: Any, mu: Any, scan: Array) -> float:
    """The smallest gain k at which D_0 prod(1 + k mu_j) winds around zero; D_0 (m,), mu (m, r)."""

    def winds(k: Array) -> NDArray[np.bool_]:
        D = D_0 * np.prod(1.0 + k[:, None, None] * mu, axis=2)
        return np.asarray(np.abs(np.angle(D[:, 1:] / D[:, :-1]).sum(axis=1)) > 0.5 * np.pi)

    unstable = winds(np.concatenate([[0.0], scan]))
    if unstable[:2].any():
        return 0.0
    if not unstable.any():
        return float(np.inf)
    first = int(np.argmax(unstable)) - 1
    low, high = float(scan[first - 1]), float(scan[first])
    while high / low > _FINE:
        middle = float(np.sqrt(low * high))
        low, high = (low, middle) if winds(np.array([middle]))[0] else (middle, high)
    return low
