"""A scene set up: meshes indexed, arms placed, path planned. What a simulation is made from."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
import yaml

from palpate import _core
from palpate.arm.gravity_model import GravityModel
from palpate.arrays import Array
from palpate.errors import PalpateWarning, RecordingError, SceneError
from palpate.guidance.here import Here
from palpate.hands import PRESETS
from palpate.scene import arms, force_source, gains, guidance, hand, surface, tool
from palpate.scene.scene import Scene
from palpate.surfaces import DistanceGrid


@dataclass(frozen=True)
class Rig:
    """Everything a run needs, checked."""

    scene: Scene
    surfaces: list[surface.Surface]
    snapshot: _core.Snapshot
    path: hand.HandPlan
    arms: arms.Arms
    spheres: list[tool.LinkSphere]  # of the tool beside the one on its tip
    here: Here  # what the names in the scene's fixtures stand for
    fixtures: _core.Fixtures  # of the scene's list `guidance`

    def options(self, seed: int | None = None) -> _core.SimulationOptions:
        """The core's options: its own defaults, with what the scene says on top."""
        scene, o = self.scene, _core.SimulationOptions()
        o.leader, o.follower = self.arms.leader.leader_options(), self.arms.follower.follower_options()
        o.rate, o.plant_rate = scene.rates.haptic, scene.rates.plant
        _fill(o, scene, "loop_delay", "loop_jitter")
        o.seed = scene.seed if seed is None else seed
        o.method = scene.contact.method
        _fill(o.contact, scene.contact, "radius", "collision_rate", "release")
        o.contact.spheres = [sphere.core for sphere in self.spheres]
        _fill(o.mapping, scene.mapping, "scale", "force_scale", "align_rate")
        o.torque = self._torque(o.leader)
        _fill(o.hand, scene.operator, "mass", "damping", "stiffness", "grip_force_max")
        _fill(o, scene.operator, "tremor")
        o.leader = self._spoilt(o.leader)  # after the torques: the controller knows the arm of the model file
        o.stability = self._stability(o)
        if not self.arms.leader.orients:
            o.mapping.align_rate = 0.0  # its handle does not turn: the tool keeps its orientation
        _fill(o.follower, scene.arms.follower, "bandwidth")
        force_source.fill(o, scene, self.arms.follower)
        o.X_WL, o.X_WB = self.arms.X_WL, self.arms.X_WB
        o.q_leader0, o.q_follower0 = self.arms.q_leader0, self.arms.q_follower0
        return o

    def _spoilt(self, leader: _core.LeaderOptions) -> _core.LeaderOptions:
        """The simulated arm with the imperfections that the scene asks for."""
        try:
            self.scene.arms.leader.spoil(leader, self.scene.rates.haptic)
        except ValueError as error:
            what, _, mend = str(error).partition(" | ")
            where = self.scene.where("arms", "leader", "encoder_step")
            raise SceneError(f"arms.leader.{what}", where=where, mend=mend) from None
        return leader

    def _stability(self, o: _core.SimulationOptions) -> _core.StabilityOptions:
        """Stability options. The layer knows encoders, mean delay, and a share of the friction in the model file."""
        section, s = self.scene.stability, _core.StabilityOptions()
        _fill(s, section, *(set(type(section).model_fields) - {"known_delay", "friction_share", "acceleration"}))
        mean_delay = o.loop_delay + 0.5 * o.loop_jitter + o.leader.drive_lag
        s.delay = mean_delay if section.known_delay is None else section.known_delay
        certain, A = max(section.friction_share - self.scene.torque.friction_gain, 0.0), o.leader.coupling
        step = o.leader.encoder_step if o.leader.quantised else 0.0 * o.leader.encoder_step
        friction, known = _core.CertainFriction(), o.torque.friction
        friction.coulomb, friction.viscous = certain * known.coulomb, certain * known.viscous
        friction.quantum = np.abs(A) @ step
        s.friction = friction
        leader, q = self.arms.leader, self.arms.q_leader0
        J, M = leader.jacobian(q)[:3], leader.mass_matrix(q) + np.diag(o.leader.rotor_inertia)
        lightest = 1.0 / float(np.linalg.eigvalsh(J @ np.linalg.solve(M, J.T)).max())  # of the handle, any direction
        thrown = section.force_cap / (lightest + PRESETS["relaxed"].mass)
        s.acceleration = section.acceleration or max(s.acceleration, thrown)
        s.quantum = float(np.linalg.norm((J @ A) * step, axis=0).max())
        return s

    def _torque(self, leader: _core.LeaderOptions) -> _core.TorqueOptions:
        """Torque options; the controller knows friction and rotors as the model file says them."""
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
        """The scene with its placements filled in: what a record needs to show the run again.

        absolute: with the files as found on this machine; otherwise as the scene names them, so that the text
        does not depend on where things lie.
        """
        data = self.scene.model_dump(mode="json")
        for i, thing in enumerate(self.scene.objects):
            if absolute and thing.file is not None:
                data["objects"][i][thing.source] = str(self.scene.path_of(i).resolve())
        arms = data["arms"]
        for side in ("leader", "follower"):
            path = self.scene.arm_path(side)
            if absolute and path is not None:
                arms[side]["model"] = str(path.resolve())
        for key in ("gravity_model", "plant_gravity_model"):
            file = self.scene.gravity_path(key)
            if absolute and file is not None:
                arms["leader"][key] = str(file.resolve())
        for section in guidance.files(data["guidance"]) if absolute else ():
            section["file"] = str(self.here.file(section["file"]).resolve())
        identified = self.scene.dynamics_path()
        if absolute and identified is not None:
            data["force"]["dynamics"] = str(identified.resolve())
        arms["leader"] |= {"base": _pose(self.arms.X_WL), "start": self.arms.q_leader0.tolist()}
        X_WT = self.arms.X_WB @ self.arms.follower.fk(self.arms.q_follower0)
        arms["follower"] |= {"base": _pose(self.arms.X_WB), "start": _pose(X_WT)}
        return str(yaml.safe_dump(data, sort_keys=False, allow_unicode=True))

    def gravity_model(self, key: str) -> GravityModel | None:
        """The identified model that the scene names under ``arms.leader.KEY``.

        Raises:
            SceneError: it cannot be read, or is of another arm.
        """
        path = self.scene.gravity_path(key)
        if path is None:
            return None
        try:
            held = GravityModel.load(path)
            held.require(self.arms.leader)
        except RecordingError as error:
            where = self.scene.where("arms", "leader", key)
            raise SceneError(error.what, where=where, why=error.why or str(path), mend=error.mend) from None
        return held

    def simulation(self, seed: int | None = None) -> _core.Simulation:
        """A fresh simulation at time zero.

        Raises:
            SceneError: the core refuses a combination of options; says which.
        """
        leader = self.arms.leader
        model = leader.with_scaled_masses(np.full(leader.n, self.scene.arms.leader.model_mass_scale))
        for key, arm in (("gravity_model", model), ("plant_gravity_model", leader)):
            held = self.gravity_model(key)
            if held is not None:
                arm.set_gravity_model(held.terms, held.theta)
        path = _core.HandPath(self.path.times.tolist(), self.path.positions_W)
        try:
            made = _core.Simulation(self.options(seed), leader, model, self.arms.follower, self.snapshot, path)
            made.set_fixtures(self.fixtures)
            return made
        except ValueError as error:
            raise SceneError(str(error), where=self.scene.file, mend="change this value in the scene") from None


def build(scene: Scene, bodies: surface.Bodies | None = None, until: float | None = None) -> Rig:
    """Set a scene up: read surfaces, index meshes, place arms, plan the path; refuse what cannot work.

    Args:
        scene: what to set up.
        bodies: surfaces that scenes share (`surface.placed`).
        until: time up to which the run may go, when it is known: an automatic path is planned no further [s].

    Raises:
        SceneError, MeshError, SurfaceError: what is wrong, where, why, and how to mend it.
    """
    gains.check_stiffness(scene)
    force_source.check_presence(scene)
    placed = surface.placed(scene, bodies)
    for thing in placed:
        if isinstance(thing.body, DistanceGrid) and thing.body.spacing.max() > scene.contact.radius:
            told = (
                f"{1e3 * thing.body.spacing.max():.3g} mm between its nodes, {1e3 * scene.contact.radius:g} mm radius"
            )
            what = f"the grid of {thing.body.name!r} is coarser than the tool's sphere: {told}"
            warnings.warn(PalpateWarning(what, where=scene.file, mend="a finer grid or a larger radius"), stacklevel=2)
    for i, thing in enumerate(placed):
        _warn_of_lost_regions(scene, i, thing)
    snapshot = surface.snapshot(scene, placed)
    check_method(scene, snapshot)
    path = hand.plan(scene, placed, until)
    both = arms.place(scene, placed, path)
    spheres = tool.tool_spheres(both.follower, scene.contact.spheres, scene.contact.whole_tool)
    around = guidance.here(scene, placed, both)
    rig = Rig(scene, placed, snapshot, path, both, spheres, around, guidance.fixtures(scene, around))
    for key in ("gravity_model", "plant_gravity_model"):
        rig.gravity_model(key)  # refused here, before anything runs
    rig.options()
    return rig


def _warn_of_lost_regions(scene: Scene, index: int, placed: surface.Surface) -> None:
    """A region that reaches nothing of its object: most likely a centre in millimetres, or in another frame."""
    for i, region in enumerate(scene.objects[index].regions):
        away = float(placed.body.core.nearest(np.array([region.at]))[0][0]) - region.reach
        if away > 0.0:
            what = f"region {region.name!r} lies {1e3 * away:.3g} mm beside {scene.objects[index].name!r}: never felt"
            where = scene.where("objects", index, "regions", i, "at")
            warnings.warn(
                PalpateWarning(what, where=where, mend="at is in metres, in the object's own frame"), stacklevel=3
            )


def check_method(scene: Scene, snapshot: _core.Snapshot) -> None:
    """Refuse a contact method that cannot feel one of the objects.

    Raises:
        SceneError: names the object.
    """
    try:
        _core.contact_check(scene.contact.method, _core.ContactOptions(), snapshot)
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
