"""Figs 6, 7 and 9 to 11, and Eqs 14 to 20: point contact, and the angle of the next face."""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from palpate.base.plotting.style import Canvas
from palpate.scene.contact.lessons.face_angle import Slide, candidates, eq20, face_angle
from palpate.world.surfaces import ImplicitSurface
from palpate_lab.reproduce.checks import Check, outcome
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.reproduce.items.palpation import Palpation, palpation
from palpate_lab.studies.geometry import figures
from palpate_lab.studies.geometry.work import FACES, RADIUS, approaches, run

_SAMPLES = 200  # points of each surface [-]
_GAPS = (1e-2, 3e-3, 1e-3, 1e-4, 1e-6, 1e-8)  # gaps of Fig 6A [m]


@cache
def _study() -> dict[str, list[dict[str, Any]]]:
    """The numbers of ``palpate study geometry``."""
    return run()


def _surfaces() -> tuple[ImplicitSurface, ...]:
    return (
        ImplicitSurface((900.0, 400.0, 2500.0), (2, 2, 2), name="ellipsoid"),
        ImplicitSurface.of_half_lengths((0.03, 0.025, 0.02), (2, 2, 4), name="U"),
        ImplicitSurface.of_half_lengths((0.02, 0.015, 0.015), (4, 2, 6), name="V"),
    )


def _points(seed: int) -> list[tuple[ImplicitSurface, np.ndarray]]:
    """Random points around each surface [m]."""
    rng = np.random.default_rng(seed)
    return [(U, x) for U in _surfaces() for x in rng.uniform(-1.2, 1.2, (_SAMPLES, 3)) * U.core.half]


def eq14(work: Work) -> Outcome:
    """U at random points, against the printed polynomial."""
    errors = []
    for U, x in _points(work.seed):
        printed = float((U.coefficients * x ** np.array(U.exponents)).sum()) - U.level
        errors.append(abs(U.value(x) - printed) / max(1.0, abs(printed)))
    check = Check("U = a x₁^m + b x₂^n + c x₃^o", "the printed polynomial in numpy", np.array(errors), 1e-12)
    why = "The core's surface is the printed one; for contact it must be closed, so the exponents are even."
    return outcome([check], "a surface of three powers", why)


def eq15(work: Work) -> Outcome:
    """The gradient against differences and against the printed derivative."""
    h, by_h, printed = 1e-6, [], []
    for U, x in _points(work.seed):
        near = np.array([U.value(x + e) - U.value(x - e) for e in h * np.eye(3)])
        far = np.array([U.value(x + 2 * e) - U.value(x - 2 * e) for e in h * np.eye(3)])
        g, size = U.gradient(x), max(1.0, float(np.abs(U.gradient(x)).max()))
        by_h.append(np.abs(g - (8 * near - far) / (12 * h)).max() / size)
        m = np.array(U.exponents)
        printed.append(np.abs(g - U.coefficients * m * x ** (m - 1)).max() / size)
    checks = [
        Check("ψ = ∇U", "central differences of fourth order", np.array(by_h), 1e-7),
        Check("∂U/∂x_i", "derivative of the power, in numpy", np.array(printed), 1e-12),
    ]
    return outcome(checks, "the normal is the gradient", "The gradient is the derivative of the surface function.")


def eq16(work: Work) -> Outcome:
    """The normal at a point of the surface, against the direction to it from outside."""
    rng, on, collinear = np.random.default_rng(work.seed), [], []
    for U in _surfaces():
        outside = rng.normal(size=(_SAMPLES, 3))
        outside *= 2.5 * U.core.half.max() / np.linalg.norm(outside, axis=1, keepdims=True)
        _, x, _ = U.nearest(outside)
        for p, c in zip(outside, x, strict=True):
            g = U.gradient(c)
            on.append(abs(U.value(c)))
            collinear.append(np.linalg.norm(np.cross(g / np.linalg.norm(g), (p - c) / np.linalg.norm(p - c))))
    checks = [
        Check("U = 0 at the point of interest", "value of the surface function", np.array(on), 1e-9),
        Check(
            "∇U* along the shortest way from outside", "nearest point of the core's query", np.array(collinear), 1e-6
        ),
    ]
    why = "At the nearest point the gradient points along the shortest way, so it is the contact normal."
    return outcome(checks, "ψ(ρ*) = ∇U at ρ*", why)


def eq17(work: Work) -> Outcome:
    """Collinearity of both normals as the gap closes."""
    _, _, pairs = approaches(_GAPS)
    ratio = np.array([p.cross / p.gap for p in pairs])
    checks = [
        Check("|n_U × n_V| at a gap of 10 nm", "cross product of both gradients", np.array([pairs[-1].cross]), 1e-6),
        Check("1 + n_U · n_V at a gap of 10 nm", "dot product of both gradients", np.array([1.0 + pairs[-1].dot]),
              1e-12),
        Check("|n_U × n_V| is proportional to the gap, below 1 mm", "ratio over the last four gaps",
              np.abs(ratio[2:] / ratio[-1] - 1.0), 0.05),
    ]  # fmt: skip
    return outcome(checks, "both normals become collinear at point contact", "They do, in proportion to the gap.",
                   more={"cross_at_gap_m": {f"{g:g}": p.cross for g, p in zip(_GAPS, pairs, strict=True)}})  # fmt: skip


def fig6(work: Work) -> Outcome:
    """Two surfaces at three gaps, and both measures over the gap."""
    p = palpation(work.seed)
    rows = _study()["point_contact"]
    last = rows[-1]
    good = last["cross"] < 1e-6 and abs(1.0 + last["dot"]) < 1e-12
    return Outcome(
        "agrees" if good else "differs",
        {"cross_product_at_10_nm": last["cross"], "one_plus_dot_product_at_10_nm": 1.0 + last["dot"]},
        "collinear normals at point contact (no numbers)",
        "As the gap closes, |n_U × n_V| falls to 0 with the gap, and n_U · n_V goes to −1. B shows the sphere of the "
        "running "
        f"scene, {2e3 * p.setup.scene.contact.radius:g} mm in diameter, at the tip where it first touches.",
        rows,
        [
            Drawing("a", "A: both surfaces at three gaps, with their normals. Right: both measures over the gap.",
                    figures.point_contact),
            Drawing("b", "B: the sphere at the tip of the instrument when it first touches the liver (simulated).",
                    partial(at_the_tip, p)),
        ],
    )  # fmt: skip


def at_the_tip(p: Palpation, canvas: Canvas) -> Figure:
    """The instrument with its sphere at the first touch, from two sides."""
    from palpate_lab.studies.figure12.figures import instrument

    figure = Figure(figsize=(0.62 * canvas.width, 3.1), layout="constrained")
    first = int(np.flatnonzero(p["depth"] > 0.0)[0])
    for axes, eye in zip(figure.subplots(1, 2), ((0.5, -0.75, 0.42), (-0.9, -0.3, 0.1)), strict=True):
        instrument(p.moment(first, "liver"), axes, np.array(eye))
        axes.set_title("", loc="left")
    return figure


def fig7(work: Work) -> Outcome:
    """Springs and dampers of the sphere, and the forces of each from the palpation."""
    p = palpation(work.seed)
    k = p.deepest
    spring, damper = p["F_spring_W"][k], p["F_damping_W"][k]
    rows = [
        {"axis": axis, "compression_mm": 1e3 * float(p["delta_x"][k][i]), "spring_N": float(spring[i]),
         "damper_N": float(damper[i])}
        for i, axis in enumerate("xyz")
    ]  # fmt: skip
    K = p.setup.scene.objects[0].stiffness
    wanted = np.array(K if np.ndim(K) else (K,) * 3) * p["delta_x"][k]
    off = float(np.abs(spring - wanted).max())
    cells = "".join(
        f"<tr><td>{r['axis']}</td><td class=value>{r['compression_mm']:+.3f}</td><td class=value>{r['spring_N']:+.3f}"
        f"</td><td class=value>{r['damper_N']:+.4f}</td></tr>"
        for r in rows
    )
    table = (
        "<table><tr><th>axis of the world</th><th>compression [mm]</th><th>spring [N]</th><th>damper [N]</th></tr>"
        f"{cells}</table>"
    )
    return Outcome(
        "agrees" if off < 1e-9 else "differs",
        {"elements": rows, "spring_force_off_N": off},
        "springs and dampers in three dimensions (no numbers)",
        "The elements are a spring and a damper along each axis of the world; those of the deepest tick of a simulated "
        f"palpation are listed, and the springs are K δx to {off:.1g} N.",
        rows,
        [Drawing("", "The sphere's springs at three depths, and the deflection over the depth.", figures.spr)],
        table,
    )


def fig9(work: Work) -> Outcome:
    """Errors of the normal by depth and by sliding, against points where sphere and face intersect."""
    rng, rows = np.random.default_rng(work.seed), []
    for r in _study()["depth_error"]:
        d = r["depth_m"]
        turn = rng.uniform(0.0, 2.0 * np.pi, _SAMPLES)
        reach = np.sqrt(RADIUS**2 - (RADIUS - d) ** 2)
        points = np.stack([reach * np.cos(turn), reach * np.sin(turn), np.zeros(_SAMPLES)], axis=1)
        to_centre = np.array([0.0, 0.0, RADIUS - d]) - points
        angle = np.degrees(np.arctan2(np.linalg.norm(to_centre[:, :2], axis=1), to_centre[:, 2]))
        rows.append({**r, "by_intersection_deg": float(angle.mean()), "spread_deg": float(np.ptp(angle))})
    at = {f"{1e3 * r['depth_m']:g}": r["normal_error_deg"] for r in rows}
    off = max(abs(r["normal_error_deg"] - r["by_intersection_deg"]) for r in rows)
    confirmed = off < 1e-9 and at["1"] > 5.0
    return Outcome(
        "agrees" if confirmed else "differs",
        {"normal_error_deg_at_depth_mm": at, "radius_mm": 1e3 * RADIUS, "closed_form_off_deg": off},
        "the normal from contact point to centre is no longer valid in depth, and sliding uses a wrong one (no "
        "numbers)",
        f"Measured: {at['1']:.0f}° after 1 mm of a 15 mm sphere, {at['5']:.0f}° after 5 mm, beyond 90° when the "
        "centre is "
        "below the face; an old normal on a new face is off by the angle of that face.",
        rows,
        [Drawing("", "A and B: pressing; C and D: sliding. The title of each panel has its angle error.",
                 figures.depth_and_slide)],
    )  # fmt: skip


def fig10(work: Work) -> Outcome:
    """The labelled drawing, from computed positions."""
    slide = Slide(np.radians(35.0))
    x = slide.travel(100)[[38]]
    phi_n, c = float(np.degrees(slide.phi_n(x)[0])), slide.contact(x)[0]
    off = abs(float(np.hypot(*(c - slide.centre(x)[0]))) - slide.radius)
    on_face = abs(float(c @ slide.normal))
    return Outcome(
        "agrees" if max(off, on_face) < 1e-12 else "differs",
        {"phi_f_deg": 35.0, "phi_n_deg": phi_n, "contact_off_the_circle_m": off, "contact_off_the_face_m": on_face},
        "definition of both angles (no numbers)",
        "The contact point lies on the next face and on the circumference, at the angles of the definition.",
        [{"phi_f_deg": 35.0, "phi_n_deg": phi_n, "c_x_m": float(c[0]), "c_y_m": float(c[1])}],
        [Drawing("", "The edge, both angles and the contact point at computed positions.", figures.angles)],
    )


def fig11(work: Work) -> Outcome:
    """Six face angles: the path of the contact point and its steps."""
    rows = _study()["slopes"]
    worst = max(float(r["slope_error_deg"]) for r in rows)
    slide = Slide(np.radians(90.0))
    x = slide.travel(200)
    c, still = slide.contact(x), float(np.abs(np.diff(slide.contact(x)[:, 0])).max())
    printed = float(np.abs(c[:, 1] / slide.radius - np.sin(slide.phi_n(x))).max())
    shifted = float(np.abs(c[:, 1] - slide.height - slide.radius * np.sin(slide.phi_n(x))).max())
    good = worst < 1e-9 and still < 1e-12 and shifted < 1e-12
    return Outcome(
        "agrees" if good else "differs",
        {
            "largest_slope_error_deg": worst, "delta_c_x_at_90_deg_m": still,
            "c_y_less_h_plus_r_sin_phi_n_m": shifted, "c_y_less_sin_phi_n_in_radii": printed,
        },
        "c_y = c_x tan φ_f (red), slope of (δc_y, δc_x) (blue) equal to φ_f; at 90°: c_y = sin φ_n, δc_x = 0",
        f"The steps have the slope of the face to {worst:.0e}° at every depth, and δc_x = 0 at 90°. There c_y is sin "
        "φ_n "
        "in units of the radius, and measured from the height of the centre: the printed formula leaves out that "
        f"offset ({printed:.2f} radii at a depth of 5 mm).",
        [{"face": "ABCDEF"[i], **r} for i, r in enumerate(rows)],
        [Drawing("", "A to F: path of the contact point (red), its steps (blue), and c_y over the travel.",
                 figures.sinusoids)],
    )  # fmt: skip


def eq18(work: Work) -> Outcome:
    """The angle from two contact points without and with noise."""
    errors = []
    for degrees in (*FACES, -20.0, -50.0, -80.0):
        for share in (0.1, 0.4, 0.8):
            slide = Slide(np.radians(degrees), RADIUS, share * RADIUS)
            x = slide.travel(100)
            c, rate = slide.contact(x), slide.rate(x)
            for i in range(0, 99, 7):
                found = face_angle(c[i], c[i + 1])
                along = np.arctan2(*(rate[i] if rate[i] @ (c[i + 1] - c[i]) > 0 else -rate[i])[::-1])
                if np.linalg.norm(c[i + 1] - c[i]) > 1e-6:
                    errors.append(abs(np.degrees((found - along + np.pi) % (2 * np.pi) - np.pi)))
    noise = {f"{1e6 * r['noise_m']:g}": r["error_rms_deg"] for r in _study()["noise"]}
    check = Check("φ_f = atan2(δc_y, δc_x)", "analytic motion of the contact point", np.array(errors), 1e-9, "deg")
    why = (
        "Exact without noise, at any depth. It is sensitive to noise: 1, 10 and 100 µm on the contact points give "
        f"{noise['1']:.0f}, {noise['10']:.0f} and {noise['100']:.0f}° (250 Hz, 20 mm/s), so it needs a minimum "
        "baseline."
    )
    result = outcome([check], "φ_f from the velocity of the contact point", why, more={"error_deg_at_noise_um": noise})
    curve = Drawing("noise", "The error of the angle over the noise of the contact points.", figures.noise)
    return replace(result, drawings=[*result.drawings, curve])


def eq19(work: Work) -> Outcome:
    """Both candidates are perpendicular to the velocity of the contact point, and one is the normal."""
    perpendicular, right = [], []
    for degrees in (*FACES, -20.0, -50.0, -80.0):
        slide = Slide(np.radians(degrees))
        c = slide.contact(slide.travel(3))
        v_c = (c[1] - c[0]) / np.linalg.norm(c[1] - c[0])
        both = candidates(face_angle(c[0], c[1]))
        perpendicular += [abs(float(n @ v_c)) for n in both]
        right.append(min(float(np.linalg.norm(n - slide.normal)) for n in both))
    checks = [
        Check("n_f · v_c = 0", "dot product, both candidates", np.array(perpendicular), 1e-12),
        Check("one candidate is the normal", "true normal of the face", np.array(right), 1e-9),
    ]
    result = outcome(checks, "n_f · v_c = 0", "Two candidates remain in the plane, one of which is the face's normal.")
    picked = Drawing(
        "candidates", "Both candidates on four edges, and the one that Eq 20 picks.", figures.two_candidates
    )
    return replace(result, drawings=[*result.drawings, picked])


def eq20_(work: Work) -> Outcome:
    """Convex and concave edges."""
    rows: list[dict[str, Any]] = []
    for degrees in range(-85, 180, 5):
        if degrees in (0, 90):  # no edge; at a right angle the product of Eq 20 is zero
            continue
        n, fails = eq20(Slide(np.radians(float(degrees))))
        true = Slide(np.radians(float(degrees))).normal
        rows.append({"face_deg": degrees, "convex": degrees < 0, "right": bool(n @ true > 0), "fails": fails})
    convex = all(r["right"] for r in rows if r["convex"])
    wrong = [r["face_deg"] for r in rows if not r["right"]]
    good = convex and wrong == list(range(95, 180, 5))
    first = min(wrong) if wrong else None
    return Outcome(
        "agrees" if good else "differs",
        {"convex_edges_right": convex, "wrong_face_angles_deg": wrong},
        "n_f · x_n ≥ 0 picks the right normal if the mesh is locally convex",
        "Right on every convex edge that a tool on the previous face can meet, and on concave edges below 90°. As the "
        f"paper's assumption implies, it fails on sharper concave edges (from {first}° on in steps of 5°): there the "
        "normal points into the wall.",
        rows,
        [Drawing("", "Both candidates on four edges, and the one that Eq 20 picks.", figures.two_candidates)],
    )


_LESSONS = ("palpate/scene/contact/lessons/face_angle.py",)
_IMPLICIT = ("core/palpate/scene/implicit_surface.cpp",)
_STUDY = ("lab/palpate_lab/studies/geometry/work.py",)

ITEMS = (
    Item("eq14", "An implicit surface", "Section 3.2, Eq 14",
         "A surface is given by a sum of three powers of the coordinates.",
         eq14, ("R27",), "The surface is U = level; the exponents are even, so that it is closed.", _IMPLICIT),
    Item("eq15", "Its gradient", "Section 3.2, Eq 15",
         "The gradient of the surface function is the normal at any point.", eq15, ("R27",), "", _IMPLICIT),
    Item("eq16", "The normal at a point", "Section 3.2, Eq 16",
         "At a point of interest the normal is the gradient there.", eq16, ("R27",),
         "The sum of three scalars is read as the vector of the three partial derivatives.", _IMPLICIT),
    Item("eq17", "A second surface", "Section 3.2, Eq 17",
         "A second surface approaches; at point contact both normals are collinear.", eq17, ("R28",), "",
         ("palpate/scene/contact/lessons/point_contact.py",)),
    Item("fig6", "Point contact, and the sphere at the tip", "Section 3.2, Fig 6",
         "A: two surfaces approach until they touch in a point, where their normals are collinear. B: a sphere at the "
         "tip of the instrument is where all contact happens.",
         fig6, ("R28", "R29"), "", (*_STUDY, "palpate/scene/contact/lessons/point_contact.py"),
         "The authors' later code lets the diameter be 20, 25 or 30 mm."),
    Item("fig7", "The sphere as springs and dampers", "Section 3.2, Fig 7",
         "The spherical proxy region is made of springs and dampers in three dimensions.", fig7, ("R30",), "",
         (*_STUDY, "core/palpate/force/force.cpp")),
    Item("fig9", "Depth and sliding spoil the normal", "Section 3.3, Fig 9",
         "Collision points lie on the surfaces only. Once the sphere is inside, the line from point to centre is not "
         "the normal (A, B), and while it slides the deflection is projected on a wrong normal (C, D).",
         fig9, ("R32",), "", _LESSONS),
    Item("fig10", "The two angles", "Section 3.3, Fig 10",
         "One angle lies between neighbouring faces, the other tells where on the circumference the contact point is.",
         fig10, ("R33",), "", _LESSONS),
    Item("fig11", "The contact point on the next face", "Section 3.3, Fig 11 A–F",
         "For six face angles the contact point moves on the line of the face, and its steps have the slope of the "
         "face.",
         fig11, ("R34",), "The blue lines are read as the steps (δc_x, δc_y) of the contact point.", _LESSONS),
    Item("eq18", "The angle of the next face", "Section 3.3, Eq 18",
         "The direction of the contact point's velocity is the angle of the face.", eq18, ("R35",),
         "tan⁻¹ v_c is read as atan2(ċ_y, ċ_x).", _LESSONS),
    Item("eq19", "Its normal", "Section 3.3, Eq 19",
         "The normal of the new face is perpendicular to the velocity of the contact point.", eq19, ("R36",), "",
         _LESSONS),
    Item("eq20", "Which of the two normals", "Section 3.3, Eq 20",
         "Of the two candidates the one on the side of the last normal is right where the mesh is locally convex.",
         eq20_, ("R37",), "x_n is the last good normal.", _LESSONS),
)  # fmt: skip
