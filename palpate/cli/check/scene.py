"""`palpate check` of a scene: its objects, its fixtures, and the poses at the start."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.markup import escape
from rich.table import Table

from palpate.certificate.scene import warn_outside
from palpate.cli.check.mesh import warn_of_facets
from palpate.console.output import say
from palpate.contact import touchable
from palpate.mesh import Mesh
from palpate.scene import Scene
from palpate.scene.gains import felt_stiffness
from palpate.scene.guidance import LIVE
from palpate.scene.rig import Rig, build


def inspect(path: Path, console: Console) -> dict[str, Any]:
    """Print the objects, fixtures and initial poses of a scene; returns the values for JSON."""
    scene = Scene.load(path)
    rig = build(scene)
    rig.simulation()
    warn_outside(rig)
    table = Table(box=None, pad_edge=False)
    table.add_column("object")
    for heading in ("surface", "extents [mm]", "stiffness [N/m]", "felt [N/m]", "damping [N s/m]", "friction [-]"):
        table.add_column(escape(heading), justify="right")
    objects = []
    for i, (obj, surface) in enumerate(zip(scene.objects, rig.surfaces, strict=True)):
        felt, body = felt_stiffness(scene, i), surface.body
        mesh = body if isinstance(body, Mesh) else None
        extents = " x ".join(f"{1e3 * e:.0f}" for e in np.ptp(body.vertices, axis=0))
        kind = f"{mesh.report.triangles:,} triangles" if mesh else obj.source
        K, B = (" ".join(f"{x:g}" for x in dict.fromkeys(v)) for v in (obj.stiffness, obj.damping))
        table.add_row(obj.name, kind, extents, K, f"{felt:g}", B, f"{obj.friction:g}")
        row = {"name": obj.name, "felt_stiffness_N_per_m": felt, "surface": kind if mesh else str(body)}
        objects.append({**row, "mesh": mesh.report.to_json() if mesh else None})
        if mesh:
            warn_of_facets(touchable.fineness(mesh.core, max(obj.stiffness)), f"object {obj.name!r}")
    console.print(table)
    fixtures = _fixtures(rig, console)
    tool = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    millimetres = ", ".join(f"{1e3 * x:.1f}" for x in tool)
    say(console, f"tool at the start: ({millimetres}) mm in the world frame W; both arms reach the operator's path")
    condition = float(np.linalg.cond(rig.arms.leader.jacobian(rig.arms.q_leader0)[:3, :3]))
    say(
        console,
        f"leader at the start: 3x3 Jacobian of the wrist centre, condition {condition:.2f} (1: isotropic)",
    )
    start = {
        "p_WT_m": tool.tolist(),
        "q_leader_rad": rig.arms.q_leader0.tolist(),
        "leader_jacobian_condition": condition,
        "q_follower_rad_m": rig.arms.q_follower0.tolist(),
        "X_WL_m": rig.arms.X_WL.tolist(),
        "X_WB_m": rig.arms.X_WB.tolist(),
    }
    return {"objects": objects, "fixtures": fixtures, "start": start}


def _fixtures(rig: Rig, console: Console) -> list[dict[str, Any]]:
    """Print the scene's fixtures and their constraint values for the tool at the start; returns them for JSON."""
    if not rig.scene.guidance:
        return []
    X_WT = rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0)
    table, rows = Table(box=None, pad_edge=False), []
    for heading in ("fixture", "role", "law", "geometry", "attached to", "at the start"):
        table.add_column(heading)
    for fixture in rig.scene.guidance:
        asked = fixture.make(rig.here).ask(X_WT)
        gap, turns = float(asked["gap"]), bool(asked["turns"])
        size = f"{np.degrees(abs(gap)):.3g} deg" if turns else f"{1e3 * abs(gap):.3g} mm"
        live = fixture.frame.of in LIVE and fixture.frame.of != "tool"
        state = (
            f"waits for frame {fixture.frame.of}"
            if live
            else "inactive"
            if not np.isfinite(gap)
            else f"violated by {size}"
            if gap < 0
            else f"satisfied with {size} to spare"
        )
        law = f"{fixture.law.name}{', hard' if fixture.hard else ''}{'' if fixture.enabled else ', off'}"
        table.add_row(fixture.name, fixture.role.name, law, fixture.geometry.shape.key, fixture.frame.of, state)
        rows.append({"name": fixture.name, "role": fixture.role.name, "law": fixture.law.name, "hard": fixture.hard,
                     "geometry": fixture.geometry.shape.key, "frame": fixture.frame.of,
                     "gap_at_start": gap if np.isfinite(gap) else None})  # fmt: skip
        if live:
            frame = fixture.frame.of
            words = f"stays inactive until session.frames[{frame!r}].set(X) gives its frame"
            say(console, f"fixture {fixture.name!r} {words}")
    console.print(table)
    return rows
