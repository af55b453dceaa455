"""The figures of a report. Each function draws a run for a canvas (wide page or phone)."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from palpate.base.plotting.style import CAP, CELL, DEPTH, FORCE, INK, JOINTS, MUTED, PHASES, Canvas, curve
from palpate.report.assumptions import FAST_FORCE
from palpate.report.grasp import grasp_of
from palpate.report.run import Run
from palpate.report.soft import soft_law
from palpate.world.tissue import indentation

SHADED = 80
"""Phases of a run up to which they are shaded; more would be narrower than the lines."""


def story(run: Run, canvas: Canvas) -> Figure:
    """Force on the hand, penetration and neglected inertia force over time, with the phases of the touch."""
    figure = _figure(canvas, 6.0, 6.4)
    force, depth, own = figure.subplots(3, 1, sharex=True, height_ratios=[2.2, 1.3, 1.0])
    _shade(run, (force, depth, own), canvas)
    _forces(force, run, canvas)
    curve(depth, run.t, 1e3 * run.ticks["depth"], canvas.points(), color=DEPTH)
    depth.set_ylabel("penetration [mm]")
    depth.set_ylim(bottom=0)
    _inertia(own, run, canvas)
    own.set_xlabel("time [s]")
    _span(run, own)
    return figure


def _forces(force: Axes, run: Run, canvas: Canvas) -> None:
    """Draw the rendered force and the load cell's, and in a bilateral run also those on the tool."""
    ticks, t, points = run.ticks, run.t, canvas.points()
    rendered = np.linalg.norm(ticks["F_H_L"], axis=1)
    cell = np.linalg.norm(ticks["F_cell_L"], axis=1)
    curve(force, t, cell, points, color=CELL, lw=0.8, label="load cell in the hand (simulated)")
    curve(force, t, rendered, points, color=FORCE, label="rendered on the hand")
    if ticks["F_estimate_W"].any():  # bilateral
        real = np.linalg.norm(ticks["F_touch_W"], axis=1)
        curve(force, t, real, points, color=JOINTS[2], lw=0.9, label="real objects on the tool (simulated)")
        estimate = np.linalg.norm(ticks["F_estimate_W"], axis=1)
        curve(force, t, estimate, points, color=JOINTS[4], lw=0.9, label="estimated from the follower's drives")
    cap = run.setting("stability", "force_cap")
    top = max(float(rendered.max()), float(np.percentile(cell, 99.9)))
    if cap is not None:
        force.axhline(cap, color=CAP, lw=0.9, ls=(0, (5, 3)), label=f"force cap, {cap:g} N")
        top = max(top, float(cap))
    force.set_ylim(0, (1.55 if canvas.narrow else 1.22) * top if top > 0 else 1.0)
    _legend(force, canvas, 3)
    force.set_ylabel("force [N]")


def _inertia(own: Axes, run: Run, canvas: Canvas) -> None:
    """Draw the neglected inertia force, and the limit up to which the motion counts as slow."""
    limit = float(run.setting("torque", "fast_force") or FAST_FORCE)
    curve(own, run.t, run.ticks["F_neglected"], canvas.points(), color=MUTED, lw=0.9)
    own.axhline(limit, color=CAP, lw=0.9, ls=(0, (5, 3)))
    own.annotate(
        f"slow motion: below {limit:g} N",
        (1, limit),
        xycoords=("axes fraction", "data"),
        ha="right",
        va="bottom",
        xytext=(-2, 1),
        textcoords="offset points",
        fontsize=7,
        color=CAP,
    )
    own.set_ylabel("inertia [N]" if canvas.narrow else "arm's own\ninertia [N]")
    own.set_ylim(bottom=0, top=max(1.4 * limit, own.get_ylim()[1]))


def stiffness(run: Run, canvas: Canvas) -> Figure:
    """Rendered force over penetration: the line is the spring, the deviations are damping."""
    figure = _figure(canvas, 4.2, 3.9)
    panels: Any = figure.subplots(1, 1) if canvas.narrow else figure.subplots(1, 2, width_ratios=[1.25, 1])
    axes: Axes = panels if canvas.narrow else panels[0]
    ticks = run.ticks
    rows = np.flatnonzero(ticks["depth"] > 0)
    rows = rows[:: max(1, len(rows) // 4000)]
    depth = 1e3 * ticks["depth"][rows]
    law = np.einsum("ij,ij->i", ticks["F_T_W"][rows], ticks["normal"][rows])
    image = axes.scatter(depth, law, c=run.t[rows], s=3, cmap="cividis", alpha=0.7, lw=0, rasterized=True)
    axes.set(xlabel="penetration [mm]", ylabel="force on the tool, along the normal [N]")
    figure.colorbar(image, ax=axes, label="time [s]", pad=0.02).outline.set_visible(False)
    soft = soft_law(run)
    if soft is not None and len(depth):
        reach = np.linspace(0, 1.05 * depth.max(), 100)
        for E, style, words in ((soft.rest, "-", "relaxed"), (soft.fast, "--", "fast")):
            law = indentation.sneddon(soft.radius, 1e-3 * reach, E, soft.poisson)
            axes.plot(reach, law, style, color=INK, lw=0.9, label=f"half-space, {words}: {1e-3 * E:.3g} kPa")
        axes.legend(loc="upper left")
    elif run.stiffness is not None:
        reach = np.array([0, 1.05 * depth.max()])
        axes.plot(reach, 1e-3 * reach * run.stiffness, color=INK, lw=0.9, label=f"spring: {run.stiffness:.0f} N/m")
        axes.legend(loc="upper left")
    if not canvas.narrow:
        _terms_of_law(run, panels[1], canvas)
    return figure


def _terms_of_law(run: Run, axes: Axes, canvas: Canvas) -> None:
    ticks, points = run.ticks, canvas.points() // 2
    _shade(run, (axes,), canvas, names=False)
    for name, label, color in (("F_spring_W", "spring  K δx", FORCE), ("F_damping_W", "damping  −B ẋ", DEPTH)):
        along = np.einsum("ij,ij->i", ticks[name], ticks["normal"])
        curve(axes, run.t, along, points, color=color, lw=0.9, label=label)
    axes.set(xlabel="time [s]", ylabel="along the normal [N]")
    _span(run, axes)
    _headroom(axes, 0.12)
    axes.legend(loc="upper right", ncols=2, handlelength=1.2)


def grasp(run: Run, canvas: Canvas) -> Figure:
    """Angle of the jaws, forces of both jaws, and the pull beside the friction that holds it."""
    figure, held = _figure(canvas, 4.6, 5.4), grasp_of(run)
    panels = figure.subplots(3, 1, sharex=True, height_ratios=[1.0, 1.0, 1.4])
    points = canvas.points()
    for name, label, color in (("jaw_goal", "goal", MUTED), ("jaw", "jaws", INK)):
        curve(panels[0], run.t, np.degrees(run.ticks[name]), points, color=color, lw=1.0, label=label)
    panels[0].set_ylabel("jaws [°]")
    if held is not None:
        for k, color in enumerate((FORCE, DEPTH)):
            curve(panels[1], run.t, held.jaws[k], points, color=color, lw=1.0, label=f"jaw {k + 1}")
        curve(panels[2], run.t, held.limit, points, color=CAP, lw=0.9, label=f"{held.friction:g} times both forces")
        curve(panels[2], run.t, held.pull, points, color=FORCE, lw=1.0, label="pull along the jaws")
    panels[1].set_ylabel("squeeze [N]")
    panels[2].set(xlabel="time [s]", ylabel="pull [N]")
    for axes in panels:
        _headroom(axes, 0.3)
        _legend(axes, canvas, 2)
    _span(run, panels[2])
    return figure


def torques(run: Run, canvas: Canvas) -> Figure:
    """The terms of Eq 13, one line per joint."""
    terms = [
        ("tau_force", r"rendered force:  $J^T F$"),
        ("tau_gravity", r"gravity compensation:  $\hat G(q)$"),
        ("tau_platform", "position control of joint 4"),
    ]
    figure = _figure(canvas, 3.6, 6.4)
    panels = figure.subplots(3, 1, sharex=True) if canvas.narrow else figure.subplots(1, 3, width_ratios=[1, 1, 1])
    for axes, (name, title) in zip(panels, terms, strict=True):
        _shade(run, (axes,), canvas, names=False)
        for joint, color in enumerate(JOINTS):
            values = run.ticks[name][:, joint]
            curve(axes, run.t, values, canvas.points() // 3, color=color, lw=0.9, label=f"{joint + 1}")
        axes.set_title(title, loc="left", fontsize=8.5, color=INK)
        _span(run, axes)
    panels[0].set_ylabel("torque [N m]")
    for axes in panels if not canvas.narrow else panels[-1:]:
        axes.set_xlabel("time [s]")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=7, title="joint", handlelength=1.2)
    return figure


def energy(run: Run, canvas: Canvas) -> Figure:
    """The energy ledger: energy from the hand, and where it went."""
    ticks = run.ticks
    figure = _figure(canvas, 3.4, 3.6)
    axes = figure.subplots()
    _shade(run, (axes,), canvas)
    entries = [
        ("energy_port", "taken from the hand", INK, 1.5),
        ("energy_spring", "stored in the springs", FORCE, 1.0),
        ("energy_damping", "dissipated by damping", DEPTH, 1.0),
        ("energy_cut", "withheld by the caps", CAP, 1.0),
    ]
    kept = ("energy_passivity", "energy_low_pass", "energy_coupling")
    entries += [
        (name, f"withheld by the {name[7:].replace('_', '-')}", JOINTS[i], 1.0)
        for i, name in enumerate(kept)
        if ticks[name].any()
    ]
    for name, label, color, width in entries:
        curve(axes, run.t, 1e3 * run.ticks[name], canvas.points(), color=color, lw=width, label=label)
    withheld = sum((ticks[name] for name in kept), ticks["energy_cut"])
    if ticks["energy_model"].any():
        label = "added to the springs by updates of the model"
        curve(axes, run.t, 1e3 * ticks["energy_model"], canvas.points(), color=JOINTS[3], lw=1.0, label=label)
    given = ticks["energy_port"] + withheld + ticks["energy_model"]
    rest = given - ticks["energy_spring"] - ticks["energy_damping"]
    style = {"color": MUTED, "lw": 1.0, "ls": (0, (4, 2))}
    curve(axes, run.t, 1e3 * rest, canvas.points(), label="the rest: mostly friction", **style)
    axes.axhline(0, color=MUTED, lw=0.6)
    axes.set(xlabel="time [s]", ylabel="energy [mJ]")
    _headroom(axes, 0.7 if canvas.narrow else 0.3)
    _legend(axes, canvas, 5)
    _span(run, axes)
    return figure


def frames(run: Run, canvas: Canvas) -> Figure:
    """The commanded force in the leader's base (spatial) and in the handle (body): the paper's green and red."""
    figure = _figure(canvas, 3.0, 4.6)
    panels = figure.subplots(2, 1, sharex=True) if canvas.narrow else figure.subplots(1, 2, sharey=True)
    for axes, name, title in zip(
        panels,
        ("F_H_L", "F_H_H"),
        ("in the leader's base L (spatial frame)", "in the handle H (body frame)"),
        strict=True,
    ):
        _shade(run, (axes,), canvas, names=False)
        for i, (axis, color) in enumerate(zip("xyz", JOINTS, strict=False)):
            curve(axes, run.t, run.ticks[name][:, i], canvas.points() // 2, color=color, lw=0.9, label=axis)
        axes.set_title(title, loc="left", fontsize=8.5, color=INK)
        _span(run, axes)
    panels[0].set_ylabel("force [N]")
    panels[1].set_xlabel("time [s]")
    if not canvas.narrow:
        panels[0].set_xlabel("time [s]")
    _headroom(panels[0], 0.2)
    panels[0].legend(loc="upper left", ncols=3, handlelength=1.2)
    return figure


def timing(run: Run, canvas: Canvas) -> Figure:
    """Compute time of the cycle and lateness of its start, which only a real-time record contains."""
    figure = _figure(canvas, 3.2, 5.0)
    panels = figure.subplots(2, 1) if canvas.narrow else figure.subplots(1, 2)
    period = 1e6 / run.record.rate
    for axes, name, title in zip(
        panels, ("cycle_us", "lateness_us"), ("time to compute a cycle", "start after its deadline"), strict=True
    ):
        _histogram(axes, run.digest.times[name].values, period)
        axes.set_title(title, loc="left", fontsize=8.5, color=INK)
    panels[0].set_ylabel("ticks")
    return figure


def _histogram(axes: Axes, values: NDArray[Any], period: float) -> None:
    values = np.maximum(values, 0.05)
    edges = np.geomspace(max(0.05, 0.8 * values.min()), max(1.3 * period, 1.3 * values.max()), 90)
    axes.hist(values, bins=edges.tolist(), color=DEPTH, alpha=0.85)
    axes.set(xscale="log", yscale="log", xlabel="time [µs]")
    axes.minorticks_off()
    marks = [(float(np.percentile(values, 50)), "p50"), (float(np.percentile(values, 99)), "p99")]
    for x, name in marks:
        axes.axvline(x, color=INK, lw=0.8)
        _upright(axes, f"{name}  {x:.3g} µs", x)
    axes.axvline(period, color=CAP, lw=0.9, ls=(0, (5, 3)))
    _upright(axes, f"period  {period:.0f} µs", period, CAP)
    axes.set_ylim(0.7, 30 * axes.get_ylim()[1])


def _upright(axes: Axes, text: str, x: float, color: str | None = None) -> None:
    """Write vertical text at x, hanging from the top of the axes."""
    at = ("data", "axes fraction")
    axes.annotate(text, (x, 0.98), (2, 0), at, "offset points", va="top", fontsize=7, rotation=90, color=color)


def _figure(canvas: Canvas, wide: float, narrow: float) -> Figure:
    return Figure(figsize=(canvas.width, narrow if canvas.narrow else wide), layout="constrained")


def _shade(run: Run, panels: tuple[Axes, ...], canvas: Canvas, names: bool = True) -> None:
    """Shade the phases, and name them on the first panel where there is room."""
    whole = max(1e-9, float(run.t[-1] - run.t[0]))
    for phase in run.phases if len(run.phases) <= SHADED else ():
        for axes in panels:
            axes.axvspan(phase.start, phase.end, color=PHASES[phase.name], lw=0, zorder=0)
        room = (phase.end - phase.start) / whole * canvas.width
        if names and room > 0.10 * len(phase.name):
            middle = 0.5 * (phase.start + phase.end)
            where = ("data", "axes fraction")
            panels[0].annotate(phase.name, (middle, 1.01), xycoords=where, ha="center", fontsize=7.5, color=MUTED)


def _span(run: Run, axes: Axes) -> None:
    start, end = float(run.t[0]), float(run.t[-1])
    axes.set_xlim(start, end if end > start else start + 1e-3)
    axes.xaxis.set_major_locator(MaxNLocator(nbins=8, steps=[1, 2, 5, 10]))


def _headroom(axes: Axes, share: float) -> None:
    """Extend the y axis upwards to make room for a legend."""
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + share * (high - low))


def _legend(axes: Axes, canvas: Canvas, columns: int) -> None:
    axes.legend(loc="upper right", ncols=1 if canvas.narrow else columns, handlelength=1.6)
