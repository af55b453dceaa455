"""The work of ``palpate study wall``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Literal, cast

import numpy as np

from palpate.studies._command import Sweeper
from palpate.studies.wall.bench import KP, Outcome, Press, Setting, Trace, judge, press
from palpate.studies.wall.result import Changed, Found, Hands, Person, Row, Traces
from palpate.sweep import Axis, Label
from palpate.sweep.grid import Point

KDS = (0.0, 5.0, 10.0)  # Table 1 [N s/m]
CURVE = (0.0, 2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0)  # [N s/m]
BETWEEN = 100  # hands on the walls of the curve that are not in Table 1
SHIPPED = (250.0, 100.0)  # rates of the authors' published code [Hz]
PASSIVE = "observer"
Measured = Literal["overshoot_percent", "settling_s", "rigidity_N_per_m", "rebound"]
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


def run(sweep: Sweeper, hands: int) -> tuple[Found, Traces]:
    """The result with the keys of docs/json.md; by K_d the presses of the fitted hand, without and with passivity."""
    hand = Press.fitted()
    traces = {kd: (press(Setting(kd), hand), press(Setting(kd, passivity=PASSIVE), hand)) for kd in KDS}
    people = others(sweep, hands)
    found: Found = {
        "simulated": True,
        "leader": "mtm_right",
        "rate_Hz": Setting(0.0).rate,
        "hand": asdict(hand),
        "rows": [{**row(kd, traces[kd][0]), "hands": spread(people, kd)} for kd in KDS],
        "passive_rows": [row(kd, traces[kd][1]) for kd in KDS],
        "other_rates": [
            {"rate_Hz": rate, **row(kd, press(Setting(kd, rate=rate), hand))} for rate in SHIPPED for kd in KDS
        ],
        "sensitivity": sensitivity(hand),
        "curve": [{"kd": kd, **spread(people, kd)} for kd in CURVE],
    }
    return found, traces


def row(kd: float, trace: Trace) -> Row:
    """A row of Table 1 with its gains, and the published one beside it."""
    return cast(Row, {"kp": KP, "kd": kd} | asdict(judge(trace)) | {"published": asdict(TABLE_1[kd])})


def others(sweep: Sweeper, hands: int) -> list[Person]:
    """Every hand on every wall of the curve."""
    grid = {"kd": Axis(CURVE, "N s/m", "damping of the wall"), "person": Axis(range(hands), "", "number of a hand")}
    return cast(list[Person], sweep(measure, grid, title="hands", labels=LABELS, where=wanted).rows())


def wanted(point: Point) -> bool:
    """All hands on the walls of Table 1, the first ones in between."""
    return point["kd"] in KDS or point["person"] < BETWEEN


def measure(point: Point, seed: int) -> dict[str, float]:
    """One hand on one wall; the hand follows from its number alone, so that every wall meets the same hands."""
    outcome = judge(press(Setting(point["kd"]), Press.fitted().of_another(point["person"])))
    return {name: float("nan") if (x := getattr(outcome, name)) is None else float(x) for name in LABELS}


def spread(people: list[Person], kd: float) -> Hands:
    """Of all hands on one wall: 5, 50 and 95 % of them lie below."""
    mine = [one for one in people if one["kd"] == kd]
    rests = [one for one in mine if not one["limit_cycle"]]

    def quantiles(name: Measured, of: list[Person]) -> list[float] | None:
        values = [one[name] for one in of if one[name] == one[name]]
        return [float(x) for x in np.quantile(values, (0.05, 0.5, 0.95))] if values else None

    return {
        "people": len(mine),
        "overshoot_percent": quantiles("overshoot_percent", mine) or [],
        "settling_s": quantiles("settling_s", rests),
        "rigidity_N_per_m": quantiles("rigidity_N_per_m", rests),
        "rebound": quantiles("rebound", mine) or [],
        "limit_cycle_share": 1.0 - len(rests) / len(mine),
    }


def sensitivity(hand: Press) -> list[Changed]:
    """What each value, a fifth lower and higher, does to the rows."""
    rows: list[Changed] = []
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
