"""Checks before a run whether the force caps allow the stiffness that the scene requests."""

from __future__ import annotations

from palpate.base.errors import SceneError
from palpate.scene.model import ObjectSection
from palpate.scene.scene import Scene

#: Depth up to which the force must grow with stiffness K before it reaches the force cap.
LEAST_DEPTH = 0.001  # [m]
#: Speed of a careful finger, at which the force must follow K without reaching the rate cap.
LEAST_SPEED = 0.020  # [m/s]


def check_stiffness(scene: Scene) -> None:
    """Refuse a stiffness K that exceeds the force caps.

    The force on the hand is ``force_scale * K * depth``. It reaches ``force_cap`` within ``LEAST_DEPTH`` when
    ``K > force_cap / (force_scale * LEAST_DEPTH)``; it grows faster than ``rate_cap`` at ``LEAST_SPEED`` when
    ``K > rate_cap / (force_scale * LEAST_SPEED)``. Above the smaller of the two the hand would not feel K.

    Raises:
        SceneError: K is too large; the message names the object, the limit and the values to change.
    """
    section, scale = scene.stability, scene.mapping.force_scale
    cap, given = section.force_cap, "rate_cap" in section.model_fields_set
    rate = section.rate_cap if given else type(section).model_fields["rate_cap"].default
    by_force, by_rate = cap / (scale * LEAST_DEPTH), rate / (scale * LEAST_SPEED)
    for i, obj in enumerate(scene.objects):
        if obj.tissue is not None:
            continue  # its stiffness begins at zero and grows with depth
        K = obj.stiffest
        if min(by_force, by_rate) >= K:
            continue
        part, place = _where_stiffest(obj, K)
        if by_force <= by_rate:
            why = f"{cap:g} N (stability.force_cap) is reached after {1e3 * cap / (scale * K):.2g} mm of depth"
        else:
            growth = scale * K * LEAST_SPEED
            why = f"at {1e3 * LEAST_SPEED:g} mm/s the force would grow by {growth:.3g} N/s; "
            why += f"stability.rate_cap is {rate:g} N/s"
        raise SceneError(
            f"object {obj.name!r}{part}: stiffness {K:g} N/m is more than the caps allow",
            where=scene.where("objects", i, *place),
            why=why,
            mend=f"use at most {min(by_force, by_rate):.4g} N/m; or raise the cap, or lower mapping.force_scale",
        )


def _where_stiffest(obj: ObjectSection, K: float) -> tuple[str, tuple[str | int, ...]]:
    """Name and place in the scene file of the region with stiffness K, or of the object itself."""
    for i, region in enumerate(obj.regions):
        if region.stiffness is not None and K in region.stiffness and K not in obj.stiffness:
            return f", region {region.name!r}", ("regions", i, "stiffness")
    return "", ("stiffness",)


def touched_stiffness(scene: Scene, index: int) -> float:
    """Largest stiffness of object ``index`` without its regions [N/m]; of tissue for the sphere on the tool's tip."""
    obj = scene.objects[index]
    return max(obj.stiffness) if obj.tissue is None else obj.tissue.stiffness(scene.contact.radius)


def felt_stiffness(scene: Scene, index: int) -> float:
    """Stiffness of object ``index`` at the hand: scale * force_scale * force_gain * K, largest axis [N/m]."""
    gain = scene.mapping.scale * scene.mapping.force_scale * scene.torque.force_gain
    obj = scene.objects[index]
    return gain * (touched_stiffness(scene, index) if obj.tissue is not None else obj.stiffest)
