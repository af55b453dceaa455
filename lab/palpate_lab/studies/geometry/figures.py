"""The pictures of ``palpate study geometry``: Figs 6 to 11 of the paper, drawn from computed geometry."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Polygon

from palpate.base.plotting.style import CAP, DEPTH, FORCE, INK, MUTED, SURFACE, Canvas, png
from palpate.scene.contact.lessons.face_angle import Slide, angle_noise, candidates, contact_normal_error, eq20
from palpate_lab.studies.geometry.drawing import arrow, ground, outline, plain, spring
from palpate_lab.studies.geometry.work import BASELINE, FACES, NOISES, approaches, pressed

MM, GOOD = 1e3, "#4f8f4f"


def draw(folder: Path) -> list[Path]:
    """Write every picture; returns the files."""
    figures = {
        "point-contact": point_contact,
        "spr": spr,
        "depth-and-slide": depth_and_slide,
        "angles": angles,
        "sinusoids": sinusoids,
        "noise": noise,
        "candidates": two_candidates,
    }
    files = []
    for name, figure in figures.items():
        files.append(folder / f"geometry-{name}.png")
        png(figure, files[-1])
    return files


def point_contact(canvas: Canvas) -> Figure:
    """Fig 6A: three gaps during an approach, and both measures of collinearity over the gap."""
    figure = Figure(figsize=(canvas.width, 2.5), layout="constrained")
    panels = figure.subplots(1, 4, width_ratios=(1.1, 1.1, 1.1, 1))
    U, V, pairs = approaches((12e-3, 4e-3, 0.0))
    for axes, pair in zip(panels, pairs, strict=False):
        for body, at, color in ((U, np.zeros(3), SURFACE), (V, pair.p_V, "#bcd4de")):
            around = MM * (outline(body.core.half, body.exponents) + at[[0, 2]])
            axes.add_patch(Polygon(around, facecolor=color, edgecolor=MUTED, lw=0.8))
        for p, n, color, name in ((pair.x, pair.n_U, FORCE, "$n_U$"), (pair.y, pair.n_V, DEPTH, "$n_V$")):
            arrow(axes, MM * p[[0, 2]], 14 * n[[0, 2]], color)
            axes.plot(*(MM * p[[0, 2]]), "o", color=color, ms=3)
            axes.annotate(name, MM * p[[0, 2]] + 17 * n[[0, 2]], color=color, ha="center", va="center", fontsize=9)
        axes.text(-11, -9, "U", fontsize=10, color=INK)
        axes.text(*(MM * pair.p_V[[0, 2]] + [3, 3]), "V", fontsize=10, color=INK)
        axes.set_title(f"gap {MM * pair.gap:.1f} mm:  $|n_U × n_V|$ = {pair.cross:.3f}", fontsize=8.5, loc="left")
        plain(axes, (-33, 70), (-22, 56))
    gaps = np.logspace(-2, -8, 25)
    _, _, pairs = approaches(gaps)
    x = [MM * p.gap for p in pairs]
    panels[3].loglog(x, [p.cross for p in pairs], color=FORCE, label="$|n_U × n_V|$")
    panels[3].loglog(x, [max(1.0 + p.dot, 1e-16) for p in pairs], color=DEPTH, label="$1 + n_U · n_V$")
    panels[3].set(xlabel="gap Δ(U, V) [mm]")
    panels[3].set_title("collinear as the gap closes", fontsize=8.5, loc="left")
    panels[3].legend()
    return figure


def spr(canvas: Canvas) -> Figure:
    """Figs 6B, 7, 8: the sphere's springs are compressed, and the deflection grows with the depth."""
    figure = Figure(figsize=(canvas.width, 2.5), layout="constrained")
    panels = figure.subplots(1, 4, width_ratios=(1, 1, 1, 1.2))
    depths, delta = pressed()
    r = 15.0
    for axes, i in zip(panels, (0, 40, 100), strict=False):
        height = r - MM * depths[i]
        ground(axes, [[-60, 0], [60, 0]])
        axes.add_patch(Circle((0, height), r, facecolor="none", edgecolor=DEPTH, lw=1.2))
        for angle in np.radians(np.arange(-180, 180, 45)):
            out = np.array([np.cos(angle), np.sin(angle)])
            reach = r if out[1] >= 0 else min(r, height / -out[1])
            spring(axes, np.array([0.0, height]), out, reach, FORCE if reach < r - 1e-6 else MUTED)
        axes.plot(0, height, "o", color=INK, ms=3)
        if delta[i] > 0:
            arrow(axes, np.array([20.0, 0.0]), np.array([0.0, MM * delta[i]]), FORCE, 2.0)
            axes.text(21.5, 0.5 * MM * delta[i], "δx", color=FORCE, va="center", fontsize=9)
        axes.set_title(f"{MM * depths[i]:g} mm deep: δx = {MM * delta[i]:g} mm", fontsize=8.5, loc="left")
        plain(axes, (-26, 28), (-14, 33))
    panels[3].plot(MM * depths, MM * delta, color=FORCE)
    panels[3].set(xlabel="depth of the sphere's lowest point [mm]", ylabel="δx = (r − distance) n [mm]")
    panels[3].set_title("the arrow grows with the depth", fontsize=8.5, loc="left")
    return figure


def depth_and_slide(canvas: Canvas) -> Figure:
    """Fig 9: errors of a normal from the centre to a contact point, and of an old normal on a new face."""
    figure = Figure(figsize=(canvas.width, 2.6), layout="constrained")
    panels = figure.subplots(1, 4)
    r, depth, turn = 15.0, 5.0, 30.0
    half = float(np.sqrt(r**2 - (r - depth) ** 2))
    error = contact_normal_error(r, depth)
    face = np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
    up = np.array([0.0, 1.0])
    next_n = np.array([-face[1], face[0]])
    flat = [[-60, 0], [60, 0]]
    x_d = 8.0 * face + (r - depth) * next_n
    cases = (
        ("A  touching", flat, np.array([0.0, r]), np.array([0.0, 0.0]), up, up, 0.0),
        ("B  pressed", flat, np.array([0.0, r - depth]), np.array([half, 0.0]), up, None, error),
        (
            "C  sliding, old normal",
            flat,
            np.array([9.0, r - depth]),
            np.array([9.0 + half, 0.0]),
            up,
            None,
            error,
        ),
        ("D  next face, old normal", [[-60, 0], [0, 0], (70 * face).tolist()], x_d, None, next_n, up, turn),
    )
    for axes, (title, line, centre, point, true, used, wrong) in zip(panels, cases, strict=True):
        ground(axes, line)
        axes.add_patch(Circle(tuple(centre), r, facecolor="none", edgecolor=DEPTH, lw=1.2))
        axes.plot(*centre, "o", color=DEPTH, ms=3)
        foot = centre - (r - depth if wrong else r) * true
        n = used if used is not None else (centre - point) / np.linalg.norm(centre - point)
        if point is not None:
            axes.plot([point[0], centre[0]], [point[1], centre[1]], color=MUTED, lw=0.8, ls="--")
            axes.plot(*point, "o", color=FORCE, ms=4)
        arrow(axes, foot, 17 * true, GOOD, 3.4)
        arrow(axes, foot, 17 * np.asarray(n), FORCE, 1.6)
        axes.set_title(f"{title}: {wrong:.0f}° off", fontsize=8.0, loc="left")
        plain(axes, (-28, 34), (-16, 34))
    note = "green: true normal      red: the normal that is used      red dot: the contact point that is reported"
    figure.supxlabel(note, fontsize=7.5, color=MUTED)
    return figure


def angles(canvas: Canvas) -> Figure:
    """Fig 10: the edge, both angles and the contact point at their computed positions."""
    figure = Figure(figsize=(0.6 * canvas.width, 3.3), layout="constrained")
    axes = figure.subplots()
    slide = Slide(np.radians(35.0))
    x = slide.travel(100)[[38]]
    centre, c, phi_n = MM * slide.centre(x)[0], MM * slide.contact(x)[0], slide.phi_n(x)[0]
    r, face = MM * slide.radius, slide.face
    ground(axes, [[-50, 0], [0, 0], (80 * face).tolist()])
    axes.plot([0, 26], [0, 0], color=MUTED, lw=0.8, ls="--")
    axes.add_patch(Circle(tuple(centre), r, facecolor="none", edgecolor=DEPTH, lw=1.3))
    axes.plot([centre[0], centre[0] + 1.35 * r], [centre[1]] * 2, color=MUTED, lw=0.8, ls="--")
    axes.plot([centre[0], c[0]], [centre[1], c[1]], color=DEPTH, lw=1.0)
    axes.plot(*centre, "o", color=DEPTH, ms=4)
    axes.plot(*c, "o", color=FORCE, ms=5)
    axes.add_patch(Arc((0, 0), 26, 26, theta1=0, theta2=35.0, color=FORCE, lw=1.4))
    lean = np.degrees(phi_n)
    axes.add_patch(Arc(tuple(centre), 15, 15, theta1=min(lean, 0), theta2=max(lean, 0), color=DEPTH, lw=1.4))
    axes.text(15, 4.0, "$φ_f$", color=FORCE, fontsize=12, va="center")
    label = centre + 10.5 * np.array([np.cos(0.5 * phi_n), np.sin(0.5 * phi_n)])
    axes.text(label[0], label[1], "$φ_n$", color=DEPTH, fontsize=12, ha="center", va="center")
    axes.text(c[0] + 2.5, c[1] - 2.6, "contact point c", color=FORCE, fontsize=9)
    axes.text(centre[0] - 1.2, centre[1] - 0.6, "centre x", fontsize=9, color=DEPTH, ha="right")
    axes.text(centre[0] - 0.62 * r, centre[1] + 0.9 * r, "SPR, radius r", fontsize=9, color=DEPTH, ha="right")
    arrow(axes, np.array([-26.0, centre[1]]), np.array([12.0, 0.0]), INK)
    axes.text(-26, centre[1] + 1.2, "motion of the SPR", fontsize=8.5)
    axes.text(-33, -6, "previous face", fontsize=8.5, color=INK)
    axes.text(
        39 * face[0], 39 * face[1] - 3.6, "next face", fontsize=8.5, color=INK, rotation=35, rotation_mode="anchor"
    )
    values = f"$φ_f$ = 35°,  $φ_n$ = {lean:.1f}°,  $c$ = ({c[0]:.2f}, {c[1]:.2f}) mm,  $c_y = c_x$ tan $φ_f$"
    axes.set_title(values, fontsize=8.5, loc="left")
    plain(axes, (-34, 44), (-10, 31))
    return figure


def sinusoids(canvas: Canvas) -> Figure:
    """Fig 11 A-F: path of the contact point (red), its steps (blue), and c_y over the tool's travel."""
    figure = Figure(figsize=(canvas.width, 4.1), layout="constrained")
    panels = figure.subplots(2, 6)
    for k, degrees in enumerate(FACES):
        slide = Slide(np.radians(degrees))
        x = slide.travel(400)
        c, rate = MM * slide.contact(x), slide.rate(x)
        top, axes = panels[0, k], panels[1, k]
        top.plot(c[:, 0], c[:, 1], color=FORCE, lw=2.6, solid_capstyle="butt")
        side = 3.0 * slide.normal
        seen = np.flatnonzero((c[:, 0] < 33) & (np.linalg.norm(rate, axis=1) > 0.1))
        for i in seen[np.linspace(0, len(seen) - 1, 6).astype(int)]:
            arrow(top, c[i] + side, 4.0 * rate[i] / np.linalg.norm(rate[i]), DEPTH, 0.9)
        slope = np.degrees(np.arctan2(*(np.sign(rate @ slide.face)[:, None] * rate).T[::-1]))
        off = np.abs(slope - degrees)[np.linalg.norm(rate, axis=1) > 0.1].max()
        top.set_title(f"{'ABCDEF'[k]}  $φ_f$ = {degrees:g}°\nslope off by {_power(off)}°", fontsize=8.5, loc="left")
        top.set(xlim=(-7, 36), ylim=(-4, 31), aspect="equal")
        axes.plot(MM * x, c[:, 1], color=FORCE)
        axes.plot(
            MM * x, MM * slide.height + MM * slide.radius * np.sin(slide.phi_n(x)), color=INK, lw=0.8, ls=(0, (2, 3))
        )
        axes.set(xlabel="travel [mm]", xlim=(-18, 62), ylim=(-3, 29))
        if k:
            top.set_yticklabels([])
            axes.set_yticklabels([])
    panels[0, 0].set(xlabel="$c_x$ [mm]", ylabel="$c_y$ [mm]")
    panels[1, 0].set(ylabel="$c_y$ [mm]")
    panels[1, 0].legend(["$c_y$", "h + r sin $φ_n$"], loc="upper left", fontsize=6.8, handlelength=1.3)
    return figure


def noise(canvas: Canvas) -> Figure:
    """Eq 18 with noise: error of the angle for a baseline of 80 um."""
    figure = Figure(figsize=(0.6 * canvas.width, 2.9), layout="constrained")
    axes = figure.subplots()
    sigma = np.logspace(-7, -3, 33)
    axes.loglog(1e6 * sigma, [angle_noise(s, draws=40_000) for s in sigma], color=FORCE, label="Eq 18, simulated")
    small = np.degrees(2**0.5 * sigma / BASELINE)
    axes.loglog(
        1e6 * sigma, np.where(small < 60, small, np.nan), color=INK, lw=0.8, ls=(0, (2, 3)), label="√2 σ / 80 µm"
    )
    for s in NOISES:
        value = angle_noise(s)
        axes.plot(1e6 * s, value, "o", color=FORCE, ms=5)
        axes.annotate(f"{value:.0f}°", (1e6 * s, value), xytext=(-4, 6), textcoords="offset points", ha="right")
    axes.set(xlabel="noise of each coordinate of a contact point [µm]", ylabel="rms error of $φ_f$ [deg]")
    axes.set_title("two points a tick apart: 20 mm/s at 250 Hz is 80 µm", fontsize=8.5, loc="left")
    axes.legend(loc="lower right")
    return figure


def two_candidates(canvas: Canvas) -> Figure:
    """Eqs 19, 20: both candidate normals, the selected one, and edges where the selection is wrong."""
    figure = Figure(figsize=(canvas.width, 2.9), layout="constrained")
    panels = figure.subplots(1, 4)
    for axes, degrees in zip(panels, (-50.0, 50.0, 89.0, 125.0), strict=True):
        slide = Slide(np.radians(degrees))
        x = slide.travel(100)[[25]]
        centre, c = MM * slide.centre(x)[0], MM * slide.contact(x)[0]
        ground(axes, [[-60, 0], [0, 0], (90 * slide.face).tolist()])
        axes.add_patch(Circle(tuple(centre), MM * slide.radius, facecolor="none", edgecolor=DEPTH, lw=1.2))
        picked, fails = eq20(slide)
        for n in candidates(slide.phi_f):
            good = bool(n @ picked > 0)
            arrow(axes, c, 15 * n, (FORCE if fails else GOOD) if good else MUTED, 1.8 if good else 1.0)
        arrow(axes, np.array([-40.0, 0.0]), np.array([0.0, 12.0]), CAP, 1.4)
        axes.text(-42, 14, "$x_n$", color=CAP, fontsize=9)
        axes.plot(*c, "o", color=INK, ms=3.5)
        kind = "convex" if degrees < 0 else "concave"
        verdict = "wrong" if fails else "right"
        axes.set_title(f"{kind}, $φ_f$ = {degrees:g}°: {verdict}", fontsize=8.5, loc="left")
        plain(axes, (-46, 34), (-28, 36))
    figure.supxlabel("green or red: picked by Eq 20      grey: the other candidate of Eq 19", fontsize=7.5, color=MUTED)
    return figure


def _power(x: float) -> str:
    return f"{x:.0e}".replace("e-0", "e-") if x > 0 else "0"
