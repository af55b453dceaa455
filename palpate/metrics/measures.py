"""All measures of one record."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from palpate.base.arrays import Array
from palpate.base.arrays.peaks import SustainedPeak
from palpate.base.arrays.polyline import distance
from palpate.metrics.force import HARM, NEED, TOUCH, force_sensitivity
from palpate.metrics.smoothness import log_dimensionless_jerk, movements, sparc
from palpate.record import Record
from palpate.record.ticks import STATUS, Ticks

MOTION_RATE = 100.0
"""Rate at which motion is judged [Hz]: tremor, at 8 to 12 Hz, is seen, and noise of encoders hardly."""
_SIGNALS = (
    "t",
    "p_LH",
    "p_WT",
    "F_T_W",
    "F_touch_W",
    "contacts",
    "status",
    "guidance_gap",
    "guidance_fixture",
    "holding",
    "F_held_W",
)
_FORCES = (
    *("touches", "contact_s", "mean_force_N", "peak_force_N", "peak_50ms_N", "above_threshold_s", "impulse_Ns"),
    *("force_per_path_N_per_m", "force_sensitivity", "excess", "peaks", "unsteady", "force_error_N"),
)
_NEEDED = {
    frozenset(("p_LH",)): ("path_hand_m",),
    frozenset(("p_WT",)): (
        "path_tool_m",
        "movements",
        "sparc",
        "log_dimensionless_jerk",
        "force_per_path_N_per_m",
        "path_error_m",
    ),
    frozenset(("F_T_W", "F_touch_W")): _FORCES,
    frozenset(("status",)): ("clutches",),
    frozenset(("guidance_gap", "guidance_fixture")): ("margin_entries",),
    frozenset(("holding",)): ("drops",),
}
"""Signals, and the measures that are unknown where a thinned or older record lacks one of them."""
_CLUTCHED = STATUS["clutched"][0]


@dataclass(frozen=True)
class Wanted:
    """What a task asks for; a measure of what it does not ask for is NaN."""

    force: float | None = None
    """Force to hold [N]."""
    path: Array | None = None
    """(n, 3) way points in W [m]."""
    normal: Array | None = None
    """(3,) unit normal of the surface that the path lies on: distances along it do not count."""

    def force_error(self, F: Array) -> float:
        """Mean absolute error of the force (n,) in contact [N]."""
        return float("nan") if self.force is None else _mean(np.abs(F - self.force))

    def path_error(self, p: Array) -> float:
        """rms distance of positions (n, 3) from the path [m]."""
        p = p[np.isfinite(p).all(axis=1)]
        if self.path is None or not len(p):
            return float("nan")
        flat = np.eye(3) if self.normal is None else np.eye(3) - np.outer(self.normal, self.normal)
        away, _ = distance(p @ flat, np.concatenate([self.path[:1], self.path]) @ flat)
        return float(np.sqrt(np.square(away).mean()))


NOTHING = Wanted()
"""A task that asks for no force and no path."""


def summary(
    record: Record | str | Path,
    *,
    need: float = NEED,
    harm: float = HARM,
    threshold: float = NEED,
    wanted: Wanted = NOTHING,
    remote: bool = False,
) -> dict[str, float]:
    """Measures of how a task was performed.

    Args:
        record: of one pair.
        need: force that the task needs [N].
        harm: force above which the tissue is harmed [N].
        threshold: force above which time is counted [N].
        wanted: force and path that the task asks for, for the errors.
        remote: True: of the tool across the network and the force measured there, as they arrived (docs/network.md).

    Returns:
        In SI units, by names that end in their unit (docs/metrics.md). A record of any length needs memory for
        MOTION_RATE samples a second. NaN: not defined, e.g. a force where nothing was touched, or not recorded.

    Raises:
        RecordError: the record cannot be read. ValueError: `need` or `harm` is not positive.
    """
    record = record if isinstance(record, Record) else Record.open(record)
    taken = _Taken(record.rate, remote)
    for ticks in record.blocks((*_SIGNALS, *REMOTE) if remote else _SIGNALS):
        taken.add(ticks)
    found = taken.measures(need, harm, threshold, wanted)
    lacking = {name for need_of, names in _NEEDED.items() if not record.signals.keys() >= need_of for name in names}
    return {name: float("nan") if name in lacking else value for name, value in found.items()}


class _Taken:
    """What is kept of the ticks so far."""

    def __init__(self, rate: float, remote: bool = False) -> None:
        self.remote = remote
        self.rate, self.every, self.ticks = rate, max(1, round(rate / MOTION_RATE)), 0
        self.hand: list[Array] = []
        self.tool: list[Array] = []
        self.force: list[Array] = []
        self.peak = SustainedPeak(1.0 / rate)
        self.clutch, self.touch, self.margin, self.drop = (_Edges() for _ in range(4))

    def add(self, ticks: Ticks) -> None:
        """Take in the next block."""
        first = -self.ticks % self.every
        self.hand.append(ticks["p_LH"][first :: self.every].copy())  # the reader fills its block anew
        tool, F = remote_tool(ticks) if self.remote else (ticks["p_WT"], true_force(ticks))
        self.tool.append(tool[first :: self.every].copy())
        self.ticks += len(ticks)
        self.force.append(F.astype(np.float32))
        self.peak.add(F)
        self.clutch.add(ticks["status"].astype(np.uint64) & np.uint64(_CLUTCHED) != 0)
        self.touch.add(F > TOUCH)
        self.margin.add((ticks["guidance_fixture"] >= 0) & (ticks["guidance_gap"] < 0.0))
        self.drop.add(ticks["holding"] == 0, begun=True)

    def measures(self, need: float, harm: float, threshold: float, wanted: Wanted = NOTHING) -> dict[str, float]:
        """The measures of all ticks."""
        rate, F = self.rate / self.every, np.concatenate([*self.force, np.zeros(0, np.float32)])
        hand, tool = (np.concatenate([*rows, np.empty((0, 3))]) for rows in (self.hand, self.tool))
        touching = F[F > TOUCH]
        sensitivity = force_sensitivity(F, need, harm)
        path = _path(tool)
        return {
            "time_s": self.ticks / self.rate,
            "path_hand_m": _path(hand),
            "path_tool_m": path,
            **_smoothness(tool, rate),
            "clutches": self.clutch.count,
            "touches": self.touch.count,
            "margin_entries": self.margin.count,
            "drops": self.drop.count,
            "contact_s": len(touching) / self.rate,
            "mean_force_N": _mean(touching),
            "peak_force_N": float(F.max(initial=0.0)),
            "peak_50ms_N": self.peak.value,
            "above_threshold_s": float((threshold < F).sum()) / self.rate,
            "impulse_Ns": float(F.sum(dtype=float)) / self.rate,
            "force_per_path_N_per_m": _mean(touching) / path if path else float("nan"),
            "force_sensitivity": sensitivity.score,
            "excess": sensitivity.excess,
            "peaks": sensitivity.peaks,
            "unsteady": sensitivity.unsteady,
            "force_error_N": wanted.force_error(touching),
            "path_error_m": wanted.path_error(tool),
        }


class _Edges:
    """Counts how often a condition begins, also between blocks."""

    def __init__(self) -> None:
        self.count, self._before = 0, False
        self._first = True

    def add(self, holds: npt.NDArray[np.bool_], begun: bool = False) -> None:
        """Take in a block; `begun`: the condition does not count if it holds at the start."""
        if self._first:
            self._before, self._first = begun, False
        self.count += int((holds & ~np.concatenate(([self._before], holds[:-1]))).sum())
        self._before = bool(holds[-1]) if len(holds) else self._before


REMOTE = ("p_WR", "F_remote_W", "remote_received")
"""Signals of the tool across a network."""


def remote_tool(ticks: Ticks) -> tuple[Array, Array]:
    """Positions (n, 3) of the tool across the network [m], and force (n,) measured there [N], by the newest packets.

    Before the first packet it is where the local tool is, without force.
    """
    known = ticks["remote_received"] > 0
    force: Array = np.where(known, np.linalg.norm(ticks["F_remote_W"], axis=1), 0.0)
    return np.where(known[:, None], ticks["p_WR"], ticks["p_WT"]), force


TRUE_FORCE = ("F_T_W", "F_touch_W", "F_held_W")
"""Signals of `true_force`."""


def true_force(ticks: Ticks) -> Array:
    """Magnitude (n,) of the true force on the instrument [N].

    It is that of simulated tissue, else of the rendered contact, and of what the instrument holds or pushes.
    """
    rendered, touch, held = (np.nan_to_num(ticks[name]) for name in TRUE_FORCE)
    surface = np.where(np.any(touch != 0.0, axis=1, keepdims=True), touch, rendered)
    return np.asarray(np.linalg.norm(surface + held, axis=1))


def _smoothness(tool: Array, rate: float) -> dict[str, float]:
    """Means over the movements of the tool, each weighted by its duration."""
    speed = np.linalg.norm(np.diff(tool, axis=0), axis=1) * rate
    spans = movements(speed, rate)
    if not spans:
        return {"movements": 0, "sparc": float("nan"), "log_dimensionless_jerk": float("nan")}
    weights = [span.stop - span.start for span in spans]
    return {
        "movements": len(spans),
        "sparc": float(np.average([sparc(speed[span], rate) for span in spans], weights=weights)),
        "log_dimensionless_jerk": float(
            np.average([log_dimensionless_jerk(speed[span], rate) for span in spans], weights=weights)
        ),
    }


def _path(p: Array) -> float:
    """Length of a path (n, 3) [m]; not of what is NaN."""
    return float(np.nansum(np.linalg.norm(np.diff(p, axis=0), axis=1)))


def _mean(values: Array) -> float:
    return float(values.mean(dtype=float)) if len(values) else float("nan")
