"""The scene file: sections named as the stages they set. Defaults of the stages come from the C++ core."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, model_validator

from palpate import _core
from palpate.scene.force import Presence
from palpate.scene.leader import ArmName, LeaderSection
from palpate.scene.solids import (
    SOLIDS,
    BoxSection,
    CapsuleSection,
    CylinderSection,
    ImplicitSection,
    PlaneSection,
    SphereSection,
)
from palpate.scene.stability import Share
from palpate.scene.tissue import Motions, RegionSection, require_sticking
from palpate.scene.tool import ToolSphereSection
from palpate.values import Diagonal, NotNegative, Pose, Positive, Section

_C = _core.SimulationOptions()
_M = _core.Material()


class FollowerSection(Section):
    """The patient-side arm, simulated and position-servoed: a da Vinci PSM, or one of yours."""

    model: ArmName = "psm_lnd"
    """which arm: a name (psm_lnd: a PSM with the large needle driver), or the path of a model file"""
    base: Pose | None = None
    """X_WB: the arm's base (a PSM's: its remote centre of motion) in the world; automatic when left out"""
    start: Pose | None = None
    """X_WT: the tool at the start; when left out, where the operator's path begins"""
    bandwidth: NotNegative = _C.follower.bandwidth
    """natural frequency of the joint servos; 0 = ideal [Hz]"""


class ArmsSection(Section):
    """Leader and follower."""

    leader: LeaderSection = LeaderSection()
    """the operator's arm"""
    follower: FollowerSection = FollowerSection()
    """the patient-side arm"""


class MappingSection(Section):
    """From the hand to the tool, and back for forces."""

    scale: Positive = _C.mapping.scale
    """tool motion per hand motion [-]; the felt stiffness is force_scale * scale * stiffness"""
    force_scale: Positive = _C.mapping.force_scale
    """force on the hand per force on the tool [-]"""
    align_rate: NotNegative = _C.mapping.align_rate
    """how fast an orientation offset of engaging decays; 0 keeps it [rad/s]"""


_SOURCES = ("mesh", "sdf", "shape", *SOLIDS)


class ObjectSection(Section):
    """Something to touch: one of mesh, sdf, shape, plane, sphere, box, cylinder, capsule, implicit."""

    name: str = ""
    """how plots and messages call it; the file's name when left out"""
    mesh: str | None = None
    """mesh file (STL, OBJ, PLY, ...), relative to the scene file; ${VARIABLE} and ${VARIABLE:-default} are replaced"""
    unit: Literal["mm", "cm", "m", "in"] = "mm"
    """unit of the numbers in the mesh file, and in a grid file that does not say it"""
    shape: Literal["organ", "gallbladder"] | None = None
    """instead of a mesh: a surface from Palpate's own generator"""
    triangles: Annotated[int, Field(strict=True, ge=2000, le=2_000_000)] = 30_000
    """about how many triangles the shape gets [-]"""
    sdf: str | None = None
    """instead: a file with a signed distance grid, .nrrd or .npz as palpate.surfaces.DistanceGrid.save writes it"""
    plane: PlaneSection | None = None
    """instead: the half-space below z = 0 of the object"""
    sphere: SphereSection | None = None
    """instead: a sphere around the object's origin"""
    box: BoxSection | None = None
    """instead: a box around the object's origin"""
    cylinder: CylinderSection | None = None
    """instead: a cylinder around the object's z axis"""
    capsule: CapsuleSection | None = None
    """instead: a cylinder with round ends around the object's z axis"""
    implicit: ImplicitSection | None = None
    """instead: the paper's implicit surface, an ellipsoid or a pillow"""
    pose: Pose = Pose()
    """X_WO: the object in the world; as in the file when left out"""
    stiffness: Diagonal = (_M.K[0], _M.K[1], _M.K[2])
    """one number, or one per axis of W [N/m]"""
    damping: Diagonal = (_M.B[0], _M.B[1], _M.B[2])
    """one number, or one per axis of W [N s/m]"""
    friction: NotNegative = _M.mu
    """Coulomb coefficient while the tool slips [-]"""
    static_friction: NotNegative | None = None
    """Coulomb coefficient while it sticks; as friction when left out [-]"""
    regions: Annotated[tuple[RegionSection, ...], Field(max_length=64)] = ()
    """where it feels otherwise; a later one lies over an earlier one"""
    motion: Motions = ()
    """how it moves: one motion, or a list of them that add up; it rests when left out"""
    presence: Presence = "both"
    """virtual: felt by the contact stage; real: met by the tool of a follower with drives (force.source)"""

    @model_validator(mode="after")
    def _whole(self) -> ObjectSection:
        require_sticking(self.friction, self.static_friction)
        given = [key for key in _SOURCES if getattr(self, key) is not None]
        if len(given) != 1:
            told = f"{' and '.join(given)} are given" if given else "none is given"
            mend = "keep one of them" if given else "name a mesh file, or e.g. sphere: {radius: 0.03}"
            raise ValueError(f"an object is one of {', '.join(_SOURCES)}; {told} | {mend}")
        return self

    @property
    def source(self) -> str:
        """What it is made from: ``mesh``, ``shape``, ``sdf``, ``plane`` ..."""
        return next(key for key in _SOURCES if getattr(self, key) is not None)

    @property
    def file(self) -> str | None:
        """The file it is read from, as the scene names it; None when it is made."""
        return self.mesh if self.mesh is not None else self.sdf


class ContactSection(Section):
    """How contact is found."""

    method: Literal["proxy", "penalty", "paper-plane", "paper-alg1", "face-normal", "approach-velocity"] = "proxy"
    """proxy: side memory, right deep inside; the others, for comparison, are told in docs/contact.md"""
    radius: Annotated[Positive, Field(le=0.1)] = _C.contact.radius
    """of the spherical proxy region (SPR) on the tool tip [m]"""
    collision_rate: Positive = _C.contact.collision_rate
    """rate of the collision thread of the paper's methods [Hz]"""
    whole_tool: bool = False
    """jaws, wrist and shaft touch, too, as spheres that the arm's model lists; otherwise the tip alone"""
    spheres: Annotated[tuple[ToolSphereSection, ...], Field(max_length=_core.MAX_SPHERES - 1)] = ()
    """more spheres of your own"""
    release: Positive = _C.contact.release
    """proxy: deflection at which a tool that went through a closed object is free [m]"""


class TorqueSection(Section):
    """Joint torques of the leader: the control law, and every term with its switch (docs/torque.md)."""

    law: Literal["stiffness", "impedance", "admittance"] = "stiffness"
    """stiffness: the paper's; impedance: Coriolis forces compensated; admittance: a virtual mass, by the load cell"""
    mode: Literal["full", "paper"] = "full"
    """paper: the first three joints only, wrist torques exactly zero, no moments"""
    force_gain: Share = _C.torque.force_gain
    """1 renders the force; 0 switches tau_force off [-]"""
    gravity_gain: NotNegative = _C.torque.gravity_gain
    """1 holds the arm's weight; 0 switches gravity compensation off [-]"""
    platform_gain: Share = _C.torque.platform_gain
    """of the dVRK's joint-4 controller, 0 to 1; MTMs only [-]"""
    friction_gain: Share = _C.torque.friction.gain
    """share of the arm's friction that is compensated; 0 switches it off [-]"""
    friction_dead_band: Positive = _C.torque.friction.dead_band
    """no friction compensation below this joint speed; whole at ten times as much [rad/s, m/s]"""
    limit_gain: Share = _C.torque.limits.gain
    """soft stops before the joint limits: share of the drive's limit; 0 switches them off [-]"""
    limit_margin: Annotated[Positive, Field(le=0.5)] = _C.torque.limits.margin
    """where they begin: share of the joint's range [-]"""
    shape_inertia: bool = _C.torque.laws.shape_inertia
    """impedance: the handle weighs virtual_mass, whatever the arm weighs; by the load cell"""
    virtual_mass: Annotated[Positive, Field(ge=0.05)] = _C.torque.laws.virtual_mass
    """of the handle: admittance, and impedance with shape_inertia [kg]"""
    virtual_damping: NotNegative = _C.torque.laws.virtual_damping
    """of the handle in admittance [N s/m]"""
    servo_bandwidth: Positive = _C.torque.laws.servo_bandwidth
    """of the position loop inside admittance [Hz]"""
    fast_force: Positive = _C.torque.fast_force
    """warn when the law leaves more inertia and Coriolis force than this to the hand [N]"""


class RatesSection(Section):
    """How often things happen."""

    haptic: Annotated[Positive, Field(le=10_000.0)] = _C.rate
    """haptic cycle [Hz]"""
    plant: Annotated[Positive, Field(le=100_000.0)] = _C.plant_rate
    """simulated arms and drives, at least [Hz]"""


class RecordSection(Section):
    """What is kept of a run."""

    folder: str = "runs"
    """where records and reports go, relative to where palpate is run; --out overrides it"""
    report: bool = True
    """write an HTML report beside the record"""
