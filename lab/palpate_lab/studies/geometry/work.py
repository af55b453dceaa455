"""The work of ``palpate study geometry``."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from rich.table import Table

from palpate.base.arrays import Array
from palpate.scene import contact
from palpate.scene.contact.lessons.face_angle import Slide, angle_noise, contact_normal_error, eq20
from palpate.scene.contact.lessons.point_contact import Pair, approach
from palpate.world.surfaces import ImplicitSurface, Plane

StudyResult = dict[str, list[dict[str, float | str]]]
"""Rows by table; docs/json.md lists their keys."""

FACES = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)  # face angles of Fig 11 [deg]
TURNS = (-80.0, -50.0, -20.0, 20.0, 50.0, 80.0, 100.0, 125.0, 150.0)  # face angles for the test of Eq 20 [deg]
NOISES = (1e-6, 10e-6, 100e-6)  # noise of a contact point [m]
BASELINE = 0.02 / 250.0  # distance of successive contact points: 20 mm/s at 250 Hz [m]
GAPS = (1e-2, 1e-3, 1e-4, 1e-6, 1e-8)  # gaps between two surfaces [m]
RADIUS = 15e-3  # radius of the SPR in the paper's Fig 12 [m]


def run() -> StudyResult:
    """All numbers of the page, with the keys of docs/json.md."""
    _, _, pairs = approaches(GAPS)
    depths, delta = pressed()
    return {
        "point_contact": [{"gap_m": p.gap, "cross": p.cross, "dot": p.dot} for p in pairs],
        "deflection": [
            {"depth_m": float(d), "deflection_m": float(x)} for d, x in zip(depths[::25], delta[::25], strict=True)
        ],
        "depth_error": [
            {"depth_m": d, "normal_error_deg": contact_normal_error(RADIUS, d)}
            for d in (1e-3, 5e-3, 10e-3, 15e-3, 20e-3)
        ],
        "slopes": [_slope(degrees) for degrees in FACES],
        "noise": [{"noise_m": s, "error_rms_deg": angle_noise(s)} for s in NOISES],
        "eq20": [{"face_deg": degrees, "fails": eq20(Slide(np.radians(degrees)))[1]} for degrees in TURNS],
    }


def approaches(gaps: Iterable[float]) -> tuple[ImplicitSurface, ImplicitSurface, list[Pair]]:
    """Two implicit surfaces, and pairs of points and normals at ``gaps`` [m] during V's oblique approach to U."""
    U = ImplicitSurface.of_half_lengths((0.03, 0.025, 0.02), (2, 2, 4), name="U")
    V = ImplicitSurface.of_half_lengths((0.02, 0.015, 0.015), (4, 2, 2), name="V")
    touch, direction = (0.022, 0.0, 0.03), (-1.0, 0.0, -0.35)
    return U, V, [approach(U, V, touch, direction, d) for d in gaps]


def pressed() -> tuple[Array, Array]:
    """The SPR pressed into a plane: depth of its lowest point, and deflection from the contact stage (101,) [m]."""
    depths = np.linspace(0.0, 1e-2, 101)
    tips = np.stack([np.zeros(101), np.zeros(101), RADIUS - depths], axis=1)
    felt = contact.render(Plane(), tips, radius=RADIUS, stiffness=1.0)
    return depths, felt.depth


def _slope(degrees: float) -> dict[str, float | str]:
    """Largest slope error of the contact point's steps over all depths and the whole travel, where it moves."""
    worst = 0.0
    for share in (0.05, 0.3, 0.7, 1.0):
        slide = Slide(np.radians(degrees), RADIUS, share * RADIUS)
        rate = slide.rate(slide.travel(200))
        rate = rate[np.linalg.norm(rate, axis=1) > 0.1]
        rate *= np.sign(rate @ slide.face)[:, None]
        worst = max(worst, float(np.abs(np.degrees(np.arctan2(rate[:, 1], rate[:, 0])) - degrees).max()))
    return {"face_deg": degrees, "slope_error_deg": worst}


def tables(result: StudyResult) -> list[tuple[str, Table]]:
    """Titles and tables for a terminal."""
    titles = {
        "point_contact": "Eqs 14-17: normals of two surfaces as the gap closes",
        "deflection": "Fig 8: the SPR pressed into a plane",
        "depth_error": "Fig 9B: normal from centre to contact, 15 mm SPR",
        "slopes": "Fig 11: slope of the contact point's steps, any depth",
        "noise": "Eq 18: two points 80 um apart (20 mm/s, 250 Hz)",
        "eq20": "Eq 20: the candidate it picks on an edge (convex below zero)",
    }
    out = []
    for key, title in titles.items():
        table = Table(box=None, padding=(0, 2, 0, 0), pad_edge=True)
        for name in result[key][0]:
            table.add_column(name, justify="right")
        for row in result[key]:
            table.add_row(*(value or "right" if isinstance(value, str) else f"{value:.6g}" for value in row.values()))
        out.append((title, table))
    return out
