"""Values of a scene that are possible, but most likely not meant: each is refused or warned of by its name."""

from __future__ import annotations

import itertools
import warnings

import numpy as np

from palpate.base.arrays import Array
from palpate.base.errors import FrameError, PalpateWarning, SceneError
from palpate.scene import placing
from palpate.scene.scene import Scene
from palpate.scene.sensors import SensorSection
from palpate.scene.surface import PlacedSurface, is_mesh

_HAND_BEARS = 50.0  # [N] above it no device of the field pushes, and no hand holds
_HAND_TURNS = 5.0  # [N m]
_WIDE = 2.0  # [m] an object wider than this is doubted
_WIDEST = 10.0  # [m] ... and refused: farther positions are not rendered
_FAR = 0.25  # [m] a margin or a range as wide as the body that is operated on
_GRID = np.array(list(itertools.product(np.linspace(0.0, 1.0, 9), repeat=3)))


def check_objects(scene: Scene, placed: list[PlacedSurface]) -> None:
    """Refuse objects of many metres, and warn of large ones: the numbers are most likely millimetres.

    Raises:
        SceneError: an object is wider than 10 m.
    """
    for i, (obj, one) in enumerate(zip(scene.objects, placed, strict=True)):
        wide = float(np.ptp(one.bounds, axis=0).max())
        if obj.source == "plane" or not np.isfinite(wide) or wide <= _WIDE:
            continue
        where = scene.where("objects", i, obj.source)
        what = f"objects[{i}].{obj.source}: {obj.name!r} is {wide:.4g} m wide"
        why = "numbers in a scene are metres" if obj.file is None else f"the file is read in {obj.unit or 'its unit'}"
        mend = "write 30 mm or 0.03 instead of 30" if obj.file is None else "give unit: mm"
        if wide > _WIDEST:
            raise SceneError(what, where=where, why=why, mend=mend)
        _warn(what, where, f"{mend}, if millimetres are meant")


def warn_of_coarse_grids(scene: Scene, placed: list[PlacedSurface]) -> None:
    """Warn of grids whose nodes are farther from each other than the radius of the tool's sphere."""
    if all(obj.sdf is None for obj in scene.objects):
        return
    from palpate.world.surfaces import DistanceGrid

    for obj in placed:
        if isinstance(obj.body, DistanceGrid) and obj.body.spacing.max() > scene.contact.radius:
            sizes = f"{1e3 * obj.body.spacing.max():.3g} mm between its nodes, {1e3 * scene.contact.radius:g} mm radius"
            what = f"the grid of {obj.body.name!r} is coarser than the tool's sphere: {sizes}"
            mend = "use a finer grid or a larger radius"
            warnings.warn(PalpateWarning(what, where=scene.file, mend=mend), stacklevel=3)


def warn_of_coarse_meshes(scene: Scene, placed: list[PlacedSurface]) -> None:
    """Warn of meshes whose facets the hand would feel (the paper's section 4)."""
    for obj, one in zip(scene.objects, placed, strict=True):
        if is_mesh(one.body):
            from palpate.scene.contact import touchable

            touchable.warn_of_facets(touchable.fineness_of(one.body, max(obj.stiffness)), f"object {obj.name!r}")


def check_press(scene: Scene, index: int, depth: float, wide: float) -> None:
    """Refuse an automatic path that presses deeper than the object is wide.

    Args:
        scene: the scene.
        index: the object that is palpated.
        depth: depth at which the object returns the intended force [m].
        wide: largest extent of the object [m].

    Raises:
        SceneError: the message names stiffness or Young's modulus.
    """
    obj = scene.objects[index]
    if obj.source == "plane" or obj.is_sensed or depth <= wide:  # before its first frame a sensed surface has no size
        return
    soft = obj.tissue is not None
    key = f"objects[{index}].{'tissue.young' if obj.tissue is not None else 'stiffness'}"
    value = f"{obj.tissue.material.young:g} Pa" if obj.tissue is not None else f"{max(obj.stiffness):g} N/m"
    raise SceneError(
        f"{key} = {value}: {obj.name!r} is too soft for the intended force of {scene.operator.palpate.force:g} N, "
        f"which it would return at a depth of {1e3 * depth:.3g} mm; it is {1e3 * wide:.3g} mm wide",
        where=scene.where("objects", index, "tissue", "young") if soft else scene.where("objects", index, "stiffness"),
        why="young is in Pa: organs have 1,000 to 100,000" if soft else "stiffness is in N/m: organs have 100 to 1,000",
        mend="write young: 6 kPa for 6 kPa, or press less: operator.palpate.force" if soft
        else "write stiffness: 400, or press less: operator.palpate.force",
    )  # fmt: skip


def warn_of_values(scene: Scene) -> None:
    """Warn of limits that limit nothing, and of fixtures of the size of a room."""
    s, rate = scene.stability, scene.rates.haptic
    for key, cap, most, unit in (("force_cap", s.force_cap, _HAND_BEARS, "N"),
                                 ("moment_cap", s.moment_cap, _HAND_TURNS, "N m")):  # fmt: skip
        if cap > most:
            what = f"stability.{key} = {cap:g} {unit}: a hand is not protected above {most:g} {unit}"
            _warn(what, scene.where("stability", key), f"write e.g. {key}: {3 if unit == 'N' else 0.3}")
    for key, cap, top, unit in (("rate_cap", s.rate_cap, s.force_cap, "N"),
                                ("moment_rate_cap", s.moment_rate_cap, s.moment_cap, "N m")):  # fmt: skip
        if top > 0.0 and cap / rate > top and key in s.model_fields_set:
            what = f"stability.{key} = {cap:g} {unit}/s limits nothing: it lets all {top:g} {unit} come in one tick"
            usual = f"{type(s).model_fields[key].default:g} {unit}/s"
            more = ", and more for stiff objects" if key == "rate_cap" else ""
            _warn(what, scene.where("stability", key), f"leave it out: it is then {usual}{more}")
    for i, fixture in enumerate(scene.guidance):
        for key, value in (("role.margin", fixture.role.margin), ("law.range", fixture.law.range)):
            if value > _FAR:
                what = f"guidance[{i}].{key} = {value:g} m: fixture {fixture.name!r} is as wide as a body"
                _warn(what, scene.where("guidance", i), f"write {value:g} mm, if millimetres are meant")


def warn_of_places(scene: Scene, placed: list[PlacedSurface], has_remote_centre: bool) -> None:
    """Warn of cameras that see no object, and of fixtures that the mechanism of the follower replaces."""
    for i, fixture in enumerate(scene.guidance):
        at = getattr(fixture.geometry, "point", None)
        if fixture.role.name == "rcm" and has_remote_centre and getattr(at, "at", None) == "rcm":
            what = f"guidance[{i}]: fixture {fixture.name!r} has no effect on {scene.arms.follower.model}"
            why = "its mechanism keeps the shaft in the remote centre"
            _warn(what, scene.where("guidance", i), "leave it out, or name another place: keep-rcm: entry", why)
    shown = [(obj.name, one) for obj, one in zip(scene.objects, placed, strict=True)
             if not obj.is_sensed and obj.presence != "virtual"]  # fmt: skip
    for name, sensor in scene.sensors.items():
        if sensor.simulated is not None and not any(_sees(scene, sensor, one) for _, one in shown):
            what = f"sensor {name!r} sees none of the real objects: {', '.join(n for n, _ in shown) or 'there is none'}"
            why = "a camera looks along the z axis of its pose, x to the right and y down"
            _warn(what, scene.where("sensors", name), "turn it with rpy_deg, e.g. [180, 0, 0] looks down", why)


def _sees(scene: Scene, sensor: SensorSection, one: PlacedSurface) -> bool:
    """True if a part of the object's box is in the picture and in the range of a simulated camera."""
    section = sensor.simulated
    assert section is not None
    try:
        X_WC = placing.graph(scene).pose(sensor.frame).X if sensor.frame != "world" else np.eye(4)
    except FrameError:  # refused by its name when the sensor is made
        return True
    if sensor.pose is not None:
        X_WC = X_WC @ sensor.pose.matrix()
    low, high = one.bounds
    points: Array = (low + _GRID * (high - low) - X_WC[:3, 3]) @ X_WC[:3, :3]
    half = np.tan(0.5 * np.radians(section.width_deg))
    z = points[:, 2]
    inside = (np.abs(points[:, 0]) <= half * z) & (np.abs(points[:, 1]) <= half * z * section.rows / section.columns)
    return bool((inside & (z >= section.near) & (z <= section.far)).any())


def _warn(what: str, where: str, mend: str, why: str = "") -> None:
    warnings.warn(PalpateWarning(what, where=where, why=why, mend=mend), stacklevel=4)
