"""Which mode of a scene's section ``remote`` is stable to which delay of the network."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from palpate.base.errors import PalpateError
from palpate.devices.certificate.scene import certificates
from palpate.scene.rig import Rig

SHORTEST, LONGEST = 0.001, 1.0  # delays between which is searched, by doubling [s]
_STEPS = 5  # of the bisection between the last stable delay and the double of it


@dataclass(frozen=True)
class RemoteLimits:
    """Largest round trips of a stable link; None: any."""

    mode: str
    """mode of the scene"""
    stiffness_N_per_m: float
    """stiffest surface of scene and site"""
    model_stable_to_ms: float | None
    """None: no loop closes over the network; the local loop is certified by itself"""
    passivity_stable_to_ms: float | None
    """None: each port may return what the other one has taken, at any delay (docs/network.md has its error)"""
    direct_stable_to_ms: float | None
    """by the certificate of the scene, with the round trip as delay of its loop"""

    def words(self) -> str:
        """One sentence."""
        direct = "any delay" if self.direct_stable_to_ms is None else f"{self.direct_stable_to_ms:.0f} ms"
        return (
            f"mode {self.mode}; model and passivity are stable at any delay, direct to a round trip of {direct} "
            f"at {self.stiffness_N_per_m:g} N/m with the scene's hand"
        )


def remote_limits(rig: Rig) -> RemoteLimits | None:
    """The limits of a scene; None if it has no section ``remote``, or if its control law is not covered.

    A force that comes back one round trip later is a force with this delay in the loop, so the direct mode is the
    scene's own certificate with that `loop_delay`; the first one that is not stable is found by doubling and
    bisection.
    """
    section = rig.scene.remote
    if section is None:
        return None
    K = max(section.site_stiffness or 0.0, *(float(obj.material.K.max()) for obj in rig.snapshot.objects))

    def stable(delay: float) -> bool:
        scene = rig.scene.model_copy(update={"loop_delay": delay})
        return all(one.k_max > K for one in certificates(scene, K, None, replace(rig, scene=scene)))

    try:
        return RemoteLimits(section.mode, K, None, None, _longest(stable))
    except PalpateError:
        return None


def _longest(stable: Callable[[float], bool]) -> float | None:
    """Largest delay up to which all are stable [ms]; None: all that were asked. Stability may return beyond it."""
    low, high = 0.0, SHORTEST
    while stable(high):
        low, high = high, 2.0 * high
        if high > LONGEST:
            return None
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return 1e3 * low
