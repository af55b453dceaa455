"""Evaluation of contact methods on shapes in closed form: computation time, and error against F = k (r - phi) n."""

from __future__ import annotations

from typing import TypedDict

import numpy as np

from palpate import _core
from palpate.base.arrays import Array
from palpate.scene.contact.rendering import render
from palpate.world.shapes.analytic import Shape
from palpate.world.shapes.paths import ToolPath

RADIUS, STIFFNESS = 2e-3, 500.0  # [m], [N/m]; no damping, no friction
PATHS = {"deep": (-2e-3, 0.05), "shallow": (1e-3, 0.05), "fast": (-2e-3, 0.2), "tool": (-2e-3, 0.05)}
"""Offset [m] and speed [m/s] of each path; on `tool`, all 16 spheres of a tool are in contact at once."""
ARTEFACT = 45.0  # direction error of the paper's "erroneous directions" (section 4) [deg]
WARM_UP = 100  # first updates, excluded from the timing


class Quality(TypedDict):
    """Figures of the steady slide against the exact force."""

    direction_median_deg: float  #: angle to the exact normal over the steady slide
    direction_p95_deg: float
    direction_max_deg: float
    magnitude_p95_mN: float  #: error against k times the exact deflection [mN]
    magnitude_max_mN: float
    step_deg: float  #: largest change of direction between consecutive samples
    step_mN: float  #: largest change of magnitude between consecutive samples
    true_step_deg: float  #: largest change of direction of the exact force
    true_step_mN: float  #: largest change of magnitude of the exact force
    lost: int  #: samples without force although the sphere touches
    flipped: int  #: samples whose force points into the surface
    artefacts: int  #: samples whose force is more than ``ARTEFACT`` from the exact normal


class Judged(Quality):
    """Computation time and quality of one method along one path."""

    p50_us: float  #: median time of one update of contact and force
    p99_us: float
    energy_mJ: (
        float  #: net work on the tool over the path, which starts and ends in free space; positive: energy generated
    )
    true_energy_mJ: float  #: the same for the exact force; not zero because of sampling only


def judge(mesh: _core.Mesh, shape: Shape, path: ToolPath, method: str, places: Array | None = None) -> Judged:
    """Computation time and quality of a method on one path over a mesh of a shape.

    places: (m, 3) centres of the tool's spheres relative to the tip, the tip first [m]; default: the tip only.
    """
    places = np.zeros((1, 3)) if places is None else places
    others = [(p_TS, RADIUS) for p_TS in places[1:]]
    rendered = render(mesh, path.tips, radius=RADIUS, stiffness=STIFFNESS, method=method, spheres=others)
    exact = np.zeros_like(path.tips)
    for p_TS in places:
        depth, normal = shape.held(path.tips + p_TS, RADIUS)
        exact += STIFFNESS * depth[:, None] * normal
    p50, p99 = np.percentile(rendered.latency[WARM_UP:] * 1e6, [50, 99])
    return {
        "p50_us": float(p50),
        "p99_us": float(p99),
        **_quality(rendered.force[path.steady], exact[path.steady]),
        "energy_mJ": _work_mj(rendered.force, path.tips),
        "true_energy_mJ": _work_mj(exact, path.tips),
    }


def _quality(force: Array, exact: Array) -> Quality:
    """Figures of the steady slide against the exact force, both (n, 3) [N]."""
    magnitude, reference = np.linalg.norm(force, axis=1), np.linalg.norm(exact, axis=1)
    error = _angle_deg(force, exact)[magnitude > 0]
    deviation = np.abs(magnitude - reference) * 1e3
    median, p95 = np.percentile(error, [50, 95]) if len(error) else (180.0, 180.0)
    return {
        "direction_median_deg": float(median),
        "direction_p95_deg": float(p95),
        "direction_max_deg": float(error.max(initial=0.0 if len(error) else 180.0)),
        "magnitude_p95_mN": float(np.percentile(deviation, 95)),
        "magnitude_max_mN": float(deviation.max()),
        "step_deg": float(_angle_deg(force[1:], force[:-1]).max()),
        "step_mN": float(np.abs(np.diff(magnitude)).max() * 1e3),
        "true_step_deg": float(_angle_deg(exact[1:], exact[:-1]).max()),
        "true_step_mN": float(np.abs(np.diff(reference)).max() * 1e3),
        "lost": int(np.count_nonzero((magnitude == 0) & (reference > 0))),
        "artefacts": int(np.count_nonzero(error > ARTEFACT)),
        "flipped": int(np.count_nonzero((force * exact).sum(axis=1) < 0)),
    }


def _work_mj(force: Array, tips: Array) -> float:
    """Work of the force on the tool along its path, by the trapezoidal rule [mJ]."""
    return float(((force[1:] + force[:-1]) / 2 * np.diff(tips, axis=0)).sum() * 1e3)


def _angle_deg(a: Array, b: Array) -> Array:
    return np.asarray(np.degrees(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), (a * b).sum(axis=1))))
