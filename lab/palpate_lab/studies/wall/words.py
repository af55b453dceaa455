"""Table and sentences of ``palpate study wall``: simulated values next to the published ones."""

from __future__ import annotations

from rich.table import Table

from palpate_lab.studies.wall.bench import WALL
from palpate_lab.studies.wall.result import StudyResult
from palpate_lab.studies.wall.work import PASSIVE, SHIPPED, TABLE_1


def table(found: StudyResult) -> Table:
    """Simulated values, with the published ones in brackets."""
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


def lines(found: StudyResult, hands: int) -> list[str]:
    """Sentences that follow the table."""
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
            f"{high:.2f} %; {r['hands']['not_at_rest']} of {r['hands']['people']} do not come to rest; settling and "
            "rigidity leave them out"
        )
    for rate in SHIPPED:
        ends = [r for r in found["other_rates"] if r["rate_Hz"] == rate]
        words = ", ".join(
            f"{r['overshoot_percent']:.2f} %" + (" (oscillates)" if r["limit_cycle"] else "") for r in ends
        )
        out.append(f"at {rate:g} Hz, as in the published code: {words}")
    out.append("simulated leader (mtm_right), simulated hand")
    return out
