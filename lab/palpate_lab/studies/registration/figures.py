"""The picture of ``palpate study registration``: predicted target errors, and a partial liver before and after."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse

from palpate.base.arrays.rigid import inverse, transform
from palpate.base.plotting.style import INK, JOINTS, MUTED, SURFACE, Canvas, png
from palpate.world.registration import fit, points, surface
from palpate_lab.studies.registration import fiducials, surfaces
from palpate_lab.studies.registration.result import Found

_LARGER = 40.0  # errors are drawn this many times larger
_SEED = 3


def draw(found: Found, folder: Path) -> Path:
    """Draw the picture into ``folder``; returns the file."""
    path = folder / "registration.png"
    png(lambda canvas: picture(found, canvas), path)
    return path


def picture(found: Found, canvas: Canvas) -> Figure:
    """Three panels: predicted against simulated error, ellipses around targets, and the liver."""
    figure = Figure(figsize=(canvas.width, 4.2), layout="constrained")
    left, middle, right = figure.subplots(1, 3)
    _predicted(left, found)
    _ellipses(middle)
    _liver(right)
    return figure


def _predicted(axes: Axes, found: Found) -> None:
    top = 0.0
    for (name, rows), color in zip(found["layouts"].items(), JOINTS, strict=False):
        x, y = (1e3 * np.array([row[key] for row in rows]) for key in ("simulated_m", "predicted_m"))
        axes.plot(x, y, "o", ms=4, mfc="none", color=color, label=f"{name} errors")
        top = max(top, float(x.max()), float(y.max()))
    line = np.array([0.0, 1.1 * top])
    axes.plot(line, line, color=INK, lw=0.8)
    axes.fill_between(line, 0.9 * line, 1.1 * line, color=MUTED, alpha=0.2, lw=0, label="within 10 %")
    axes.set(xlabel="simulated TRE, rms [mm]", ylabel="predicted TRE, rms [mm]", xlim=line, ylim=line)
    axes.set_title("8 markers, FLE 0.25 mm, target at 100 mm", loc="left")
    _legend(axes)


def _legend(axes: Axes) -> None:
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), handlelength=1.2)


def _ellipses(axes: Axes) -> None:
    """One layout from above: simulated errors of three targets and the predicted 95 % ellipses."""
    rng = np.random.default_rng(_SEED)
    m = fiducials.layout(rng)
    goals = np.array([[0.0, 0.0, 0.0], [0.1, 0.03, 0.0], [-0.05, 0.11, 0.02]])
    axes.plot(*(1e3 * m[:, :2].T), "s", ms=4, color=INK, label="markers")
    for k in range(250):
        f = m + fiducials.FLE / np.sqrt(3.0) * rng.normal(size=m.shape)
        errors = transform(fit.closed_form(m, f), goals) - goals
        shown = 1e3 * (goals + _LARGER * errors)
        axes.plot(*shown[:, :2].T, ".", ms=1.5, color=JOINTS[1], label=None if k else "simulated targets")
    found = points(m, m + 1e-9, goals, fle=fiducials.FLE)
    for one in found.targets:
        values, vectors = np.linalg.eigh(one.covariance[:2, :2])
        size = 2.0 * np.sqrt(5.991 * values) * 1e3 * _LARGER  # 95 % of a plane
        angle = float(np.degrees(np.arctan2(vectors[1, 1], vectors[0, 1])))
        axes.add_patch(Ellipse(tuple(1e3 * one.p[:2]), size[1], size[0], angle=angle, fill=False, ec=JOINTS[0], lw=1.4))
    axes.plot([], [], color=JOINTS[0], label="predicted, 95 %")
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    axes.set_title(f"Target errors, {_LARGER:g} times larger", loc="left")
    _legend(axes)


def _liver(axes: Axes) -> None:
    """A partial view on the liver from above, at the rough pose and as registered."""
    rng = np.random.default_rng(_SEED)
    fixed, pool, _ = surfaces.models()
    X = fiducials.pose(rng)
    seen = surfaces.view(rng, pool)
    m = transform(inverse(X), seen)
    start = surfaces.rough(rng, seen, X, (0.9 * surfaces.ANGLE, surfaces.ANGLE), surfaces.REACH)
    found = surface(m, fixed, start)
    for p, color, size, label in (
        (fixed[::4], SURFACE, 1.0, "surface"),
        (transform(start, m), MUTED, 1.5, "30 % of it seen, rough pose"),
        (transform(found.X, m), JOINTS[1], 1.5, "registered"),
    ):
        axes.plot(*(1e3 * p[:, :2].T), ".", ms=size, color=color)
        axes.plot([], [], "o", ms=4, color=color, label=label)
    axes.set(xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    axes.set_title("Partial liver, noise 1 mm, 5 % outliers", loc="left")
    _legend(axes)
