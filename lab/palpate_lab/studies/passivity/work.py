"""The work of ``palpate study passivity``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from palpate import _core, _verify
from palpate.arm.hands import PRESETS, Hand
from palpate.base.arrays import Array
from palpate.base.sweep.grid import Point
from palpate.devices.certificate.certificate import SURE
from palpate.devices.certificate.device import DeviceModel
from palpate_lab.studies.passivity.result import Changed, Mode, Outcome, Ran, StudyResult

BOUND = 1e-3  # largest energy that a hand may extract at the port [J]
CHANGED = 0.01  # counted change of the force, relative to the largest force without the layer [-]
FRICTION_SHARE = 0.5  # fraction of the true friction that the layer assumes as certain [-]
LIGHTEST = PRESETS["relaxed"].mass  # smallest hand mass that the layer assumes [kg]
SECONDS = 4.0  # duration of the hand's path; it rests in the last quarter [s]
ModeName = Literal["off", "observer", "tank", "alone"]
MODES: tuple[ModeName, ...] = ("observer", "tank", "alone")  # alone: an observer without the device's friction
DELAYS = ((0.0, 0.001), (0.001, 0.005), (0.005, 0.010), (0.010, 0.020), (0.020, None))  # ranges of `by_delay` [s]
_DEPTH, _AWAY = 0.012, 0.020  # farthest intended positions of the hand inside and outside the wall [m]
_STROKE = (0.25, 0.8)  # duration of a stroke [s]
_REST = 0.2  # longest rest between two [s]


@dataclass(frozen=True)
class Case:
    """A device, its wall, and the intended motion of the hand."""

    axis: _verify.AxisOptions
    path: list[float]
    """Intended position of the hand in each cycle [m]; the wall is at x > 0."""

    @property
    def certified(self) -> bool:
        """True if the linear part of the certificate is stable with this hand, including its margin."""
        a = self.axis
        hand = Hand("its", a.hand_mass, a.hand_damping, a.hand_stiffness)
        device = DeviceModel(a.mass, a.damping, a.rate, a.delay, 0.0, a.velocity_cutoff, a.quantum, a.coulomb, hand)
        return bool(SURE * device.loop(hand).K_max(a.B)[0] >= a.K)

    def options(self, mode: str) -> _core.StabilityOptions:
        """Options of the layer in a mode, from data that a device has."""
        o, a = _core.StabilityOptions(), self.axis
        o.passivity = "observer" if mode == "alone" else mode  # type: ignore[assignment]
        o.delay, o.quantum = a.delay, a.quantum
        o.acceleration = max(o.acceleration, o.force_cap / (a.mass + LIGHTEST))  # the force accelerates a light handle
        friction, share = _core.CertainFriction(), 0.0 if mode == "alone" else FRICTION_SHARE
        friction.coulomb, friction.viscous = np.array([share * a.coulomb]), np.array([share * a.damping])
        friction.quantum = np.array([a.quantum])
        o.friction = friction
        return o

    def run(self, mode: str, seconds: float | None = None) -> tuple[_verify.AxisResult, Array]:
        """The result, and the rows t, x, v, F, energy of `_verify.Axis.trace`; None: as long as its judge needs."""
        return _verify.Axis(self.axis).trace(seconds, self.path[0], path=self.path, stability=self.options(mode))


def case(seed: int) -> Case:
    """A random case that is determined by the seed."""
    rng = np.random.default_rng(seed)
    o = _verify.AxisOptions()
    o.mass, o.damping, o.coulomb = log_uniform(rng, 0.05, 0.6), rng.uniform(0.0, 1.0), rng.uniform(0.0, 0.3)
    o.rate = float(rng.choice([500.0, 1000.0, 2000.0, 4000.0]))
    o.delay = float(rng.choice([0.0, rng.uniform(0.0, 0.005), rng.uniform(0.0, 0.05)]))
    o.quantum = log_uniform(rng, 1e-6, 5e-5)
    o.velocity_cutoff = float(rng.choice([0.0, 100.0]))
    o.K, o.B = log_uniform(rng, 50.0, 5000.0), float(rng.choice([0.0, rng.uniform(0.0, 10.0)]))
    hand = list(PRESETS.values())[rng.integers(len(PRESETS))].drawn(rng)
    o.hand_mass, o.hand_damping, o.hand_stiffness = hand.mass, hand.damping, hand.stiffness
    o.seed = seed % 2**32
    return Case(o, strokes(rng, round(SECONDS * o.rate), 1.0 / o.rate))


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A log-uniform random number."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def strokes(rng: np.random.Generator, n: int, dt: float) -> list[float]:
    """A path in and out of the wall: minimum-jerk strokes (Flash and Hogan 1985) between random positions, with rests.

    The intended position is constant in the last quarter and after it, mostly inside the wall: an oscillation is
    self-sustained.
    """
    x, path = -_AWAY * rng.uniform(0.2, 1.0), [np.zeros(0)]
    done, last = 0, False
    while not last:
        last = done > 0.25 * n
        goal = rng.uniform(-0.2 * _DEPTH if last else -_AWAY, _DEPTH)
        s = np.linspace(0.0, 1.0, max(2, round(rng.uniform(*_STROKE) / dt)))
        path.append(x + (goal - x) * s**3 * (10.0 - 15.0 * s + 6.0 * s**2))
        path.append(np.full(round(rng.uniform(0.0, _REST) / dt), goal))
        x, done = goal, done + len(path[-1]) + len(path[-2])
    positions = np.concatenate([*path, np.full(n, x)])
    return [float(v) for v in positions[:n]]


def port(axis: _verify.AxisOptions, rows: Array) -> tuple[Array, Array]:
    """(E_rendered, E_port) (n,) at each cycle [J]."""
    dx = np.diff(rows[:, 1], prepend=rows[0, 1])
    heat = np.cumsum(axis.coulomb * np.abs(dx) + axis.damping * axis.rate * dx**2)
    return rows[:, 4], rows[:, 4] + heat


def passive(axis: _verify.AxisOptions) -> bool:
    """True if the wall is passive for every hand: b + B >= K (T / 2 + delay) with the certain friction b."""
    return FRICTION_SHARE * axis.damping + axis.B >= axis.K * (0.5 / axis.rate + axis.delay)


def silent(axis: _verify.AxisOptions, o: _core.StabilityOptions, force: float, speed: float) -> bool:
    """True if the layer provably never acts for forces and speeds up to these bounds [N], [m/s].

    The conditions are a passive wall, inactive caps, and sufficient energy in the spring (docs/stability-passivity.md).
    """
    if not passive(axis) or force > o.force_cap or axis.K * speed + axis.B * 2 * speed * axis.rate > o.rate_cap:
        return False
    return pays(axis.K, o, force, speed, axis.rate)


def pays(K: float, o: _core.StabilityOptions, force: float, speed: float, rate: float = 1000.0) -> bool:
    """True if a spring K [N/m] stores enough energy to remove its force, for all forces and speeds up to the bounds.

    The condition is F^2 / 2K + allowance >= cost of holding F until delay + T and fading it out.
    """
    t, a = o.delay + 1.0 / rate, o.acceleration
    older = 0.5 * a / rate  # possible change of the velocity since its measurement [m/s]
    return all(
        F**2 / (2.0 * K) + o.allowance
        >= _verify.held_cost(F, u + older, a, 0.0, t) + _verify.fade_cost(F, u + older, a, t, _verify.FADE)
        for F in np.linspace(0.0, force, 65)[1:]
        for u in np.linspace(0.0, speed, 5)
    )


def experiment(point: Point, seed: int) -> Ran:
    """Run one case without the layer and in each of its `MODES`."""
    drawn = case(seed)
    a, o = drawn.axis, drawn.options("observer")
    off, rows = drawn.run("off")
    force, speed = float(np.abs(rows[:, 3]).max()), float(np.abs(rows[:, 2]).max())
    calm = force < 0.999 * o.force_cap and float(np.abs(np.diff(rows[:, 3])).max()) < 0.999 * o.rate_cap / a.rate
    each = {mode: drawn.run(mode) for mode in MODES}
    observer, tank, alone = (outcome(a, *each[mode], rows) for mode in MODES)
    return {
        "K_N_per_m": a.K, "B_N_s_per_m": a.B, "delay_s": a.delay, "rate_Hz": a.rate, "case_seed": seed,
        "passive": passive(a), "certified": drawn.certified, "calm": calm,
        "silent": silent(a, o, force, speed), "force_N": force, "speed_m_s": speed,
        "off": outcome(a, off, rows, rows), "observer": observer, "tank": tank, "alone": alone,
    }  # fmt: skip


def outcome(axis: _verify.AxisOptions, result: _verify.AxisResult, rows: Array, without: Array) -> Outcome:
    """Result of a run, compared with the rows of the run without the layer."""
    rendered, whole = port(axis, rows)
    n = min(len(rows), len(without))
    largest = float(np.abs(without[:, 3]).max())
    changed = float(np.abs(rows[:n, 3] - without[:n, 3]).max()) / largest if largest > 0.0 else 0.0
    return {"rendered_J": min(float(rendered.min()), result.energy_min), "port_J": float(whole.min()),
            "diverged": result.diverged, "oscillates": result.oscillates, "change": changed}  # fmt: skip


def summed_up(found: list[Ran]) -> StudyResult:
    """Summary with the figures of docs/stability-study.md."""

    def of(mode: ModeName) -> Mode:
        rows = [f[mode] for f in found]
        return {
            "mode": mode,
            "lowest_port_J": min(r["port_J"] for r in rows), "lowest_rendered_J": min(r["rendered_J"] for r in rows),
            "below_bound": sum(r["port_J"] < -BOUND for r in rows),
            "rendered_below_bound": sum(r["rendered_J"] < -BOUND for r in rows),
            "diverged": sum(r["diverged"] for r in rows), "oscillates": sum(r["oscillates"] for r in rows),
            "oscillates_certified": sum(f["certified"] and f[mode]["oscillates"] for f in found),
        }  # fmt: skip

    def changed(rows: list[Ran]) -> Changed:
        change = np.array([r["observer"]["change"] for r in rows])
        return {"runs": len(rows), "changed": int((change >= CHANGED).sum()),
                "largest_change": float(change.max(initial=0.0))}  # fmt: skip

    calm = [f for f in found if f["certified"] and f["calm"]]
    return {
        "runs": len(found), "bound_J": BOUND, "simulated": True,
        "modes": [of(mode) for mode in ("off", *MODES)],
        "changes": [
            {"of": "silent", **changed([f for f in found if f["silent"]])},
            {"of": "passive", **changed([f for f in found if f["passive"]])},
            {"of": "certified and calm", **changed(calm)},
            {"of": "certified", **changed([f for f in found if f["certified"]])},
            {"of": "all", **changed(found)},
        ],
        "by_delay": [
            {"from_s": low, "to_s": high,
             **changed([f for f in calm if low <= f["delay_s"] < (high or np.inf)])} for low, high in DELAYS
        ],
    }  # fmt: skip
