"""Sets up a scene for simulation: surfaces read and indexed, arms placed, path planned."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import yaml

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.arrays.yaml_loader import Dumper
from palpate.base.errors import PalpateWarning, RecordingError, SceneError
from palpate.scene import (
    arms,
    doubts,
    fixtures,
    force_source,
    gains,
    grip,
    hand,
    placing,
    port,
    surface,
    tool,
)
from palpate.scene.contact_method import loaded
from palpate.scene.guidance.context import FixtureContext
from palpate.scene.scene import Scene

if TYPE_CHECKING:
    from palpate.arm.gravity_model import GravityModel
    from palpate.scene.placed_ecm import PlacedEcm
    from palpate.world.frames import FrameGraph


@dataclass(frozen=True)
class Rig:
    """Checked inputs of a run."""

    scene: Scene
    surfaces: list[surface.PlacedSurface]
    snapshot: _core.Snapshot
    path: hand.HandPlan
    arms: arms.Arms
    spheres: list[tool.LinkSphere]  # additional spheres of the tool, without the one on its tip
    context: FixtureContext  # resolves the names in the scene's fixtures
    frames: FrameGraph  # of the scene, with arms and objects; sessions update its live frames
    fixtures: _core.FixtureList  # fixtures of the scene's list `guidance`
    ecm: PlacedEcm | None = None  # the endoscope arm

    def options(self, seed: int | None = None) -> _core.SimulationOptions:
        """The core's options: defaults, overridden by the values of the scene."""
        scene, o = self.scene, _core.SimulationOptions()
        o.leader, o.follower = self.arms.leader.leader_options(), self.arms.follower.follower_options()
        o.rate, o.plant_rate = scene.rates.haptic, scene.rates.plant
        _fill(o, scene, "loop_delay", "loop_jitter")
        o.seed = scene.seed if seed is None else seed
        o.method = scene.contact.method
        _fill(o.contact, scene.contact, "radius", "collision_rate", "release")
        planes = scene.remote is not None and scene.remote.planes  # an unknown surface of the remote site is one more
        o.contact.objects = max(o.contact.objects, len(self.snapshot.objects) + planes)
        o.contact.spheres = [sphere.core for sphere in self.spheres]
        if scene.graspable is not None:
            o.contact.spheres += [core for _, core in scene.graspable.spheres()]
        o.mapping = scene.mapping.fill(o.mapping)
        o.torque = self._torque(o.leader)
        _fill(o.hand, scene.operator, "mass", "damping", "stiffness", "grip_force_max")
        _fill(o, scene.operator, "tremor")
        o.leader = self._with_imperfections(o.leader)  # set after the torques, which use the model file
        o.stability = self._stability(o)
        grip.fill(o, scene)
        if not self.arms.leader.orients:
            o.mapping.align_rate = 0.0  # the handle cannot rotate, so the tool keeps its orientation
        _fill(o.follower, scene.arms.follower, "bandwidth")
        force_source.fill(o, scene, self.arms.follower)
        o.X_WL, o.X_WB = self.arms.X_WL, self.arms.X_WB
        o.q_leader0, o.q_follower0 = self.arms.q_leader0, self.arms.q_follower0
        return o

    def _with_imperfections(self, leader: _core.LeaderOptions) -> _core.LeaderOptions:
        """Options of the simulated arm with the imperfections of the scene."""
        try:
            self.scene.arms.leader.apply_imperfections(leader, self.scene.rates.haptic)
        except ValueError as error:
            what, _, mend = str(error).partition(" | ")
            where = self.scene.where("arms", "leader", "encoder_step")
            raise SceneError(f"arms.leader.{what}", where=where, mend=mend) from None
        return leader

    def _stability(self, o: _core.SimulationOptions) -> _core.StabilityOptions:
        """Stability options; `port` decides what the passivity layer assumes of the arm."""
        section, s = self.scene.stability, _core.StabilityOptions()
        of_port = {"known_delay", "delay_doubt", "friction_share", "acceleration"}
        _fill(s, section, *(set(type(section).model_fields) - of_port))
        port.apply(section, port.of_arm(self.arms.leader, self.arms.q_leader0, o, section.friction_share), s)
        return s

    def _torque(self, leader: _core.LeaderOptions) -> _core.TorqueOptions:
        """Torque options. The controller uses the friction and rotor inertia of the model file."""
        section, o = self.scene.torque, _core.TorqueOptions()
        _fill(o, section, "law", "mode", "force_gain", "gravity_gain", "platform_gain", "fast_force")
        if not self.arms.leader.has_platform:
            o.platform_gain = 0.0
        o.rotor_inertia = leader.rotor_inertia
        friction, limits, laws = o.friction, o.limits, o.laws
        friction.coulomb, friction.viscous = leader.coulomb, leader.viscous
        friction.gain, friction.dead_band = section.friction_gain, section.friction_dead_band
        friction.full_speed = 10.0 * section.friction_dead_band
        limits.gain, limits.margin = section.limit_gain, section.limit_margin
        _fill(laws, section, "shape_inertia", "virtual_mass", "virtual_damping", "servo_bandwidth")
        o.friction, o.limits, o.laws = friction, limits, laws
        return o

    def resolved_yaml(self, absolute: bool = False) -> str:
        """YAML text of the scene with the automatic placements filled in, from which a record can be shown again.

        absolute: True: file paths on this machine; False: paths as the scene names them, so that the text does not
        depend on the machine.
        """
        data = self.scene.model_dump(mode="json")
        for i, obj in enumerate(self.scene.objects):
            if absolute and obj.file is not None:
                name = str(self.scene.path_of(i).resolve())
                section = data["objects"][i]
                section[obj.source] = name if obj.cloud is None else section["cloud"] | {"file": name}
            if absolute and obj.tissue is not None and obj.tissue.volume is not None:
                volume = self.scene.path_to(obj.tissue.volume, self.scene.where("objects", i, "tissue"))
                data["objects"][i]["tissue"]["volume"] = str(volume.resolve())
        where = self.scene.where("bodies")
        for part in (part for body in data.get("bodies", ()) for part in body["parts"] if absolute and part["mesh"]):
            part["mesh"] = str(self.scene.path_to(part["mesh"], where).resolve())
        arms = data["arms"]
        for side in ("leader", "follower"):
            path = self.scene.arm_path(side)
            if absolute and path is not None:
                arms[side]["model"] = str(path.resolve())
        if absolute:
            arms["leader"]["driver"] = self.scene.resolved_driver()
        for key in ("gravity_model", "plant_gravity_model"):
            file = self.scene.gravity_path(key)
            if absolute and file is not None:
                arms["leader"][key] = str(file.resolve())
        for section in fixtures.files(data["guidance"]) if absolute else ():
            section["file"] = str(self.context.file(section["file"]).resolve())
        identified = self.scene.dynamics_path()
        if absolute and identified is not None:
            data["force"]["dynamics"] = str(identified.resolve())
        data["frames"] = [frame.model_dump(mode="json") for frame in placing.inlined(self.scene, self.frames)]
        arms["leader"]["frame"] = arms["follower"]["frame"] = "world"
        arms["leader"] |= {"base": _pose(self.arms.X_WL), "start": self.arms.q_leader0.tolist()}
        X_WT = self.arms.X_WB @ self.arms.follower.fk(self.arms.q_follower0)
        arms["follower"] |= {"base": _pose(self.arms.X_WB), "start": _pose(X_WT)}
        if self.ecm is not None:
            data["ecm"] |= {"base": _pose(self.ecm.X_WB), "joints": self.ecm.q0.tolist(), "camera": None}
        return str(yaml.dump(data, sort_keys=False, allow_unicode=True, Dumper=Dumper))

    def gravity_model(self, key: str) -> GravityModel | None:
        """The identified gravity model named under ``arms.leader.KEY``; None if the scene names none.

        Raises:
            SceneError: the file cannot be read, or belongs to another arm.
        """
        path = self.scene.gravity_path(key)
        if path is None:
            return None
        from palpate.arm.gravity_model import GravityModel

        try:
            model = GravityModel.load(path)
            model.require(self.arms.leader)
        except RecordingError as error:
            where = self.scene.where("arms", "leader", key)
            raise SceneError(error.what, where=where, why=error.why or str(path), mend=error.mend) from None
        return model

    def simulation(self, seed: int | None = None, options: _core.SimulationOptions | None = None) -> _core.Simulation:
        """A fresh simulation at time zero, by options() of the seed when none are given.

        Raises:
            SceneError: the core rejects a combination of options; the message names it.
        """
        leader = self.arms.leader
        model = leader.with_scaled_masses(np.full(leader.n, self.scene.arms.leader.model_mass_scale))
        for key, arm in (("gravity_model", model), ("plant_gravity_model", leader)):
            gravity = self.gravity_model(key)
            if gravity is not None:
                arm.set_gravity_model(gravity.terms, gravity.theta)
        path = self.path.core(self.scene.operator.grip)
        try:
            made = _core.Simulation(
                options or self.options(seed), leader, model, self.arms.follower, self.snapshot, path
            )
            made.set_fixtures(self.fixtures)
            return made
        except ValueError as error:
            raise SceneError(str(error), where=self.scene.file, mend="change this value in the scene") from None


def build(scene: Scene, bodies: surface.Bodies | None = None, until: float | None = None) -> Rig:
    """Set up a scene: check its values, read surfaces, index meshes, place arms and plan the path.

    Args:
        scene: the scene to set up.
        bodies: surfaces shared by several scenes (`surface.placed`).
        until: duration of the run, if known; an automatic path is planned only up to this time [s].

    Raises:
        SceneError, MeshError, SurfaceError: the scene is invalid; the message states where, why, and the correction.
    """
    if scene.pairs:
        what = f"the scene has several pairs: {', '.join(scene.pairs)}"
        mend = "palpate.PairsSession(scene) and palpate run take them all; scene.pair(NAME) is one of them"
        raise SceneError(what, where=scene.where("pairs"), mend=mend)
    gains.check_stiffness(scene)
    force_source.check_presence(scene)
    scene.mapping.require_device(scene.arms.leader.driver is not None, scene.where("mapping"))
    doubts.warn_of_values(scene)
    placed = surface.placed(scene, bodies)
    doubts.check_objects(scene, placed)
    doubts.warn_of_coarse_grids(scene, placed)
    snapshot = _snapshot(scene, placed)
    path = hand.plan(scene, placed, until)
    camera = _camera(scene, path)
    both = arms.place(scene, placed, path, None if camera is None else camera.R_WL)
    doubts.warn_of_places(scene, placed, both.follower.has_remote_centre)
    grip.check(scene, both.follower)
    spheres = tool.tool_spheres(both.follower, scene.contact.spheres, scene.contact.whole_tool)
    context = fixtures.fixture_context(scene, placed, both)
    frames = placing.whole_graph(scene, both.X_WL, both.X_WB)
    rig = Rig(scene, placed, snapshot, path, both, spheres, context, frames, fixtures.fixtures(scene, context), camera)
    for key in ("gravity_model", "plant_gravity_model"):
        rig.gravity_model(key)  # check the files before the run
    options = rig.options()
    if scene.torque.shape_inertia:
        from palpate.scene import shaping

        shaping.check_mass(scene, both, path, options)
    return rig


def _camera(scene: Scene, path: hand.HandPlan) -> PlacedEcm | None:
    """The endoscope arm of a scene at the start; None if the scene has none."""
    if scene.ecm is None:
        return None
    from palpate.scene import placed_ecm

    return placed_ecm.place(scene, scene.ecm, path)


MATERIALS = ("stiffness", "damping", "friction", "static_friction", "regions")
"""Keys of an object that `with_materials` can change."""


def with_materials(rig: Rig, scene: Scene) -> Rig:
    """The rig of a scene that differs from the rig's own in `MATERIALS` of its objects only.

    Surfaces, arms, frames and fixtures are those of the rig, and so is the path of the hand.

    Raises:
        SceneError: a value is invalid; the message states where, why, and the correction.
    """
    gains.check_stiffness(scene)
    return replace(rig, scene=scene, snapshot=_snapshot(scene, rig.surfaces))


def _snapshot(scene: Scene, placed: list[surface.PlacedSurface]) -> _core.Snapshot:
    """The objects for the core, checked."""
    for i, obj in enumerate(placed):
        _warn_of_lost_regions(scene, i, obj)
    snapshot = surface.snapshot(scene, placed)
    _require_regions_that_push(scene, snapshot)
    check_method(scene, snapshot)
    return snapshot


def _warn_of_lost_regions(scene: Scene, index: int, placed: surface.PlacedSurface) -> None:
    """Warn of regions that lie outside their object, most likely given in millimetres or in another frame."""
    for i, region in enumerate(scene.objects[index].regions):
        away = float(placed.body.core.nearest(np.array([region.at]))[0][0]) - region.reach
        if away > 0.0:
            what = (
                f"region {region.name!r} lies {1e3 * away:.3g} mm outside of {scene.objects[index].name!r}: never felt"
            )
            where = scene.where("objects", index, "regions", i, "at")
            warnings.warn(
                PalpateWarning(what, where=where, mend="at is in metres, in the object's own frame"), stacklevel=4
            )


def _require_regions_that_push(scene: Scene, snapshot: _core.Snapshot) -> None:
    """Refuse a soft region that would pull the tool in: the force of the contact would not be that of a spring."""
    for i, obj in enumerate(snapshot.objects):
        pull = _core.region_pull(obj)
        if pull is not None:
            what, mend = pull[1].rsplit("; ", 1)
            where = scene.where("objects", i, "regions", pull[0])
            what = what.replace(f"region {pull[0]} ", f"region {scene.objects[i].regions[pull[0]].name!r} ", 1)
            raise SceneError(what, where=where, why="its stiffness falls faster than the depth grows", mend=mend)


def check_method(scene: Scene, snapshot: _core.Snapshot) -> None:
    """Load the contact method, and refuse one that does not support one of the objects.

    Raises:
        SceneError: the message names the object.
    """
    try:
        _core.contact_check(loaded(scene.contact.method), _core.ContactOptions(), snapshot)
    except ValueError as error:
        raise SceneError(str(error), where=scene.where("contact"), mend="change contact.method") from None


def _fill(target: object, section: object, *names: str) -> None:
    for name in names:
        setattr(target, name, getattr(section, name))


def _pose(X: Array) -> dict[str, list[float]]:
    roll, pitch, yaw = np.degrees(
        [np.arctan2(X[2, 1], X[2, 2]), np.arctan2(-X[2, 0], np.hypot(X[0, 0], X[1, 0])), np.arctan2(X[1, 0], X[0, 0])]
    )
    return {"xyz": X[:3, 3].tolist(), "rpy_deg": [float(roll), float(pitch), float(yaw)]}
