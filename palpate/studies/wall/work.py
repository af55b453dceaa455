"""The work of ``palpate study wall``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from rich.table import Table

from palpate.studies._command import Sweeper
from palpate.studies.wall.bench import KP, WALL, Outcome, Press, Setting, Trace, judge, press
from palpate.sweep import Axis, Label
from palpate.sweep.grid import Point

KDS = (0.0, 5.0, 10.0)  # Table 1 [N s/m]
CURVE = (0.0, 2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0)  # [N s/m]
BETWEEN = 100  # hands on the walls of the curve that are not in Table 1
SHIPPED = (250.0, 100.0)  # rates of the authors' published code [Hz]
PASSIVE = "observer"
Traces = dict[float, tuple[Trace, Trace]]
NUDGE = 0.2  # of the sensitivity, either way


@dataclass(frozen=True)
class Published:
    """A row of Table 1, as printed."""

    response_s: float
    offshoot_percent: float
    steady_state_cm: float
    """100, 15, 20 cm: 400 N/m over 1 m would be 400 N. Read with its point two places further left."""

    @property
    def steady_state_m(self) -> float:
        """As it is read here: 1.00, 0.15, 0.20 cm."""
        return 1e-4 * self.steady_state_cm


TABLE_1 = {0.0: Published(0.4, 10.2, 100.0), 5.0: Published(0.5, 1.27, 15.0), 10.0: Published(0.5, 1.25, 20.0)}

LABELS = {
    "overshoot_percent": Label("%", "largest penetration over 0.385 m"),
    "rigidity_N_per_m": Label("N/m", "load cell's force over depth, both at rest"),
    "settling_s": Label("s", "from the touch to within 5 % of the peak penetration"),
    "limit_cycle": Label("", "1: it oscillates at the end"),
    "rebound": Label("", "speed out of the wall over speed into it, first bounce"),
    "energy_J": Label("J", "taken from the hand"),
}


def run(sweep: Sweeper, hands: int) -> tuple[dict[str, Any], Traces]:
    """The result with the keys of docs/json.md; by K_d the presses of the fitted hand, without and with passivity."""
    hand = Press.fitted()
    traces = {kd: (press(Setting(kd), hand), press(Setting(kd, passivity=PASSIVE), hand)) for kd in KDS}
    people = others(sweep, hands)
    found = {
        "simulated": True,
        "leader": "mtm_right",
        "rate_Hz": Setting(0.0).rate,
        "hand": asdict(hand),
        "rows": [row(kd, traces[kd][0]) | {"hands": spread(people, kd)} for kd in KDS],
        "passive_rows": [row(kd, traces[kd][1]) for kd in KDS],
        "other_rates": [
            {"rate_Hz": rate} | row(kd, press(Setting(kd, rate=rate), hand)) for rate in SHIPPED for kd in KDS
        ],
        "sensitivity": sensitivity(hand),
        "curve": [{"kd": kd} | spread(people, kd) for kd in CURVE],
    }
    return found, traces


def row(kd: float, trace: Trace) -> dict[str, Any]:
    """A row of Table 1 with its gains, and the published one beside it."""
    return {"kp": KP, "kd": kd} | asdict(judge(trace)) | {"published": asdict(TABLE_1[kd])}


def others(sweep: Sweeper, hands: int) -> list[dict[str, Any]]:
    """Every hand on every wall of the curve."""
    grid = {"kd": Axis(CURVE, "N s/m", "damping of the wall"), "person": Axis(range(hands), "", "number of a hand")}
    return sweep(measure, grid, title="hands", labels=LABELS, where=wanted).rows()


def wanted(point: Point) -> bool:
    """All hands on the walls of Table 1, the first ones in between."""
    return point["kd"] in KDS or point["person"] < BETWEEN


def measure(point: Point, seed: int) -> dict[str, float]:
    """One hand on one wall; the hand follows from its number alone, so that every wall meets the same hands."""
    outcome = judge(press(Setting(point["kd"]), Press.fitted().of_another(point["person"])))
    return {name: float("nan") if (x := getattr(outcome, name)) is None else float(x) for name in LABELS}


def spread(people: list[dict[str, Any]], kd: float) -> dict[str, Any]:
    """Of all hands on one wall: 5, 50 and 95 % of them lie below."""
    mine = [one for one in people if one["kd"] == kd]
    rests = [one for one in mine if not one["limit_cycle"]]

    def quantiles(name: str, of: list[dict[str, Any]]) -> list[float] | None:
        values = [one[name] for one in of if one[name] == one[name]]
        return [float(x) for x in np.quantile(values, (0.05, 0.5, 0.95))] if values else None

    return {
        "people": len(mine),
        "overshoot_percent": quantiles("overshoot_percent", mine),
        "settling_s": quantiles("settling_s", rests),
        "rigidity_N_per_m": quantiles("rigidity_N_per_m", rests),
        "rebound": quantiles("rebound", mine),
        "limit_cycle_share": 1.0 - len(rests) / len(mine),
    }


def sensitivity(hand: Press) -> list[dict[str, Any]]:
    """What each value, a fifth lower and higher, does to the rows."""
    rows = []
    for name in [*(field.name for field in fields(hand)), "coulomb_scale"]:
        for factor in (1.0 - NUDGE, 1.0 + NUDGE):
            friction = factor if name == "coulomb_scale" else 1.0
            changed = hand if name == "coulomb_scale" else hand.scaled(**{name: factor})
            outcomes: list[Outcome] = [judge(press(Setting(kd, coulomb_scale=friction), changed)) for kd in KDS]
            rows.append(
                {
                    "name": name,
                    "factor": factor,
                    "overshoot_percent": [o.overshoot_percent for o in outcomes],
                    "limit_cycle": [o.limit_cycle for o in outcomes],
                }
            )
    return rows


def table(found: dict[str, Any]) -> Table:
    """Measured beside published."""
    title = "wall of 400 N/m at 0.385 m; published in brackets"
    out = Table(box=None, pad_edge=False, title=title, title_justify="left")
    columns = ("K_d", "passivity", "overshoot, %", "peak, mm", "settles, s", "rests at, mm", "limit cycle")
    for column in (*columns, "rebound", "energy, mJ"):
        out.add_column(column, justify="left" if column in ("passivity", "limit cycle") else "right")
    for rows, passivity in ((found["rows"], "off"), (found["passive_rows"], PASSIVE)):
        for r in rows:
            p = TABLE_1[r["kd"]] if passivity == "off" else None
            settles = "never" if r["settling_s"] is None else f"{r['settling_s']:.2f}"
            rests = f"+-{1e3 * r['steady_state_m']:.1f}" if r["limit_cycle"] else f"{1e3 * r['steady_state_m']:.2f}"
            out.add_row(
                f"{r['kd']:g}", passivity,
                f"{r['overshoot_percent']:.2f}" + (f" ({p.offshoot_percent:g})" if p else ""),
                f"{10 * WALL * r['overshoot_percent']:.1f}" + (f" ({10 * WALL * p.offshoot_percent:.1f})" if p else ""),
                settles + (f" ({p.response_s:g})" if p else ""),
                rests + (f" ({1e3 * p.steady_state_m:.1f})" if p else ""),
                f"{1e3 * r['swing_m']:.0f} mm" if r["limit_cycle"] else "no",
                f"{r['rebound']:.2f}",
                f"{1e3 * r['energy_J']:.1f}",
            )  # fmt: skip
    return out


def lines(found: dict[str, Any], hands: int) -> list[str]:
    """What the table does not say."""
    h = found["hand"]
    out = [
        "steady state as printed in the paper: 100, 15, 20 cm; 400 N/m over 1 m would be 400 N, so it is read as 1.00, "
        "0.15, 0.20 cm",
        f"one hand for all rows: {h['mass_kg']:.2g} kg, {h['damping_N_s_per_m']:.2g} N s/m, "
        f"{h['stiffness_N_per_m']:.3g} N/m, push {h['push_N']:.2g} N, approach {h['approach_s']:.2g} s; loop delay "
        f"{1e3 * h['delay_s']:.3g} ms at {found['rate_Hz']:g} Hz. A fit, not a proof: docs/wall.md",
    ]
    for r in found["rows"]:
        low, middle, high = r["hands"]["overshoot_percent"]
        out.append(
            f"K_d {r['kd']:g}: of {hands} other hands half overshoot {middle:.2f} %, 90 % between {low:.2f} and "
            f"{high:.2f} %; {100 * r['hands']['limit_cycle_share']:.0f} % of them oscillate"
        )
    for rate in SHIPPED:
        ends = [r for r in found["other_rates"] if r["rate_Hz"] == rate]
        words = ", ".join(
            f"{r['overshoot_percent']:.2f} %" + (" (oscillates)" if r["limit_cycle"] else "") for r in ends
        )
        out.append(f"at {rate:g} Hz, as in the published code: {words}")
    out.append("simulated leader (mtm_right), simulated hand")
    return out
