"""The work of ``palpate study wall``."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any, Literal, cast

import numpy as np

from palpate.base.sweep import Axis, Label
from palpate.base.sweep.grid import Point
from palpate_lab.studies._command import Sweeper
from palpate_lab.studies.wall.bench import KP, Outcome, Setting, Trace, WallPress, judge, press
from palpate_lab.studies.wall.result import Changed, Hands, Person, Row, StudyResult, Traces

KDS = (0.0, 5.0, 10.0)  # damping of the walls in Table 1 [N s/m]
CURVE = (0.0, 2.5, 5.0, 7.5, 10.0, 15.0, 20.0, 30.0)  # damping of the walls of the curve [N s/m]
BETWEEN = 100  # number of hands on walls that are not in Table 1
SHIPPED = (250.0, 100.0)  # rates of the authors' published code [Hz]
PASSIVE = "observer"
Measured = Literal["overshoot_percent", "settling_s", "rigidity_N_per_m", "rebound"]
NUDGE = 0.2  # relative change for the sensitivity, in both directions


@dataclass(frozen=True)
class Published:
    """A printed row of Table 1."""

    response_s: float
    offshoot_percent: float
    steady_state_cm: float
    """Printed values 100, 15 and 20 cm. They are implausible, because 400 N/m times 1 m would be 400 N."""

    @property
    def steady_state_m(self) -> float:
        """Steady state with the decimal point moved by two places: 1.00, 0.15, 0.20 cm [m]."""
        return 1e-4 * self.steady_state_cm


TABLE_1 = {0.0: Published(0.4, 10.2, 100.0), 5.0: Published(0.5, 1.27, 15.0), 10.0: Published(0.5, 1.25, 20.0)}

LABELS = {
    "overshoot_percent": Label("%", "largest penetration over 0.385 m"),
    "rigidity_N_per_m": Label("N/m", "load cell's force over depth, both at rest"),
    "settling_s": Label("s", "from contact to within 5 % of the peak penetration"),
    "limit_cycle": Label("", "1 if its oscillation lasts"),
    "rebound": Label("", "exit speed over entry speed of the first bounce"),
    "energy_J": Label("J", "energy taken from the hand"),
}


def run(sweep: Sweeper, hands: int) -> tuple[StudyResult, Traces]:
    """The result with the keys of docs/json.md, and the fitted hand's traces by K_d without and with passivity."""
    hand = WallPress.fitted()
    traces = {kd: (press(Setting(kd), hand), press(Setting(kd, passivity=PASSIVE), hand)) for kd in KDS}
    people = others(sweep, hands)
    found: StudyResult = {
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
    """A simulated row of Table 1 with its gains and the published row."""
    return cast(Row, {"kp": KP, "kd": kd, **judge(trace), "published": asdict(TABLE_1[kd])})


def others(sweep: Sweeper, hands: int) -> list[Person]:
    """Results of other hands on the walls of the curve."""
    grid = {"kd": Axis(CURVE, "N s/m", "damping of the wall"), "person": Axis(range(hands), "", "number of a hand")}
    return cast(list[Person], sweep(measure, grid, title="hands", labels=LABELS, where=included).rows())


def included(point: Point) -> bool:
    """All hands on the walls of Table 1, but only the first hands on the other walls."""
    return point["kd"] in KDS or point["person"] < BETWEEN


def measure(point: Point, seed: int) -> dict[str, float]:
    """Measure one hand on one wall. A hand depends on its number alone, so all walls meet the same hands."""
    outcome: dict[str, Any] = {**judge(press(Setting(point["kd"]), WallPress.fitted().of_another(point["person"])))}
    return {name: float("nan") if (x := outcome[name]) is None else float(x) for name in LABELS}


def spread(people: list[Person], kd: float) -> Hands:
    """5, 50 and 95 % quantiles over all hands on one wall."""
    mine = [person for person in people if person["kd"] == kd]
    decays = [person for person in mine if not person["limit_cycle"]]
    rests = [person for person in decays if person["settling_s"] == person["settling_s"]]  # the others still move

    def quantiles(name: Measured, group: list[Person]) -> list[float] | None:
        values = [person[name] for person in group if person[name] == person[name]]
        return [float(x) for x in np.quantile(values, (0.05, 0.5, 0.95))] if values else None

    return {
        "people": len(mine),
        "overshoot_percent": quantiles("overshoot_percent", mine) or [],
        "settling_s": quantiles("settling_s", rests),
        "rigidity_N_per_m": quantiles("rigidity_N_per_m", rests),
        "rebound": quantiles("rebound", mine) or [],
        "limit_cycle_share": 1.0 - len(decays) / len(mine),
        "not_at_rest": len(mine) - len(rests),
    }


def sensitivity(hand: WallPress) -> list[Changed]:
    """Effect of each value on the rows, when it is changed by -20 % and +20 %."""
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
                    "overshoot_percent": [o["overshoot_percent"] for o in outcomes],
                    "limit_cycle": [o["limit_cycle"] for o in outcomes],
                }
            )
    return rows
