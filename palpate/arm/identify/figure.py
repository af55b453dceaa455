"""The figure of a gravity calibration: measured over predicted torque, and the residual, per joint."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from palpate.arm import Arm
from palpate.arm.identify.approach import directions
from palpate.arm.identify.fit_gravity import predicted
from palpate.arm.identify.gravity import Calibration
from palpate.base.plotting.style import DEPTH, FORCE, INK, MUTED, style


def save(c: Calibration, arm: Arm, path: Path) -> None:
    """Write the figure. Upper row: measured torque over holding torque. Lower row: residual over joint position."""
    judged = c.unseen if c.unseen is not None else c.poses
    hold, with_friction = c.model.holding(judged.q, arm), predicted(c.model, judged, arm)
    direction = directions(judged, c.model.drives(judged.q, arm))
    scores = c.test or c.train
    with style():
        figure = Figure(figsize=(2.5 * len(c.joints), 5.6), layout="constrained")
        axes = figure.subplots(2, len(c.joints))
        for k, joint in enumerate(c.joints):
            top, bottom = axes[:, k]
            for sign, colour, label in (
                (1, FORCE, "came upwards"),
                (-1, DEPTH, "came downwards"),
                (0, MUTED, "unknown"),
            ):
                rows = direction[:, joint] == sign
                if rows.any():
                    top.plot(hold[rows, joint], judged.tau[rows, joint], ".", color=colour, ms=2.5, label=label)
                    residual = (judged.tau - with_friction)[rows, joint]
                    bottom.plot(judged.q[rows, joint], residual, ".", color=colour, ms=2.5)
            ends = [hold[:, joint].min(), hold[:, joint].max()]
            top.plot(ends, ends, color=INK, lw=0.8)
            top.set_title(f"joint {joint + 1}\nR2 {scores.r2[k]:.3f} ({scores.r2_directed[k]:.3f})")
            top.set_xlabel("holding torque of the model [N m]")
            band = 1.96 * c.fitted.noise[joint]
            bottom.axhspan(-band, band, color=MUTED, alpha=0.15, lw=0)
            bottom.set_xlabel("joint [rad]")
            limit = max(
                4 * c.fitted.noise[joint], float(np.percentile(np.abs(judged.tau - with_friction)[:, joint], 98))
            )
            bottom.set_ylim(-limit, limit)
        axes[0, 0].set_ylabel("measured [N m]")
        axes[1, 0].set_ylabel("residual, approach known [N m]")
        axes[0, 0].legend(loc="upper left", markerscale=3)
        kind = "unseen" if c.unseen is not None else "training"
        shown = f"{len(c.poses)} poses trained on, {len(judged)} {kind} poses shown"
        figure.suptitle(f"{c.model.arm}: {c.model.form}, {shown}. R2: approach unknown (known)")
        figure.savefig(path, dpi=130)
