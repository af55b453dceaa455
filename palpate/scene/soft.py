"""Section `tissue` of an object in a scene file: a soft body of tetrahedra instead of a stiffness."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field, model_validator

from palpate import _core
from palpate.base.arrays import Array
from palpate.base.errors import MeshError
from palpate.base.values import NotNegative, Positive, Section, Vector
from palpate.world import tissue
from palpate.world.tissue.bounds import HIGHEST_POISSON, MOST_TERMS, PERIOD

if TYPE_CHECKING:
    from pydantic import GetJsonSchemaHandler
    from pydantic.json_schema import JsonSchemaValue
    from pydantic_core import CoreSchema

    from palpate.world.mesh import Mesh
    from palpate.world.tissue import TetMesh, Tissue, TissueMaterial


def _known(name: str) -> str:
    if name not in tissue.PRESETS:
        raise ValueError(f"there is no tissue {name!r} | use one of {', '.join(tissue.PRESETS)}")
    return name


class _NamesOfPresets:
    """The presets in the schema of scenes, read when the schema is written."""

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        return {"enum": list(tissue.PRESETS)}


def is_soft(felt: _core.Object) -> bool:
    """True if an object deforms as a soft body."""
    return felt.surface.deforms


def rest_shape(felt: _core.Object) -> tuple[Array, NDArray[np.int32]] | None:
    """Surface of a soft object at rest, in the order in which a loop publishes it; None for a rigid object.

    Returns:
        Vertices (n, 3) in the object's frame O [m] and triangles (m, 3), wound outwards.
    """
    if not is_soft(felt):
        return None
    from palpate import _tissue

    assert isinstance(felt.surface, _tissue.TissueSurface | _tissue.SharedTissue)
    return felt.surface.vertices, felt.surface.triangles


def wait_for_bodies(snapshot: _core.Snapshot) -> None:
    """Let a loop that runs faster than real time wait for the threads of its soft bodies."""
    for felt in filter(is_soft, snapshot.objects):
        from palpate import _tissue

        if isinstance(felt.surface, _tissue.TissueSurface):
            felt.surface.set_patient(True)


def shared(snapshot: _core.Snapshot) -> _core.Snapshot:
    """The snapshot with soft bodies that several loops press: one body each."""
    if not any(map(is_soft, snapshot.objects)):
        return snapshot
    from palpate import _tissue

    return _tissue.share_bodies(snapshot)


PresetName = Annotated[str, AfterValidator(_known), _NamesOfPresets()]

_MATERIAL = ("young", "poisson", "density", "yeoh")


def _compressible(value: float) -> float:
    if not 0.0 <= value <= HIGHEST_POISSON:
        why = "an incompressible body has no finite bulk modulus" if value >= 0.5 else "the body would not be stable"
        raise ValueError(f"must lie from 0 to {HIGHEST_POISSON}: {why}. Got: {value:g} | 0.45 to 0.49 for soft tissue")
    return value


_Poisson = Annotated[
    float,
    Field(strict=True, json_schema_extra={"minimum": 0.0, "maximum": HIGHEST_POISSON}),
    AfterValidator(_compressible),
]


class SpotSection(Section):
    """A ball or a box in the object's frame."""

    at: Vector
    """centre in the object's frame [m]"""
    radius: NotNegative = 0.0
    """radius of a ball [m]"""
    box: tuple[Positive, Positive, Positive] | None = None
    """instead: lengths of a box along the object's axes [m]"""

    @model_validator(mode="after")
    def _check(self) -> SpotSection:
        if (self.box is None) == (self.radius == 0.0):
            raise ValueError("a ball or a box is needed | give either radius, or box: [x, y, z]")
        return self

    def contains(self, points: Array) -> Array:
        """Which points (n, 3) [m] lie inside, (n,) bool."""
        away = points - np.array(self.at)
        if self.box is None:
            return np.asarray(np.linalg.norm(away, axis=1) <= self.radius)
        return np.asarray((np.abs(away) <= 0.5 * np.array(self.box)).all(axis=1))


class PronySection(Section):
    """One term of the viscosity: a part of the shear modulus that relaxes."""

    g: NotNegative
    """relaxing shear modulus over the shear modulus at rest [-]"""
    tau: Positive
    """time constant [s]"""


class PartSection(SpotSection):
    """A part of the tissue with other moduli, such as a tumour or a vessel."""

    name: str = "part"
    """name in messages"""
    young: Positive
    """Young's modulus at rest [Pa]"""
    density: Positive | None = None
    """density; the tissue's when left out [kg/m^3]"""


class TissueSection(Section):
    """Soft tissue that deforms. Values that are left out are those of the preset."""

    preset: PresetName = "liver"
    """material with published values; palpate.world.tissue.PRESETS names its sources"""
    young: Positive | None = None
    """Young's modulus at small strain, after full relaxation [Pa]"""
    poisson: _Poisson | None = None
    """Poisson's ratio, below .5 [-]"""
    density: Positive | None = None
    """density [kg/m^3]"""
    yeoh: NotNegative | None = None
    """stiffening with strain: 0 for a Neo-Hookean solid [-]"""
    prony: Annotated[tuple[PronySection, ...], Field(max_length=MOST_TERMS)] | None = None
    """viscosity: parts of the shear modulus that relax"""
    resolution: Positive = 0.012
    """length of the edges of the tetrahedra that fill the object [m]"""
    volume: str | None = None
    """instead: file of tetrahedra, VTK, MSH or MEDIT, in the unit of the object; relative to the scene file"""
    fixed: tuple[SpotSection, ...] = ()
    """balls and boxes in which the tissue does not move; without any, and without springs, the tissue floats"""
    springs: NotNegative = 0.0
    """stiffness of the surroundings for each area of the surface [N/m^3]"""
    parts: Annotated[tuple[PartSection, ...], Field(max_length=16)] = ()
    """parts with other moduli; a later part covers an earlier one"""
    step: Positive | None = None
    """time step; when left out, the longest that needs little added mass [s]"""
    thread: Literal["auto", "cycle", "own"] = "auto"
    """where it steps: in every tick of the haptic cycle, or on a thread of its own; auto: by its size"""
    period: Annotated[Positive, Field(le=0.05)] = PERIOD
    """how long a thread of its own steps at once [s]"""

    @property
    def material(self) -> TissueMaterial:
        """The material of the tissue outside of its parts."""
        base = tissue.PRESETS[self.preset]
        given = {key: getattr(self, key) for key in _MATERIAL if getattr(self, key) is not None}
        values = {key: getattr(base, key) for key in _MATERIAL} | given
        prony = base.prony if self.prony is None else tuple((term.g, term.tau) for term in self.prony)
        return tissue.TissueMaterial(**values, prony=prony, source=base.source)

    def materials(self) -> list[TissueMaterial]:
        """The material of the tissue, and that of each part."""
        m = self.material
        return [m] + [
            tissue.TissueMaterial(p.young, m.poisson, p.density or m.density, m.yeoh, m.prony, p.name)
            for p in self.parts
        ]

    def stiffness(self, radius: float) -> float:
        """Largest stiffness for a sphere of a radius [m], by Hertz: a circle of contact as wide as the sphere [N/m]."""
        return 2.0 * radius * max(m.instantaneous / (1.0 - m.poisson**2) for m in self.materials())

    def depth(self, force: float, radius: float) -> float:
        """Depth at which the relaxed tissue returns a force [N] on a sphere of a radius [m], by Hertz [m]."""
        m = self.material
        return float((0.75 * force * (1.0 - m.poisson**2) / (m.young * np.sqrt(radius))) ** (2.0 / 3.0))

    def tetrahedra(self, mesh: Mesh, path: Path | None, unit: str, tell: Callable[[str], None]) -> TetMesh:
        """Tetrahedra of the object with the numbers of its parts: from a file, or filling a closed surface.

        Raises:
            MeshError, MissingExtraError: see `palpate.world.tissue.load` and `palpate.world.tissue.tetrahedralize`; a
                part, or a fixed spot, without any tetrahedra or nodes.
        """
        if path is None:
            made = tissue.tetrahedralize(mesh, self.resolution, tell=tell)
        else:
            made = tissue.load(path, unit)
            _require_same_size(made, mesh, unit)
        region = np.zeros(len(made.tets), dtype=np.int32)
        for i, part in enumerate(self.parts):
            inside = part.contains(made.centres)
            if not inside.any():
                mend = "at is in metres, in the object's frame; a part needs to be larger than the resolution"
                raise MeshError(f"no tetrahedron lies in part {part.name!r}", where=made.name, mend=mend)
            region[inside] = i + 1
        return tissue.TetMesh(made.nodes, made.tets, region, made.name)

    def make(self, mesh: TetMesh, name: str) -> Tissue:
        """The soft body at rest."""
        materials = self.materials()
        young, density = (np.array([getattr(m, key) for m in materials])[mesh.region] for key in ("young", "density"))
        m = materials[0]
        return tissue.Tissue(
            mesh,
            young=young,
            poisson=m.poisson,
            density=density,
            yeoh=m.yeoh,
            prony=m.prony,
            fixed=self.held(mesh),
            spring=self.springs * _areas(mesh),
            step=self.step or 0.0,
            thread=self.thread,
            period=self.period,
            name=name,
        )

    def floating(self, mesh: TetMesh, name: str) -> str:
        """What nothing holds: the body, or some of its parts; empty if all are held."""
        if self.springs > 0.0:
            return ""
        part = mesh.part
        loose = np.setdiff1d(part, part[self.held(mesh)])
        count = int(part.max()) + 1
        if len(loose) == count:
            return f"nothing holds {name!r}: it floats away when pushed"
        if len(loose) == 0:
            return ""
        size = int(np.isin(part[mesh.tets[:, 0]], loose).sum())
        return (
            f"{name!r} has {count} parts that share no node, and nothing holds {len(loose)} of them with {size:,} of "
            f"{len(mesh.tets):,} tetrahedra: they float away when pushed"
        )

    def held(self, mesh: TetMesh) -> Array:
        """Which nodes are fixed, (n,) bool.

        Raises:
            MeshError: a spot contains no node.
        """
        held = np.zeros(len(mesh.nodes), dtype=bool)
        for i, spot in enumerate(self.fixed):
            inside = spot.contains(mesh.nodes)
            if not inside.any():
                mend = "at is in metres, in the object's frame"
                raise MeshError(f"tissue.fixed[{i}] contains no node of the tissue", where=mesh.name, mend=mend)
            held |= inside
        return held


_OTHER_UNIT = 5.0
"""Ratio of the extents of a volume and its object from which they are in different units."""


def _require_same_size(volume: TetMesh, mesh: Mesh, unit: str) -> None:
    wide, expected = (float(np.ptp(points, axis=0).max()) for points in (volume.nodes, mesh.vertices))
    if expected / _OTHER_UNIT < wide < expected * _OTHER_UNIT:
        return
    raise MeshError(
        f"the volume is {1e3 * wide:.3g} mm wide, its object {1e3 * expected:.3g} mm",
        where=volume.name,
        why=f"both are read in the unit of the object, {unit}",
        mend="save the volume in the unit of the object",
    )


def _areas(mesh: TetMesh) -> Array:
    """Area of the surface that belongs to each node (n,): a third of its triangles [m^2]."""
    a, b, c = (mesh.nodes[mesh.surface[:, k]] for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(mesh.surface.ravel(), np.repeat(third, 3), len(mesh.nodes)).astype(np.float64)
