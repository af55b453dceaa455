"""The work of ``palpate study certificate``."""

from __future__ import annotations

import numpy as np
from rich.table import Table

from palpate import _verify
from palpate.arm.hands import Hand
from palpate.base.sweep.grid import Point
from palpate.devices.certificate import DeviceModel
from palpate.devices.certificate.certificate import certify_device
from palpate.devices.certificate.device import TAP
from palpate.devices.certificate.trials import edge
from palpate_lab.studies.certificate.result import Row, Summary

WITHIN = 0.05  # required relative agreement
_THROWS = 40  # disturbances per stiffness in the search for the simulated limit
_GAINS = (1.0, 0.9, 0.7, 0.4)  # tested stiffness as fractions of the certified stiffness
_TRIES = 20  # disturbances per certified stiffness
_FINE = 1.003
_PRESSES = (0.2, 10.0)  # [N]


def drawn(seed: int) -> tuple[DeviceModel, float]:
    """A random device with one hand, in the range of desktop devices and masters, and a wall damping [N s/m]."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:  # log-uniform
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    hand = Hand("random", between(0.03, 0.8), between(1.0, 25.0), between(30.0, 1000.0))
    device = DeviceModel(
        mass=between(0.03, 1.5), damping=between(0.02, 5.0), rate=between(200.0, 5000.0),
        delay=float(rng.uniform(0.0, 0.01)), filter=between(10.0, 300.0) if rng.random() < 0.7 else 0.0,
        quantum=between(1e-6, 5e-5), friction=between(0.02, 0.8), hand=hand,
    )  # fmt: skip
    share = float(rng.uniform(0.0, 0.6)) if rng.random() < 0.8 else 0.0
    return device, share * min(device.loop(hand).B_max, 20.0)


def judged(point: Point, seed: int) -> dict[str, float]:
    """Predicted and simulated limit of one device, and the number of certified stiffnesses that oscillate."""
    device, B = drawn(seed)
    certificate = certify_device(device, B=B)
    rng = np.random.default_rng([seed, 1])
    simulated = simulated_limit(device, B, certificate.k_linear, rng)
    broken = sum(
        oscillates(device, share * certificate.k_sure, B, _TRIES, rng) for share in _GAINS if certificate.k_sure > 0
    )
    numbers = {f"{name}_SI": float(getattr(device, name)) for name in _DRAWN}
    numbers |= {f"hand_{name}_SI": float(getattr(device.hands[0], name)) for name in ("mass", "damping", "stiffness")}
    return numbers | {
        "B_N_s_per_m": B, "predicted_N_per_m": certificate.k_max, "linear_N_per_m": certificate.k_linear,
        "simulated_N_per_m": simulated, "error": certificate.k_max / simulated - 1.0, "certified_broken": float(broken),
        **{f"{name}_N_per_m": bound for name, bound in certificate.bounds.items()},
    }  # fmt: skip


_DRAWN = ("mass", "damping", "rate", "delay", "filter", "quantum", "friction")


def simulated_limit(device: DeviceModel, B: float, near: float, rng: np.random.Generator) -> float:
    """The stiffness below which random disturbances decay, by bisection [N/m]."""
    low, high = 0.03 * near, 3.0 * near
    if oscillates(device, low, B, _THROWS, rng):
        return 0.0
    while not oscillates(device, high, B, _THROWS, rng):
        low, high = high, 2.0 * high
        if high > 1e9:
            return float("inf")
    low, high = edge(lambda K: oscillates(device, K, B, _THROWS, rng), low, high, _FINE)
    return float(np.sqrt(low * high))


def oscillates(device: DeviceModel, K: float, B: float, throws: int, rng: np.random.Generator) -> bool:
    """True if any of ``throws`` random disturbances leaves an oscillation.

    A disturbance is a press with an initial position and speed; its energy is at most that of a tap of speed `TAP`.
    """
    hand = device.hands[0]
    w = np.sqrt((K + hand.stiffness) / (device.mass + hand.mass))
    for i in range(throws):
        both = i % 3 == 0
        press = 0.0 if both else float(np.exp(rng.uniform(*np.log(_PRESSES))))
        speed = TAP * (rng.random() ** 0.1 if i % 2 else 10.0 ** rng.uniform(-2.0, 0.0))
        phase = rng.uniform(-np.pi, np.pi) if both else rng.choice([0.0, np.pi]) + rng.uniform(-0.5, 0.5)
        x0, v0 = press / (K + hand.stiffness) + speed / w * np.sin(phase), speed * np.cos(phase)
        if _verify.Axis(device.axis(hand, K, B, both)).run(x0=x0, v0=v0, push=press).oscillates:
            return True
    return False


def summary(rows: list[Row]) -> Summary:
    """Summarise the agreement over all devices."""
    error = np.array([row["error"] for row in rows])
    linear = np.array([row["linear_N_per_m"] / row["simulated_N_per_m"] - 1.0 for row in rows])
    return {
        "count": len(rows), "median_error": float(np.median(np.abs(error))),
        "largest_error": float(np.abs(error).max()), "share_within": float((np.abs(error) <= WITHIN).mean()),
        "linear_median_error": float(np.median(np.abs(linear))),
        "certified_gains": len(rows) * len(_GAINS),
        "certified_broken": int(sum(row["certified_broken"] for row in rows)),
    }  # fmt: skip


def table(summary: Summary) -> Table:
    """The summary as a table for a terminal."""
    out = Table(box=None, pad_edge=False, show_header=False, title="largest stable stiffness", title_justify="left")
    for name, value in (
        ("devices", f"{summary['count']:.0f}"),
        ("median disagreement", f"{100 * summary['median_error']:.2f} %"),
        ("largest", f"{100 * summary['largest_error']:.1f} %"),
        (f"within {100 * WITHIN:.0f} %", f"{100 * summary['share_within']:.1f} % of the devices"),
        ("without friction, counts, bounces", f"{100 * summary['linear_median_error']:.2f} % median disagreement"),
        ("certified gains that oscillate", f"{summary['certified_broken']:.0f} of {summary['certified_gains']:.0f}"),
    ):
        out.add_row(name, value)
    return out
