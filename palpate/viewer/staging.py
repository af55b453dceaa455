"""Makes the viewer's stage from a rig or a record."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial

import numpy as np

from palpate import _core
from palpate.base.arrays import Array, rigid
from palpate.base.errors import PalpateError, RecordError
from palpate.base.values.units import FILE_UNITS
from palpate.devices.certificate import certify_all
from palpate.record import live
from palpate.record.reader import Record
from palpate.record.snapshots import CAMERA
from palpate.record.ticks import Ticks
from palpate.scene import held, materials, placing
from palpate.scene.gains import touched_stiffness
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.guidance.fixture import Fixture
from palpate.scene.guidance.plot import curve, drawing
from palpate.scene.model import ObjectSection
from palpate.scene.rig import Rig, build
from palpate.scene.scene import Scene
from palpate.scene.soft import is_soft, rest_shape
from palpate.scene.surface import PlacedSurface
from palpate.session import nearest
from palpate.session.recorded import body_track, recorded_scene, shape_track
from palpate.viewer.stage import (
    ArmPlace,
    DeviceMark,
    FixtureMark,
    PlacedFrame,
    RegionMark,
    Stage,
    TargetMark,
    TouchedObject,
)
from palpate.world.frames import FrameGraph
from palpate.world.mesh import Mesh
from palpate.world.mesh.coarse import MOST_TRIANGLES
from palpate.world.mesh.colors import colors_of

_NEAR, _AROUND_HAND = 0.2, 0.045  # [m]


def stage_of(rig: Rig, title: str = "") -> Stage:
    """The stage of a built scene, with its own copies of the arms."""
    scene, arms = rig.scene, rig.arms
    followers = [obj.name for obj in rig.snapshot.objects if obj.is_live]
    objects = [
        replace(
            _touched_object(each, placed, felt, followers.index(each.name) if felt.is_live else None),
            color=each.color,
            colors=None if each.color is not None or is_soft(felt) else file_colors(rig, k),
            is_cloud=each.cloud is not None,
            hidden=scene.remote is not None and each.name in scene.remote.hidden,
            holds=any(_lies_in(other, placed) for other in rig.surfaces if other is not placed),
        )
        for k, (each, placed, felt) in enumerate(zip(scene.objects, rig.surfaces, rig.snapshot.objects, strict=True))
    ]
    p_WH = arms.X_WL @ arms.leader.fk(arms.q_leader0)[:, 3]
    bounds = np.array([placed.bounds for placed in rig.surfaces])
    middle = 0.5 * (bounds[:, 0].min(axis=0) + bounds[:, 1].max(axis=0))
    first = _first_felt(scene)
    return Stage(
        title=title or scene.title,
        objects=objects,
        leader=ArmPlace("leader", scene.arm("leader"), arms.X_WL),
        follower=ArmPlace("follower", scene.arm("follower"), arms.X_WB),
        radius=scene.contact.radius,
        stiffness=float(f"{touched_stiffness(scene, scene.objects.index(first)):.3g}"),
        damping=max(first.damping),
        force_cap=scene.stability.force_cap,
        motion_scale=scene.mapping.scale,
        pseudo_haptic=scene.arms.leader.shows_force,
        focus=0.5 * (middle + p_WH[:3]),
        seen=_seen(bounds, p_WH[:3], (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3], scene),
        stable_below=stable_below(rig),
        spheres=tuple(rig.spheres),
        carried=() if scene.graspable is None else tuple(name for name, _ in scene.graspable.spheres()),
        rod=scene.graspable,
        frames=placed_frames(rig),
        targets=target_marks(rig),
        device=_device_mark(rig),
        ecm=rig.ecm,
        solids=tuple(held.solids(scene)),
        fixtures=tuple(fixture_mark(fixture, rig.context) for fixture in scene.guidance),
        extent=float(np.linalg.norm(middle - p_WH[:3]) + 0.5 * np.ptp(bounds, axis=(0, 1)).max()),
        near=partial(nearest.in_words, rig),
    )


def _device_mark(rig: Rig) -> DeviceMark | None:
    """The device of a scene; None for a simulated arm."""
    scene = rig.scene
    name, mapping = scene.arms.leader.driver, scene.mapping
    if name is None:
        return None
    size, centre = (None if v is None else np.array(v) for v in (mapping.workspace, mapping.centre))
    words = f"{mapping.law}, {mapping.scale:g} times the hand"
    return DeviceMark(name, rig.arms.X_WL, size, centre, words, float(mapping.scale))


def _first_felt(scene: Scene) -> ObjectSection:
    """The first object that the contact stage renders, or the first one."""
    return next((each for each in scene.objects if each.presence != "real"), scene.objects[0])


def _seen(bounds: Array, p_WH: Array, p_WT: Array, scene: Scene) -> Array:
    """Corners of the objects with bounds (m, 2, 3), and points around handle and tool tip: (n, 3) in W [m].

    The handle, which is dragged, also where the tool takes bodies and puts them down: it would go behind a panel.
    """
    near = np.clip(bounds, p_WT - _NEAR, p_WT + _NEAR)  # a plane or a table is wider than what happens on it
    corners = [[b[i, 0], b[j, 1], b[k, 2]] for b in near for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    around = _AROUND_HAND * np.vstack([np.eye(3), -np.eye(3)])
    place = None if scene.task is None else scene.task.place
    handled = [] if place is None else [body.pose.xyz for body in scene.bodies if body.free] + list(place.targets)
    handles = [p_WH + (np.array(p) - p_WT) / scene.mapping.scale for p in handled]
    return np.concatenate([np.array(corners), p_WT + around, *(p + around for p in [p_WH, *handles])])


def file_colors(rig: Rig, index: int) -> Array | None:
    """Colours (n, 3), 0 to 255, in the mesh file of an object for its drawn vertices; None without colours."""
    body = rig.surfaces[index].body
    if rig.scene.objects[index].mesh is None or not isinstance(body, Mesh):
        return None
    vertices, _ = rig.surfaces[index].drawable(MOST_TRIANGLES)
    return colors_of(rig.scene.path_of(index), vertices / FILE_UNITS[body.unit])


def _lies_in(inner: PlacedSurface, outer: PlacedSurface) -> bool:
    """True if most of a surface is inside another one, so that it can only be seen through it."""
    low, high = outer.bounds
    middle = inner.bounds.mean(axis=0)
    if np.any(middle < low) or np.any(middle > high):
        return False
    vertices = inner.body.vertices[:: max(1, len(inner.body.vertices) // 64)]
    points = vertices @ inner.X_WO[:3, :3].T + inner.X_WO[:3, 3]
    nearest, normals = outer.nearest(points)
    inside = np.einsum("ij,ij->i", points - nearest, normals) < 0.0
    return float(inside.mean()) > 0.7


def placed_frames(rig: Rig) -> tuple[PlacedFrame, ...]:
    """The frames of the scene; the live ones follow the poses in a tick."""
    graph, slots = rig.frames, {section.child: k for k, section in enumerate(placing.tracked_frames(rig.scene))}
    own = [name for name in graph.frames if name in {section.child for section in rig.scene.frames}]
    return tuple(
        PlacedFrame(
            name,
            graph.pose(name).X,
            graph.edge(name).kind == "live",
            _moving_frame(graph, name, slots) if graph.is_live(name) else None,
        )
        for name in own
    )


def target_marks(rig: Rig) -> tuple[TargetMark, ...]:
    """The targets of the scene's registration, with the error that the covariance of their frame predicts."""
    given = rig.scene.registration
    if given is None:
        return ()
    found = rig.frames.pose(given.frame)
    return tuple(
        TargetMark(
            name, rigid.transform(found.X, np.array([p]))[0], rigid.point_covariance(found.X, found.covariance, p)
        )
        for name, p in given.targets.items()
    )


def _moving_frame(graph: FrameGraph, name: str, slots: Mapping[str, int]) -> Callable[[Ticks], Array | None]:
    """Pose of a frame at a tick, which holds the nearest tracked frame above it."""
    above = name
    while above not in slots:
        above = graph.edge(above).parent
    slot, X_AF = slots[above], graph.pose(name, above).X

    def moving(tick: Ticks) -> Array | None:
        X_WA = live.frame_pose(tick, slot)
        return None if X_WA is None else X_WA @ X_AF

    return moving


def fixture_mark(fixture: Fixture, context: FixtureContext) -> FixtureMark:
    """Drawing of a fixture: its surface and the surface of its margin, or its curve."""
    geometry, role = fixture.make_geometry(context), fixture.role
    nothing = np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int32)
    body = drawing(geometry) if geometry.solid else nothing
    along = np.zeros((0, 3)) if geometry.solid else curve(geometry)
    level = -role.margin if role.name == "keep-in" else role.margin
    margin = drawing(geometry, level) if level else nothing
    if len(along) and float(np.ptp(along, axis=0).max()) < 1e-9:
        along = along[:1]
    seen = next((p for p in (along, body[0], margin[0]) if len(p)), np.zeros((1, 3)))
    frame = context.frame(fixture.frame.of)
    X0, X1 = frame.at(0.0)[0], frame.at(1.234)[0]
    is_posed = isinstance(frame, _core.LiveFrame) and frame.has_pose
    rests = fixture.frame.of == "world" or (np.array_equal(X0, X1) and not is_posed)
    return FixtureMark(
        fixture.name or role.name,
        role.name == "forbid",
        0.5 * (seen.min(axis=0) + seen.max(axis=0)),
        along[:: max(1, len(along) // 200)],
        *body,
        *margin,
        moving=None if rests else (lambda t: np.asarray(frame.at(t)[0] @ np.linalg.inv(X0))),
    )


def stable_below(rig: Rig) -> Callable[[float], float] | None:
    """Largest stiffness of the first object [N/m], for a damping [N s/m], at which all objects and regions are stable
    while the sliders scale them together. None for a loop that the certificate does not cover."""
    try:
        found = certify_all(rig.scene, rig=rig)
    except PalpateError:
        return None
    first = _first_felt(rig.scene)
    K, B_first = touched_stiffness(rig.scene, rig.scene.objects.index(first)), max(first.damping)

    def limit(B: float) -> float:
        grown = B / B_first if B_first > 0.0 else 1.0
        times = (one.cases[0].loop.K_max(one.B * grown)[0] / one.K for one in found if one.K)
        return K * min(times, default=np.inf)

    return limit


def stage_of_record(record: Record) -> Stage:
    """The stage of a record.

    Raises RecordError when the record holds no scene; SceneError or MeshError when the scene cannot be rebuilt, for
    instance because a mesh file has moved.
    """
    if not record.scene:
        raise RecordError(
            "the record holds no scene",
            where=str(record.path),
            why="another program rewrote it, or it was cut short",
            mend="show its numbers instead: palpate report",
        )
    stage = stage_of(build(recorded_scene(record)), record.path.parent.name)
    shapes = {
        k: track
        for k, obj in enumerate(stage.objects)
        if obj.soft and (track := shape_track(record, obj.name)) is not None
        if track.values.shape[1:] == obj.vertices.shape
    }
    camera = None if stage.ecm is None else record.snapshots(CAMERA)
    return replace(stage, shapes=shapes, camera=camera, bodies=body_track(record) if stage.solids else None)


def _touched_object(
    section: ObjectSection, placed: PlacedSurface, felt: _core.Object, slot: int | None
) -> TouchedObject:
    vertices, triangles = rest_shape(felt) or placed.drawable(MOST_TRIANGLES)
    middles = vertices[triangles].mean(axis=1)
    marks = [
        RegionMark(
            named.name,
            region.centre,
            region.half,
            region.radius,
            np.array([region.weight(p) > 0.5 for p in middles]),
        )
        for named, region in zip(section.regions, materials.regions(section), strict=True)
    ]
    moving: Callable[[float], Array] | None = felt.pose if section.motion else None
    return TouchedObject(
        section.name, vertices, triangles, placed.X_WO, tuple(marks), moving, slot=slot, soft=is_soft(felt)
    )
