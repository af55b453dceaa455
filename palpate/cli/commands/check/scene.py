"""`palpate check` of a scene: its objects, its fixtures, and the poses at the start."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from palpate.base.arrays import Array
from palpate.base.arrays.checks import finite_or_none
from palpate.cli.commands.check.tissue import TissueFindings, inspect_tissue, tissue_words, warn_of_tissue
from palpate.cli.terminal.output import say
from palpate.devices.certificate.scene import warn_outside
from palpate.scene import Scene, doubts
from palpate.scene.fixtures import LIVE
from palpate.scene.gains import felt_stiffness, touched_stiffness
from palpate.scene.rig import Rig, build
from palpate.scene.together import build_pairs, gap_at_start
from palpate.world.mesh import Mesh
from palpate.world.mesh.check import MeshReport
from palpate.world.surfaces import PointSurface
from palpate.world.tissue import Tissue

if TYPE_CHECKING:
    from palpate.cli.commands.check.device import DeviceFindings

_FIRST = 0.0
"""Time up to which an automatic path is planned [s]: its first periods, which are all that a check looks at."""


@dataclass(frozen=True)
class ObjectFindings:
    """An object of the scene."""

    name: str
    felt_stiffness_N_per_m: float
    surface: str
    mesh: MeshReport | None
    tissue: TissueFindings | None = None


@dataclass(frozen=True)
class FixtureFindings:
    """A fixture of the scene."""

    name: str
    role: str
    law: str
    hard: bool
    geometry: str
    frame: str
    gap_at_start: float | None  # constraint value [m or rad]; None while no constraint is active


@dataclass(frozen=True)
class Start:
    """Poses at the start; the names contain the units."""

    p_WT_m: Array  # (3,)
    q_leader_rad: Array  # (n,)
    leader_jacobian_condition: float | None  # of the 3x3 Jacobian of the wrist centre, 1: isotropic; None: a device
    q_follower_rad_m: Array  # (m,)
    X_WL_m: Array  # (4, 4)
    X_WB_m: Array  # (4, 4)


@dataclass(frozen=True)
class Findings:
    """What `palpate check` finds on a scene, as docs/json.md describes it."""

    objects: list[ObjectFindings]
    fixtures: list[FixtureFindings]
    start: Start
    device: DeviceFindings | None  # None: the leader is a simulated arm


@dataclass(frozen=True)
class PairsFindings:
    """What `palpate check` finds on a scene with several pairs."""

    pairs: dict[str, Findings]
    instruments_apart_m: float | None  # smallest distance between two instruments at the start
    handles_apart_m: float | None  # smallest distance between two handles at the start


def inspect(path: Path, console: Console, trust: bool = False) -> Findings | PairsFindings:
    """Print the objects, fixtures and initial poses of a scene, and return them."""
    scene = Scene.load(path, trust)
    if scene.pairs:
        return _inspect_pairs(scene, console)
    device = None
    if scene.arms.leader.driver is not None:
        from palpate.cli.commands.check.device import inspect_device

        device = inspect_device(scene)
    rig = build(scene, until=_FIRST) if device is None else device.rig
    rig.simulation()
    if device is None:
        warn_outside(rig)  # the certificate of a device needs its model: palpate device bench
    objects, fixtures = _objects(rig, console), _fixtures(rig, console)
    start = _start(rig, console, device is None)
    return Findings(objects, fixtures, start, None if device is None else device.tell(console))


def _inspect_pairs(scene: Scene, console: Console) -> PairsFindings:
    rigs = build_pairs(scene, until=_FIRST)
    found = {}
    for name, rig in rigs.items():
        say(console, name, "pair", "bold")
        rig.simulation()
        warn_outside(rig)
        objects, fixtures = _objects(rig, console), _fixtures(rig, console)
        found[name] = Findings(objects, fixtures, _start(rig, console, True), None)
    both = list(combinations(rigs.values(), 2))
    apart = min((gap_at_start(a, b) for a, b in both), default=np.inf)
    hands = [rig.arms.X_WL @ rig.arms.leader.fk(rig.arms.q_leader0)[:, 3] for rig in rigs.values()]
    near = min((float(np.linalg.norm(a - b)) for a, b in combinations(hands, 2)), default=np.inf)
    if both:
        say(console, f"at the start the instruments are {1e3 * apart:.1f} mm apart, the handles {1e3 * near:.0f} mm")
    return PairsFindings(found, finite_or_none(apart), finite_or_none(near))


def _objects(rig: Rig, console: Console) -> list[ObjectFindings]:
    table = Table(box=None, pad_edge=False)
    table.add_column("object")
    for heading in ("surface", "extents [mm]", "stiffness [N/m]", "felt [N/m]", "damping [N s/m]", "friction [-]"):
        table.add_column(escape(heading), justify="right")
    found = []
    for i, (obj, surface) in enumerate(zip(rig.scene.objects, rig.surfaces, strict=True)):
        felt, body = felt_stiffness(rig.scene, i), surface.body
        mesh = body if isinstance(body, Mesh) else None
        soft = inspect_tissue(body, rig.scene.contact.radius) if isinstance(body, Tissue) else None
        extents = " x ".join(f"{1e3 * e:.0f}" for e in np.ptp(body.vertices, axis=0))
        kind = f"{mesh.report.triangles:,} triangles" if mesh else f"{soft.tets:,} tetrahedra" if soft else obj.source
        K, B = (" ".join(f"{x:g}" for x in dict.fromkeys(v)) for v in (obj.stiffness, obj.damping))
        K, B = (K, B) if soft is None else (f"up to {touched_stiffness(rig.scene, i):.0f}", "tissue")
        table.add_row(obj.name, kind, extents, K, f"{felt:g}", B, f"{obj.friction:g}")
        found.append(ObjectFindings(obj.name, felt, kind if mesh else str(body), mesh.report if mesh else None, soft))
    console.print(table)
    doubts.warn_of_coarse_meshes(rig.scene, rig.surfaces)
    for obj, surface in zip(rig.scene.objects, rig.surfaces, strict=True):
        if isinstance(surface.body, PointSurface):
            say(console, f"{obj.name}: {surface.body}; the scene's radius is {1e3 * rig.scene.contact.radius:g} mm")
    for one in found:
        if one.tissue is not None:
            say(console, f"{one.name}: {tissue_words(one.tissue)}")
            warn_of_tissue(one.tissue, f"object {one.name!r}")
    return found


def _start(rig: Rig, console: Console, simulated: bool) -> Start:
    arms = rig.arms
    tool = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    millimetres = ", ".join(f"{1e3 * x:.1f}" for x in tool)
    reach = "both arms reach" if simulated else "the follower reaches"
    say(console, f"tool at the start: ({millimetres}) mm in the world frame W; {reach} the operator's path")
    condition = None
    if simulated:
        condition = float(np.linalg.cond(arms.leader.jacobian(arms.q_leader0)[:3, :3]))
        words = f"3x3 Jacobian of the wrist centre, condition {condition:.2f} (1: isotropic)"
        say(console, f"leader at the start: {words}")
    return Start(tool, arms.q_leader0, condition, arms.q_follower0, arms.X_WL, arms.X_WB)


def _fixtures(rig: Rig, console: Console) -> list[FixtureFindings]:
    """Print the scene's fixtures with their constraint values for the tool at the start, and return them."""
    if not rig.scene.guidance:
        return []
    X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    table, found = Table(box=None, pad_edge=False), []
    for heading in ("fixture", "role", "law", "geometry", "attached to", "at the start"):
        table.add_column(heading)
    for fixture in rig.scene.guidance:
        constraint = fixture.make(rig.context).evaluate(X_WT)
        gap, turns = float(constraint["gap"]), bool(constraint["turns"])
        live = fixture.frame.of in LIVE and fixture.frame.of != "tool"
        state = f"waits for frame {fixture.frame.of}" if live else _state(gap, turns)
        law = f"{fixture.law.name}{', hard' if fixture.hard else ''}{'' if fixture.enabled else ', off'}"
        name, role, shape, frame = fixture.name, fixture.role.name, fixture.geometry.shape.key, fixture.frame.of
        table.add_row(name, role, law, shape, frame, state)
        found.append(FixtureFindings(name, role, fixture.law.name, fixture.hard, shape, frame, finite_or_none(gap)))
        if live:
            words = f"stays inactive until session.frames[{frame!r}].set(X) gives its frame"
            say(console, f"fixture {name!r} {words}")
    console.print(table)
    return found


def _state(gap: float, turns: bool) -> str:
    if not np.isfinite(gap):
        return "inactive"
    size = f"{np.degrees(abs(gap)):.3g} deg" if turns else f"{1e3 * abs(gap):.3g} mm"
    return f"violated by {size}" if gap < 0 else f"satisfied with {size} to spare"
