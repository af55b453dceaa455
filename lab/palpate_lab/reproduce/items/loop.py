"""Fig 3: the control loop as a block diagram, with the values of a record."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import FancyBboxPatch

from palpate.base.arrays import Array
from palpate.base.plotting.style import CAP, FORCE, INK, MUTED, TOOL, Canvas
from palpate.record.layout import topic
from palpate.record.ticks import SIGNALS as RECORDED
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.reproduce.items.palpation import Palpation, palpation


@dataclass(frozen=True)
class _Named:
    """A signal that the paper's figure names, with our recorded signal."""

    symbol: str
    ours: str
    meaning: str


NAMED = (
    _Named("x_d", "p_WP", "desired position: the proxy on the surface"),
    _Named("x", "p_WT", "position of the instrument's tip"),
    _Named("δx = x_d − x", "delta_x", "deflection"),
    _Named("ẋ", "v_LH", "velocity of the handle"),
    _Named("K δx", "F_spring_W", "spring force"),
    _Named("B ẋ", "F_damping_W", "damping force"),
    _Named("F", "F_H_L", "force on the hand, after the frames"),
    _Named("Υ Π_E", "tau_gravity", "gravity compensation"),
    _Named("Jᵀ F", "tau_force", "torques of the force"),
    _Named("τ", "tau", "commanded torques"),
    _Named("q, q̇", "q", "joints of the master, measured"),
)


def fig3(work: Work) -> Outcome:
    """Every named signal is a recorded channel; the values of the deepest tick close the loop."""
    p = palpation(work.seed)
    k = p.deepest
    unknown = [one.ours for one in NAMED if one.ours not in RECORDED]
    delta = float(np.abs(p["delta_x"] - (p["p_WP"] - p["p_WT"])).max())
    total = float(np.abs(p["tau"][k] - p["tau_force"][k] - p["tau_gravity"][k] - p["tau_platform"][k]).max())
    good = not unknown and delta < 1e-9 and total < 1e-9
    rows = [
        {"symbol": one.symbol, "channel": topic(RECORDED[one.ours]), "meaning": one.meaning,
         "unit": RECORDED[one.ours].unit, "value_at_the_deepest_tick": _numbers(p[one.ours][k])}
        for one in NAMED
    ]  # fmt: skip
    cells = "".join(
        f"<tr><td>{r['symbol']}</td><td><code>{r['channel']}</code></td><td>{r['meaning']}</td><td>{r['unit']}</td></tr>"
        for r in rows
    )
    return Outcome(
        "agrees" if good else "differs",
        {"named_signals": len(NAMED), "signals_without_a_channel": unknown, "delta_x_less_x_d_plus_x_m": delta,
         "tau_less_its_terms_Nm": total},
        "block diagram of the controller with δx = x_d − x of the PSM and the MTM's implicit dynamics (no numbers)",
        "The loop that runs has the paper's blocks and signals, each recorded at every tick. Ours has three more, "
        "which "
        "the paper's lacks: guidance, stability (passivity, caps) and the limits of the drives.",
        rows,
        [Drawing("", f"The loop with the values of the deepest tick (t = {p.t[k]:.2f} s) of a simulated palpation.",
                 partial(_diagram, p, k))],
        '<div class="scroll"><table class="signals"><tr><th>symbol</th><th>channel</th>'
        "<th>meaning</th><th>unit</th></tr>"
        f"{cells}</table></div>",
    )  # fmt: skip


def _numbers(x: Array) -> str:
    return " ".join(f"{value:.6g}" for value in np.atleast_1d(x))


def _diagram(p: Palpation, k: int, canvas: Canvas) -> Figure:
    figure = Figure(figsize=(canvas.width, 3.9), layout="constrained")
    axes = figure.subplots()
    axes.set(xlim=(0, 100), ylim=(0, 42), xticks=[], yticks=[])
    axes.axis("off")
    v = {name: p[name][k] for name in p.signals}

    def vector(x: Array, scale: float = 1.0, digits: int = 2) -> str:
        return "(" + ", ".join(f"{scale * value:.{digits}f}" for value in x[:3]) + ")"

    boxes = {
        "mtm": (1, 26, 18, 12, "MTM dynamics", "M q̈ + C q̇ + G = τ + Jᵀ F_hand\nsimulated, with the hand", TOOL),
        "psm": (28, 26, 17, 12, "mapping, PSM", f"x = {vector(v['p_WT'], 1e3, 1)} mm", TOOL),
        "env": (55, 26, 19, 12, "environment", f"x_d = {vector(v['p_WP'], 1e3, 1)} mm\nproxy on the surface", TOOL),
        "kb": (72, 5, 22, 12, "K, B",
               f"K δx = {vector(v['F_spring_W'])} N\n−B ẋ = {vector(v['F_damping_W'], 1.0, 4)} N", FORCE),
        "h": (42, 5, 20, 12, "frames, stability",
              f"F = {vector(v['F_H_L'])} N\n|F| = {np.linalg.norm(v['F_H_L']):.2f} N", FORCE),
        "j": (16, 5, 18, 12, "Jᵀ F", f"{vector(v['tau_force'], 1.0, 3)} N m", FORCE),
        "g": (11, 19.6, 24, 4.4, "", f"Υ Π_E = {vector(v['tau_gravity'], 1.0, 3)} N m", CAP),
    }  # fmt: skip
    for x, y, w, h, title, text, colour in boxes.values():
        axes.add_patch(FancyBboxPatch((x, y), w, h, boxstyle="round,pad=0.4", fc="white", ec=colour, lw=1.3))
        if title:
            axes.text(x + w / 2, y + h - 2.6, title, ha="center", va="center", fontsize=9, color=INK, weight="bold")
        axes.text(x + w / 2, y + (h - 3.2 if title else h) / 2, text, ha="center", va="center", fontsize=7, color=INK)
    for cx, cy in ((86, 32), (7, 11)):
        axes.add_patch(FancyBboxPatch((cx - 1.6, cy - 1.8), 3.2, 3.6, boxstyle="round,pad=0.3", fc="white", ec=INK))
        axes.text(cx, cy, "Σ", ha="center", va="center", fontsize=11)
    _arrow(axes, (19.6, 32), (27.4, 32), "x_hand")
    _arrow(axes, (45.6, 32), (54.4, 32), "")
    axes.text(47.2, 33.1, "x", fontsize=7.5, color=INK)
    _arrow(axes, (74.6, 32), (83.8, 32), "+ x_d")
    axes.plot([50, 50, 86, 86], [32, 40.5, 40.5, 36], color=MUTED, lw=1.1)
    _arrow(axes, (86, 38), (86, 34.4), "")
    axes.text(87, 36.5, "− x", fontsize=7.5, color=INK)
    _arrow(axes, (86, 29.6), (86, 17.8), "")
    axes.text(87, 23.5, f"δx = {vector(v['delta_x'], 1e3)} mm", fontsize=7.5, color=FORCE)
    _arrow(axes, (71.4, 11), (62.8, 11), "K δx − B ẋ")
    _arrow(axes, (41.4, 11), (34.8, 11), "F")
    _arrow(axes, (15.4, 11), (9.2, 11), "")
    axes.plot([10.6, 7], [21.8, 21.8], color=MUTED, lw=1.1)
    _arrow(axes, (7, 21.8), (7, 13.6), "")
    axes.plot([4.8, 2.0], [11, 11], color=MUTED, lw=1.1)
    _arrow(axes, (2.0, 11), (2.0, 25.4), "")
    axes.text(2.8, 15.4, "τ", fontsize=9, color=INK)
    axes.text(10.4, 12.4, "Jᵀ F", fontsize=7, color=MUTED)
    axes.text(50, 1.0, "blue: motion     red: force     all values in the world frame, torques of the first three "
                       "joints",
              ha="center", fontsize=7, color=MUTED)  # fmt: skip
    return figure


def _arrow(axes: Axes, start: tuple[float, float], end: tuple[float, float], label: str) -> None:
    axes.annotate(
        "", end, start, arrowprops={"arrowstyle": "-|>", "color": MUTED, "lw": 1.1, "shrinkA": 0, "shrinkB": 0}
    )
    if label:
        axes.text((start[0] + end[0]) / 2, (start[1] + end[1]) / 2 + 1.1, label, ha="center", fontsize=7.5, color=INK)


ITEMS = (
    Item("fig3", "The control loop", "Section 2.4, Fig 3",
         "A block diagram of the controller: the deflection δx = x_d − x of the PSM becomes a force, which is "
         "rendered on "
         "the MTM together with gravity compensation; the MTM's dynamics are those of the real arm.",
         fig3, ("R4", "R23"), "x_d is the proxy, the nearest allowed position of the tool.",
         ("core/palpate/loop/haptics.cpp", "core/palpate/loop/signals.inl")),
)  # fmt: skip
