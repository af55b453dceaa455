"""Figs 5, 8 and 12, Algorithm 1, and the mesh that is dense enough: contact with triangle meshes."""

from __future__ import annotations

from functools import partial
from html import escape
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from palpate.base.arrays import Array
from palpate.base.errors import MissingExtraError
from palpate.base.plotting.style import CAP, FORCE, INK, MUTED, TOOL, Canvas, plain_ticks
from palpate.scene.contact import touchable
from palpate.scene.contact.algorithm1 import trace_algorithm1
from palpate.scene.contact.judging import PATHS, RADIUS, STIFFNESS, judge
from palpate.scene.contact.rendering import render
from palpate.world.mesh import Mesh
from palpate.world.shapes.analytic import SHAPES, Sphere
from palpate.world.shapes.paths import tool_path
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.reproduce.items.palpation import Palpation, palpation
from palpate_lab.studies.figure12 import figures as figure12

_POSES = 1000  # random poses on which contacts are compared with brute force [-]
_FACES = (80, 320, 1280, 5120, 20_480)  # triangles of the sphere in the item `mesh` [-]
_CURVATURE = 0.03  # radius of that sphere [m]
_METHODS = ("proxy", "face-normal", "paper-alg1")


def fig5(work: Work) -> Outcome:
    """The instrument in an organ and a skeleton; contacts against brute force."""
    from palpate.planning import geometry
    from palpate_lab.studies.collisions import figures
    from palpate_lab.studies.collisions.work import STEPS, run, scene

    try:
        import nrrd  # noqa: F401 - the skeleton is read from an .nrrd file
    except ImportError as error:
        raise MissingExtraError("what reads the skeleton's volume", "files") from error
    geometry.require()
    result, found, world = run(work.folder, None, None, _POSES)
    robot = scene(work.folder, None, None)[0]
    brute = result["brute_force"]
    touching = {row["mesh"] for row in result["pairs"]}
    good = brute["disagreements"] == 0 and brute["touching"] > 0 and {"liver", "skeleton"} <= touching
    return Outcome(
        "agrees" if good else "differs",
        {
            "pairs": result["pairs"], "links": result["links"], "triangles": result["triangles"],
            "disagreements_with_brute_force": brute["disagreements"], "poses_compared": brute["poses"],
            "largest_distance_error_m": brute["worst_distance_error_m"],
        },
        "collision points of an instrument with a mesh and with a skeleton, one or more for each pair",
        f"{len(result['pairs'])} pairs of a link and a mesh touch in a sweep of {STEPS} positions, with every point "
        "listed. "
        f"On {brute['poses']} random poses contact is never judged otherwise than by brute force. The skeleton is our "
        "own, since that of the paper is not published.",
        [{"step": c.step, "link": c.pair[0], "mesh": c.pair[1], "x_m": p[0], "y_m": p[1], "z_m": p[2], "depth_m": d}
         for c in found for p, d in zip(c.points_W.tolist(), c.depths.tolist(), strict=True)],
        [Drawing("", "Five positions of the instrument in a liver and a skeleton, with the contact points (red).",
                 lambda canvas: figures.figure(canvas, robot, world, found, STEPS))],
    )  # fmt: skip


def fig8(work: Work) -> Outcome:
    """The deflection arrow of a palpation, against the distance of the sphere's centre from the mesh."""
    p = palpation(work.seed)
    placed, r = p.setup.surfaces[0], p.setup.scene.contact.radius
    touching = np.flatnonzero(p["depth"] > 0.0)
    inside = (p["p_WT"][touching] - placed.X_WO[:3, 3]) @ placed.X_WO[:3, :3]
    distance = placed.body.core.nearest(inside)[0]
    length = np.linalg.norm(p["delta_x"][touching], axis=1)
    off = 1e3 * np.abs(length - (r - distance))
    slope = float(np.polyfit(r - distance, length, 1)[0])
    good = float(np.percentile(off, 95)) < 0.1 and abs(slope - 1.0) < 0.02
    return Outcome(
        "agrees" if good else "differs",
        {"arrow_over_r_minus_distance": slope, "largest_difference_mm": float(off.max()),
         "difference_p95_mm": float(np.percentile(off, 95)), "largest_deflection_mm": 1e3 * float(length.max())},
        "pressing the sphere into the mesh shows the deflection as a red arrow (no numbers)",
        f"The arrow is as long as the sphere is deep: slope {slope:.3f} against radius less distance, which a "
        "nearest-point "
        f"query of the mesh gives (largest difference {off.max():.2f} mm).",
        [{"t_s": t, "deflection_mm": 1e3 * a, "radius_less_distance_mm": 1e3 * (r - d)}
         for t, a, d in zip(p.t[touching][::5].tolist(), length[::5].tolist(), distance[::5].tolist(), strict=True)],
        [Drawing("", f"The instrument at three depths; red arrow: the deflection, {figure12.DEFLECTION:g} times as "
                     "long. Right: its length.", partial(_pressed, p, r - distance, length))],
    )  # fmt: skip


def _pressed(p: Palpation, deep: Array, length: Array, canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 2.7), layout="constrained")
    panels = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.15))
    depth, k = p["depth"], p.deepest
    ticks = [int(np.argmin(np.abs(depth[: k + 1] - share * depth[k]))) for share in (0.05, 0.5)] + [k]
    for axes, tick in zip(panels, ticks, strict=False):
        figure12.instrument(p.moment(tick, f"t = {p.t[tick]:.2f} s"), axes)
    panels[3].plot(1e3 * deep, 1e3 * length, ".", ms=2, color=FORCE)
    end = [0.0, 1e3 * float(deep.max())]
    panels[3].plot(end, end, color=INK, lw=0.8, ls=(0, (2, 3)))
    panels[3].set(xlabel="radius less distance to the mesh [mm]", ylabel="length of the deflection [mm]")
    return figure


def alg1(work: Work) -> Outcome:
    """Algorithm 1, line by line, against numpy; the release; and its error on a sphere."""
    mesh = Mesh(*SHAPES["sphere"].mesh(5120), name="sphere")
    rng, rows, worst, angle = np.random.default_rng(work.seed), [], 0.0, []
    K, B = 400.0, 5.0
    for _ in range(60):
        u = rng.normal(size=3)
        u /= np.linalg.norm(u)
        v = rng.normal(0.0, 0.02, 3)
        tip = u * (0.03 + RADIUS - rng.uniform(0.2e-3, 1.5e-3))
        t = trace_algorithm1(mesh, tip, radius=RADIUS, stiffness=K, damping=B, velocity=v)
        total = t.normals.sum(axis=0)
        n = total / np.linalg.norm(total)
        delta, along = n * (n @ t.delta_x_total), n * (n @ v)
        force = K * delta - B * along
        force = force if force @ n >= 0.0 else np.zeros(3)
        line = [np.abs(a - b).max() for a, b in ((t.normal, n), (t.delta_x, delta), (t.v, along), (t.force, force))]
        worst = max(worst, *line)
        angle.append(float(np.degrees(np.arccos(np.clip(t.normal @ u, -1.0, 1.0)))))
        rows.append({"points": len(t.points), "line_4_off": line[0], "line_7_off_m": line[1], "line_8_off_m_s": line[2],
                     "line_9_off_N": line[3], "normal_error_deg": angle[-1]})  # fmt: skip
    height = 0.03 + RADIUS + np.r_[np.linspace(1e-3, -1e-3, 100), np.linspace(-1e-3, 1e-3, 100)]
    tips = np.stack([0.0 * height, 0.0 * height, height], axis=1)
    released = render(mesh, tips, radius=RADIUS, stiffness=K, damping=B, method="paper-alg1").force
    pressed, after = float(np.abs(released).max()), float(np.abs(released[height > 0.0305 + RADIUS][-40:]).max())
    lines = trace_algorithm1(mesh, [0.0, 0.0, 0.03 + RADIUS - 1e-3], radius=RADIUS, stiffness=K, damping=B,
                             velocity=[0.01, 0.0, -0.01])  # fmt: skip
    good = worst < 1e-12 and pressed > 0.1 and after == 0.0
    return Outcome(
        "agrees" if good else "differs",
        {"largest_difference_of_any_line": float(worst), "force_after_release_N": after,
         "normal_error_median_deg": float(np.median(angle)), "normal_error_largest_deg": float(np.max(angle))},
        "nine steps from collision points to the haptic force",
        "Each line of the core's method paper-alg1 is that of numpy, and the force is exactly zero on release. Its "
        "normal "
        f"is off by {np.median(angle):.1f}° (median) on a sphere of 5120 faces: see the pages on contact methods.",
        rows,
        [Drawing("", "Error of the average normal of line 4 over the number of averaged contact points.",
                 lambda canvas: _averaged(rows, canvas))],
        f"<pre>{escape(str(lines))}</pre>",
    )  # fmt: skip


def _averaged(rows: list[dict[str, Any]], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(0.6 * canvas.width, 2.6), layout="constrained")
    axes = figure.subplots()
    axes.plot([r["points"] for r in rows], [r["normal_error_deg"] for r in rows], "o", ms=3, color=FORCE)
    axes.set(xlabel="contact points in the average", ylabel="error of the normal [deg]", ylim=(0, None))
    return figure


def fig12(work: Work) -> Outcome:
    """Four meshes; body and spatial force."""
    from palpate_lab.studies.figure12.work import row, run

    moments = run()
    rows = [row(moment) for moment in moments]
    body, norms, off_normal = [], [], []
    for moment in moments:
        tick, setup = moment.tick, moment.setup
        R_LH = setup.arms.leader.fk(tick["q"])[:3, :3]
        body.append(float(np.abs(tick["F_H_H"] - R_LH.T @ tick["F_H_L"]).max()))
        norms.append(float(abs(np.linalg.norm(tick["F_H_H"]) - np.linalg.norm(tick["F_H_L"]))))
        on_hand = setup.arms.X_WL[:3, :3] @ tick["F_H_L"]
        deflection = tick["p_WP"] - tick["p_WT"]
        cosine = on_hand @ deflection / np.linalg.norm(on_hand) / np.linalg.norm(deflection)
        off_normal.append(float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))))
    good = max(body) < 1e-9 and max(norms) < 1e-12 and all(np.linalg.norm(r["F_H_L_N"]) > 0.1 for r in rows)
    return Outcome(
        "agrees" if good else "differs",
        {"meshes": rows, "body_force_off_R_times_spatial_force_N": max(body), "norms_differ_by_N": max(norms),
         "largest_angle_of_force_to_deflection_deg": max(off_normal)},
        "four meshes: deflection at the instrument, and on the master the force in body (red) and spatial frame "
        "(green)",
        "The red and green arrows are one force in two frames: of equal length, and apart by the attitude of the "
        "handle. "
        "The meshes are our own, since those of the paper are not published.",
        [{"mesh": r["mesh"], "t_s": r["t_s"], "penetration_mm": r["penetration_mm"],
          **{f"{name[:-2]}_{axis}_N": x for name in ("F_T_W_N", "F_H_L_N", "F_H_H_N")
             for axis, x in zip("xyz", r[name], strict=True)}} for r in rows],
        [Drawing("", "A to H: the instrument in four meshes, each with the master's handle beside it (SPR 30 mm).",
                 lambda canvas: figure12.draw(moments, canvas))],
    )  # fmt: skip


def mesh(work: Work) -> Outcome:
    """Force error over faces per radius of curvature, by method, and where `palpate check` warns."""
    shape = Sphere(_CURVATURE)
    rows: list[dict[str, Any]] = []
    path = tool_path(shape, *PATHS["shallow"], RADIUS)
    for faces in _FACES:
        body = Mesh(*shape.mesh(faces), name="sphere").core
        fine = touchable.fineness(body, STIFFNESS)
        edge = 1e-3 * fine.edge_mm
        for method in _METHODS:
            found = judge(body, shape, path, method)
            rows.append({
                "method": method, "triangles": body.triangle_count, "faces_per_radius": _CURVATURE / edge,
                "phi_f_deg": fine.turn_deg, "direction_p95_deg": found["direction_p95_deg"],
                "step_deg": found["step_deg"], "magnitude_p95_mN": found["magnitude_p95_mN"], "warned": fine.coarse,
            })  # fmt: skip
    faced = [r for r in rows if r["method"] == "face-normal"]
    ratio = [r["step_deg"] / r["phi_f_deg"] for r in faced]
    wide = [r for r in faced if _CURVATURE / r["faces_per_radius"] > RADIUS]  # the sphere spans no more than an edge
    falls = bool((np.diff([float(r["direction_p95_deg"]) for r in wide]) < 0.0).all())
    good = len(wide) > 2 and falls and all(0.5 < x < 2.0 for x in ratio)  # at a vertex it may turn by two edges at once
    proxy = {r["triangles"]: r["direction_p95_deg"] for r in rows if r["method"] == "proxy"}
    return Outcome(
        "agrees" if good else "differs",
        {"step_of_the_force_over_phi_f_face_normals": ratio, "direction_error_p95_deg_of_proxy_by_triangles": proxy,
         "warned_up_to_triangles": max((r["triangles"] for r in rows if r["warned"]), default=0)},
        "a coarse mesh makes the force jump by φ_f between faces; a dense one, relative to the curvature, is needed",
        f"With face normals the largest step of the force is {min(ratio):.1f} to {max(ratio):.1f} φ_f, and its error "
        "falls "
        "with the faces per radius of curvature, until their edges are shorter than the sphere's radius: then the "
        "choice of the "
        "collision points that are averaged decides. Interpolated normals, the default, need fewer faces. Commands "
        "warn of a "
        "mesh that is too coarse.",
        rows,
        [Drawing("", "Error of the force's direction and its largest step over the number of faces along a radius of "
                     "curvature; hollow: `palpate check` and `palpate run` warn of this mesh.", partial(_dense, rows))],
    )  # fmt: skip


def _dense(rows: list[dict[str, Any]], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    for method, colour in zip(_METHODS, (TOOL, CAP, FORCE), strict=True):
        mine = [r for r in rows if r["method"] == method]
        x = [r["faces_per_radius"] for r in mine]
        for axes, key in ((left, "direction_p95_deg"), (right, "step_deg")):
            axes.loglog(x, [r[key] for r in mine], color=colour, label=method)
            for r in mine:
                axes.plot(
                    r["faces_per_radius"], r[key], "o", color=colour, mfc="white" if r["warned"] else colour, ms=5
                )
    right.loglog([r["faces_per_radius"] for r in mine], [r["phi_f_deg"] for r in mine], color=MUTED, lw=0.9,
                 ls=(0, (2, 3)), label="φ_f")  # fmt: skip
    left.set(xlabel="faces along a radius of curvature", ylabel="direction error, 95 % [deg]")
    right.set(xlabel="faces along a radius of curvature", ylabel="largest step between ticks [deg]")
    right.legend()
    for axes in (left, right):
        plain_ticks(axes, [round(r["faces_per_radius"], 1) for r in mine])
    return figure


_ALG = ("core/palpate/collision/paper_alg1.hpp", "palpate/scene/contact/algorithm1.py")

ITEMS = (
    Item("fig5", "Collision with meshes", "Section 3, Fig 5 A, B",
         "An instrument collides with a mesh (A) and with a volumetric skeleton (B); the collision points of each "
         "pair of "
         "a link and a mesh are shown in red.",
         fig5, ("R8", "R10"), "", ("lab/palpate_lab/studies/collisions/work.py",)),
    Item("fig8", "The deflection arrow", "Section 3.2, Fig 8",
         "As the tip presses the sphere into the mesh, a red arrow shows the deflection.", fig8, ("R11", "R29", "R31"),
         "The arrow is x_d − x, out of the obstacle.", ("core/palpate/contact/proxy.cpp",)),
    Item("alg1", "The algorithm of the haptic force", "Section 5, Algorithm 1",
         "Nine steps lead from the collision points through an averaged normal to the force.", alg1, ("R39",),
         "Line 4 divides by the length of the sum; lines 7 and 8 need |n| = 1; if the sum vanishes, the last normal is "
         "kept. Its collision normals are those that section 3.1 calls useless: two methods of the paper.", _ALG),
    Item("fig12", "Four meshes", "Section 4, Fig 12 A–H",
         "An instrument in four meshes, and beside each the force on the master's handle in the body (red) and the "
         "spatial frame (green); the sphere has a diameter of 30 mm.", fig12, ("R11", "R17", "R40"), "",
         ("lab/palpate_lab/studies/figure12/work.py",)),
    Item("mesh", "A mesh that is dense enough", "Section 4, text on dense meshes",
         "The mesh must be dense for its curvature: between coarse faces the force jumps by φ_f.", mesh, ("R44",), "",
         ("palpate/scene/contact/touchable.py", "palpate/scene/contact/judging.py")),
)  # fmt: skip
