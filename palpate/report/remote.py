"""The section of a report about a remote site: delays, packets, and the model against the measured force."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from palpate.base.plotting.style import CAP, DEPTH, FORCE, MUTED, Canvas, curve
from palpate.report.run import Run

_FELT = 0.05  # N; smaller forces are no contact
_COARSE = 0.25  # time over which packets are counted [s]


def crossed(run: Run) -> bool:
    """True if the run had a remote site."""
    return bool((run.ticks["remote_link"] > 0.0).any())  # NaN in an older record


def words(run: Run) -> str:
    """Text above the figure."""
    ticks = run.ticks
    linked = ticks["remote_link"] > 1.5
    if not linked.any():
        return "The link to the remote site never stood: everything held."
    age, delay = (1e3 * float(np.median(ticks[name][linked])) for name in ("remote_age", "remote_delay"))
    share = 100.0 * float(linked.mean())
    paid, tank = 1e3 * float(ticks["energy_model"][-1]), 1e3 * float(ticks["energy_tank"][linked].min())
    text = (
        f"The remote tool was where the local one was {delay:.0f} ms before, and what it measured arrived {age:.0f} ms "
        f"later (medians). The link stood in {share:.1f} % of the run. Updates of the model added {paid:.2f} mJ to the "
        f"contact springs, less what they took; the tank never held less than {tank:.2f} mJ."
    )
    error = model_error(run)
    return text if error is None else f"{text} Model and measured force differ by {error:.3f} N rms in contact."


def model_error(run: Run) -> float | None:
    """Rms of the size of the model's force less the measured one, both at the time of the hand's motion [N].

    None without contact, or where the hand feels the measured force itself.
    """
    t, then, model, measured = _forces(run)
    if not model.any():
        return None
    there = np.interp(t, then, measured)
    touching = (model > _FELT) & (there > _FELT) & (run.ticks["remote_link"] > 1.5)
    return float(np.sqrt(np.mean((model - there)[touching] ** 2))) if touching.sum() > 10 else None


def _forces(run: Run) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], times of the hand's motion that the measured forces belong to [s], model and measured force [N]."""
    ticks, t = run.ticks, np.asarray(run.t)
    then = np.maximum.accumulate(t - ticks["remote_age"] - ticks["remote_delay"])
    return t, then, np.linalg.norm(ticks["F_T_W"], axis=1), np.linalg.norm(ticks["F_remote_W"], axis=1)


def figure(run: Run, canvas: Canvas) -> Figure:
    """Forces, delays and packets over time."""
    drawn = Figure(figsize=(canvas.width, 5.4), layout="constrained")
    force, delay, packets = drawn.subplots(3, 1, sharex=True, height_ratios=[2.0, 1.2, 0.8])
    ticks, points = run.ticks, canvas.points()
    t, then, model, measured = _forces(run)
    curve(force, then, measured, points, color=DEPTH, label="measured at the remote tool, at the hand's time")
    if model.any():
        curve(force, t, model, points, color=FORCE, label="model that the hand feels")
    force.set_ylabel("force on the tool [N]")
    force.legend(loc="upper right", fontsize="small")
    curve(delay, t, 1e3 * ticks["remote_age"], points, color=FORCE, label="age of the newest packet")
    curve(delay, t, 1e3 * ticks["remote_delay"], points, color=DEPTH, label="until the motion is executed")
    delay.set_ylabel("delay [ms]")
    delay.legend(loc="upper right", fontsize="small")
    _packets(packets, t, ticks["remote_received"])
    for axes in (force, delay, packets):
        axes.set_ylim(bottom=0.0)
        axes.fill_between(t, 0, 1, where=ticks["remote_link"] < 1.5, transform=axes.get_xaxis_transform(), color=CAP,
                          alpha=0.15, lw=0)  # fmt: skip
    packets.set_xlabel("time [s]; shaded: the link is down")
    return drawn


def _packets(axes: Axes, t: np.ndarray, received: np.ndarray) -> None:
    at = np.arange(t[0], t[-1] + _COARSE, _COARSE)
    rate = np.diff(np.interp(at, t, received)) / _COARSE
    axes.step(at[1:], rate, where="pre", color=MUTED, lw=1.0)
    axes.set_ylabel("packets [1/s]")
