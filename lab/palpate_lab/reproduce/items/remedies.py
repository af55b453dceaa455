"""The rejected ways to a normal over the angle of approach, and the two remedies against a noisy scene."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from palpate.base.plotting.style import CAP, FORCE, INK, JOINTS, TOOL, Canvas, plain_ticks
from palpate.base.sweep import Axis, sweep
from palpate.scene.contact.judging import judge
from palpate.world.mesh import Mesh
from palpate.world.shapes.analytic import SHAPES
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.studies.contact.work import PLACES, approaches
from palpate_lab.studies.radius.work import measure

ANGLES = tuple(float(a) for a in range(0, 80, 5))  # angles of approach to the normal [deg]
METHODS = ("approach-velocity", "paper-alg1", "face-normal", "paper-plane", "proxy")
_TRIANGLES = 5120

RADII = (0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3)  # of the sphere [m]
NOISES = (0.0, 0.02e-3, 0.05e-3, 0.1e-3, 0.2e-3, 0.3e-3, 0.5e-3)  # standard deviation of the vertices [m]
_FEATURE = 8e-3  # width of the ridges [m]


def approach(work: Work) -> Outcome:
    """Normal error of each method over the angle of approach, on a sphere."""
    shape = SHAPES["sphere"]
    mesh = Mesh(*shape.mesh(_TRIANGLES), name="sphere").core
    rows: list[dict[str, Any]] = []
    for degrees in ANGLES:
        paths = list(approaches(shape, degrees))
        for method in METHODS:
            errors = [judge(mesh, shape, path, method)["direction_median_deg"] for path in paths]
            rows.append({"approach_deg": degrees, "method": method, "normal_error_deg": float(np.median(errors)),
                         "largest_deg": float(np.max(errors))})  # fmt: skip
    by = {(r["method"], r["approach_deg"]): r["normal_error_deg"] for r in rows}
    velocity = [by["approach-velocity", a] for a in ANGLES]
    off = max(abs(v - a) for v, a in zip(velocity, ANGLES, strict=True))
    good = off < 2.0 and by["paper-alg1", 0.0] > 2.0
    return Outcome(
        "agrees" if good else "differs",
        {"normal_error_deg_at_0_and_45_deg": {m: [by[m, 0.0], by[m, 45.0]] for m in METHODS},
         "velocity_error_less_angle_deg": off},
        "averaged normals are useless for the deflection; the approach velocity gives the normal only when the tool "
        "comes "
        "along it (no numbers)",
        f"The direction of approach is wrong by the angle of approach itself (to {off:.1g}°), so it is right at 0° "
        "only. "
        f"Averaged collision normals are off by {by['paper-alg1', 0.0]:.1f}° at any angle, precomputed face normals by "
        f"{by['face-normal', 0.0]:.1f}°, and the proxy with interpolated normals by {by['proxy', 0.0]:.2g}°.",
        rows,
        [Drawing("", f"Error of the normal, a sphere of {_TRIANGLES} faces, median of {PLACES} places.",
                 partial(_approach, by))],
    )  # fmt: skip


def _approach(by: dict[tuple[str, float], float], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(0.65 * canvas.width, 3.0), layout="constrained")
    axes = figure.subplots()
    for method, colour in zip(METHODS, (FORCE, CAP, JOINTS[4], JOINTS[2], TOOL), strict=True):
        axes.semilogy(ANGLES, [max(by[method, a], 1e-3) for a in ANGLES], color=colour, marker=".", label=method)
    axes.set(xlabel="angle of approach to the normal [deg]", ylabel="error of the normal [deg]")
    axes.legend(ncols=3, loc="center", bbox_to_anchor=(0.55, 0.34))
    return figure


def noise(work: Work) -> Outcome:
    """Errors of the force on a noisy relief by radius, without and with a rate filter."""
    grid = {
        "feature": Axis([_FEATURE], "m", "width of a ridge"),
        "radius": Axis(RADII, "m", "radius of the sphere"),
        "noise": Axis(NOISES, "m", "standard deviation of the vertices"),
    }
    found = sweep(measure, grid, work.seed, workers=work.workers, console=Console(quiet=True), title="noise").rows()
    rows = [
        {"radius_mm": 1e3 * r["radius"], "noise_mm": 1e3 * r["noise"], "kept_of_the_relief": r["kept"],
         "direction_deg": r["direction_deg"], "error_mN": r["error_mN"],
         **{f"error_filtered_at_{cap}_N_per_s_mN": x for cap, x in r["filtered_mN"].items()}}
        for r in found
    ]  # fmt: skip
    at = {(round(r["radius_mm"], 3), round(r["noise_mm"], 3)): r for r in rows}
    small, large = at[0.5, 0.1], at[8.0, 0.1]
    caps = [key for key in rows[0] if key.startswith("error_filtered")]
    best = {radius: min(at[radius, 0.1][cap] for cap in caps) for radius in (0.5, 2.0, 8.0)}
    steadier = large["direction_deg"] < small["direction_deg"]
    smoothed = large["kept_of_the_relief"] < 0.9 * small["kept_of_the_relief"]
    filtered = best[0.5] < small["error_mN"]
    return Outcome(
        "agrees" if steadier and smoothed and filtered else "differs",
        {"direction_error_deg_0.5_and_8_mm_radius": [small["direction_deg"], large["direction_deg"]],
         "kept_of_8_mm_ridges_0.5_and_8_mm_radius": [small["kept_of_the_relief"], large["kept_of_the_relief"]],
         "force_error_mN_0.5_mm_radius_without_and_with_best_filter": [small["error_mN"], best[0.5]],
         "noise_mm": 0.1},
        "a noisy scene needs a greater radius and a filter; a greater radius smooths small details (no numbers)",
        f"With 0.1 mm of noise on the vertices a sphere of 8 instead of 0.5 mm turns the force by "
        f"{large['direction_deg']:.0f} instead of {small['direction_deg']:.0f}° (95 %), and renders "
        f"{100 * large['kept_of_the_relief']:.0f} instead of {100 * small['kept_of_the_relief']:.0f} % of 8 mm "
        "ridges. The "
        f"best rate filter changes the error of the force at 0.5 mm from {small['error_mN']:.0f} to {best[0.5]:.0f} "
        "mN, its "
        "lag included.",
        rows,
        [Drawing("", "Errors (95 %) over the noise by radius; dashed: with the rate filter that suits each point best. "
                     "Right: share of the relief that each radius renders.", partial(_noise, at, caps))],
    )  # fmt: skip


def _noise(at: dict[tuple[float, float], dict[str, Any]], caps: list[str], canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 2.9), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    noises = [round(1e3 * n, 3) for n in NOISES if n > 0.0]
    radii = [round(1e3 * r, 3) for r in RADII]
    for radius, colour in zip(radii, JOINTS, strict=False):
        left.plot(
            noises, [at[radius, n]["direction_deg"] for n in noises], color=colour, marker=".", label=f"{radius:g} mm"
        )
        middle.plot(noises, [at[radius, n]["error_mN"] for n in noises], color=colour, marker=".")
        middle.plot(noises, [min(at[radius, n][cap] for cap in caps) for n in noises], color=colour, ls=(0, (4, 2)))
    left.set(xlabel="noise of the vertices [mm]", ylabel="direction error [deg]")
    left.legend(title="radius", fontsize=6.5)
    middle.set(xlabel="noise of the vertices [mm]", ylabel="error of the force [mN]", yscale="log")
    right.semilogx(radii, [100 * at[r, 0.0]["kept_of_the_relief"] for r in radii], color=INK, marker=".")
    right.set(xlabel="radius [mm]", ylabel="rendered share of 8 mm ridges [%]", ylim=(0, 115))
    plain_ticks(right, radii)
    return figure


ITEMS = (
    Item("approach", "Ways to a normal that the paper rejects", "Section 3.1, text",
         "The collision library's averaged normals are useless, normals computed in advance are costly, and the "
         "velocity of "
         "the approach is the normal only when the tool comes along the normal.",
         approach, ("R26",), "", ("lab/palpate_lab/studies/contact/work.py", "palpate/scene/contact/judging.py")),
    Item("noise", "A noisy scene: radius and filter", "Section 4, text on the radius",
         "A greater radius smooths the normal's changes and loses small details; a noisy environment needs a greater "
         "radius "
         "and a filter.", noise, ("R43", "R45", "R46"),
         "“A greater radius smooths … but results in a noisy deflection” contradicts itself; the study of the radius "
         "decides.",
         ("lab/palpate_lab/studies/radius/work.py",), "The later code has an empty ForceFilter."),
)  # fmt: skip
