"""Can the caps hold what the scene asks for? Asked before a run, answered with numbers."""

from __future__ import annotations

from palpate.errors import SceneError
from palpate.scene.model import ObjectSection
from palpate.scene.scene import Scene

#: A surface must be able to answer the first millimetre of a press; at the cap the force stops growing.
LEAST_DEPTH = 0.001  # [m]
#: And it must be able to answer as fast as a careful finger moves; at the rate cap the force lags behind.
LEAST_SPEED = 0.020  # [m/s]


def check_stiffness(scene: Scene) -> None:
    """Refuse a stiffness K that the caps cannot hold.

    The force on the hand is ``force_scale * K * depth``. It reaches ``force_cap`` within ``LEAST_DEPTH`` when
    ``K > force_cap / (force_scale * LEAST_DEPTH)``; it grows faster than ``rate_cap`` at ``LEAST_SPEED`` when
    ``K > rate_cap / (force_scale * LEAST_SPEED)``. Above the smaller of the two the hand would not feel K.

    Raises:
        SceneError: names the object, the limit and what to change.
    """
    cap, rate, scale = scene.stability.force_cap, scene.stability.rate_cap, scene.mapping.force_scale
    by_force, by_rate = cap / (scale * LEAST_DEPTH), rate / (scale * LEAST_SPEED)
    for i, thing in enumerate(scene.objects):
        K = stiffest(thing)
        if min(by_force, by_rate) >= K:
            continue
        part, place = _where_stiffest(thing, K)
        if by_force <= by_rate:
            why = f"{cap:g} N (stability.force_cap) is reached after {1e3 * cap / (scale * K):.2g} mm of depth"
        else:
            growth = scale * K * LEAST_SPEED
            why = f"at {1e3 * LEAST_SPEED:g} mm/s the force would grow by {growth:.3g} N/s; "
            why += f"stability.rate_cap is {rate:g} N/s"
        raise SceneError(
            f"object {thing.name!r}{part}: stiffness {K:g} N/m is more than the caps can hold",
            where=scene.where("objects", i, *place),
            why=why,
            mend=f"at most {min(by_force, by_rate):.4g} N/m; or raise the cap, or lower mapping.force_scale",
        )


def stiffest(thing: ObjectSection) -> float:
    """The largest stiffness of an object or of a region in it, along any axis [N/m]."""
    return max(max(K) for K in (thing.stiffness, *(r.stiffness for r in thing.regions)) if K is not None)


def _where_stiffest(thing: ObjectSection, K: float) -> tuple[str, tuple[str | int, ...]]:
    """In words, and in the scene file: the region that has the stiffness K, or the object itself."""
    for i, region in enumerate(thing.regions):
        if region.stiffness is not None and K in region.stiffness and K not in thing.stiffness:
            return f", region {region.name!r}", ("regions", i, "stiffness")
    return "", ("stiffness",)


def felt_stiffness(scene: Scene, index: int) -> float:
    """What the hand feels of object ``index``: scale * force_scale * force_gain * K, along its stiffest axis [N/m]."""
    gain = scene.mapping.scale * scene.mapping.force_scale * scene.torque.force_gain
    return gain * stiffest(scene.objects[index])
