"""Contact methods judged on shapes known exactly: their time, and how far their force is from F = k (r - phi) n."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from palpate import _core
from palpate.arrays import Array
from palpate.contact.rendering import render
from palpate.shapes.analytic import Shape
from palpate.shapes.paths import ToolPath

RADIUS, STIFFNESS = 2e-3, 500.0  # [m], [N/m]; no damping, no friction
PATHS = {"deep": (-2e-3, 0.05), "shallow": (1e-3, 0.05), "fast": (-2e-3, 0.2), "tool": (-2e-3, 0.05)}
"""Offset [m] and speed [m/s]; along `tool` all of a tool's 16 spheres are in the surface at once."""
ARTEFACT = 45.0  # direction error beyond which a force is one of the paper's "erroneous directions" (section 4) [deg]
WARM_UP = 100  # first updates that are not timed


class Quality(TypedDict):
    """Figures of the steady slide against the exact force."""

    direction_median_deg: float  #: angle to the exact normal over the steady slide
    direction_p95_deg: float
    direction_max_deg: float
    magnitude_p95_mN: float  #: error against k times the exact deflection
    magnitude_max_mN: float
    step_deg: float  #: largest change of direction from one sample to the next
    step_mN: float  #: largest change of magnitude
    true_step_deg: float  #: the same of the exact force
    true_step_mN: float
    lost: int  #: samples without force though the sphere touches
    flipped: int  #: samples whose force points into the surface
    artefacts: int  #: samples whose force is more than ``ARTEFACT`` from the exact normal


class Judged(Quality):
    """Time and quality of one method along one path."""

    p50_us: float  #: one update of contact and force
    p99_us: float
    energy_mJ: float  #: net work on the tool from free to free: what it gave beyond what it took
    true_energy_mJ: float  #: of the exact force: none but for sampling


def judge(mesh: _core.Mesh, shape: Shape, way: ToolPath, method: str, places: Array | None = None) -> Judged:
    """Time and quality of one path over a mesh of a shape.

    places: (m, 3) centres of the tool's spheres from the tip, which is the first [m]; the tip alone when left out.
    """
    places = np.zeros((1, 3)) if places is None else places
    others = [(p_TS, RADIUS) for p_TS in places[1:]]
    felt = render(mesh, way.tips, radius=RADIUS, stiffness=STIFFNESS, method=method, spheres=others)
    exact = np.zeros_like(way.tips)
    for p_TS in places:
        depth, normal = shape.held(way.tips + p_TS, RADIUS)
        exact += STIFFNESS * depth[:, None] * normal
    p50, p99 = np.percentile(felt.latency[WARM_UP:] * 1e6, [50, 99])
    return {
        "p50_us": float(p50),
        "p99_us": float(p99),
        **_quality(felt.force[way.steady], exact[way.steady]),
        "energy_mJ": _work_mj(felt.force, way.tips),
        "true_energy_mJ": _work_mj(exact, way.tips),
    }


def _quality(force: Array, exact: Array) -> Quality:
    """Figures of the steady slide against the exact force, both (n, 3) [N]."""
    strength, due = np.linalg.norm(force, axis=1), np.linalg.norm(exact, axis=1)
    error = _angle_deg(force, exact)[strength > 0]
    magnitude = np.abs(strength - due) * 1e3
    median, p95 = np.percentile(error, [50, 95]) if len(error) else (180.0, 180.0)
    return {
        "direction_median_deg": float(median),
        "direction_p95_deg": float(p95),
        "direction_max_deg": float(error.max(initial=0.0 if len(error) else 180.0)),
        "magnitude_p95_mN": float(np.percentile(magnitude, 95)),
        "magnitude_max_mN": float(magnitude.max()),
        "step_deg": float(_angle_deg(force[1:], force[:-1]).max()),
        "step_mN": float(np.abs(np.diff(strength)).max() * 1e3),
        "true_step_deg": float(_angle_deg(exact[1:], exact[:-1]).max()),
        "true_step_mN": float(np.abs(np.diff(due)).max() * 1e3),
        "lost": int(np.count_nonzero((strength == 0) & (due > 0))),
        "artefacts": int(np.count_nonzero(error > ARTEFACT)),
        "flipped": int(np.count_nonzero((force * exact).sum(axis=1) < 0)),
    }


def _work_mj(force: Array, tips: Array) -> float:
    """Of the force on the tool along its way, by the trapezoid rule [mJ]."""
    return float(((force[1:] + force[:-1]) / 2 * np.diff(tips, axis=0)).sum() * 1e3)


def _angle_deg(a: Array, b: Array) -> Array:
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))))
