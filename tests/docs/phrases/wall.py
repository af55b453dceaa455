"""Phrases of the page on the paper's virtual wall."""

from __future__ import annotations

from phrases.values import Result, Tie


def peak_mm(row: Result) -> str:
    """The overshoot is a percentage of 0.385 m."""
    return f"{3.85 * row['overshoot_percent']:.1f}"


def off(row: Result, key: str, published: str, scale: float = 1.0) -> str:
    return f"{100.0 * (scale * row[key] / row['published'][published] - 1.0):+.0f}"


def table_row(r: Result) -> str:
    p = r["published"]
    settles = "never" if r["settling_s"] is None else f"{r['settling_s']:.2f}"
    over = f"**{r['overshoot_percent']:.{1 if r['limit_cycle'] else 2}f}**" + (
        " and growing" if r["limit_cycle"] else ""
    )
    rests = f"{'swings +-' if r['limit_cycle'] else ''}{1e3 * r['steady_state_m']:.{0 if r['limit_cycle'] else 1}f}"
    return (
        f"| {r['kd']:g} | {p['offshoot_percent']:g}, {over} | {3.85 * p['offshoot_percent']:.1f}, {peak_mm(r)} | "
        f"{p['response_s']:g}, {settles} | {p['steady_state_cm'] / 10:.1f}, {rests} | "
        f"{1e3 * r['energy_J']:.0f} |"
    )


def wall_rows(found: Result) -> list[str]:
    return [table_row(row) for row in found["rows"]]


def wall_misses(found: Result) -> list[str]:
    first, second, third = found["rows"]
    less = -float(off(first, "overshoot_percent", "offshoot_percent"))
    pairs = {
        key: [off(row, key, published, scale) for row in (second, third)]
        for key, published, scale in (("overshoot_percent", "offshoot_percent", 1.0), ("settling_s", "response_s", 1.0),
                                      ("steady_state_m", "steady_state_cm", 1e4))
    }  # fmt: skip
    return [
        "({} and {} %)".format(*pairs["overshoot_percent"]),
        f"row 1 overshoots {less:.0f} % less than published",
        "settling is off by {} and {} %".format(*pairs["settling_s"]),
        "the resting depth by {} and {} %".format(*pairs["steady_state_m"]),
    ]


def wall_text(found: Result) -> list[str]:
    first, second, third = found["rows"]
    shipped = {(r["rate_Hz"], r["kd"]): r["overshoot_percent"] for r in found["other_rates"]}
    passive = found["passive_rows"]
    change = max(abs(a["overshoot_percent"] / b["overshoot_percent"] - 1.0)
                 for a, b in zip(passive[1:], found["rows"][1:], strict=True))  # fmt: skip
    assert not any(row["limit_cycle"] for row in passive)
    return [
        f"speed out over speed in: {first['rebound']:.2f} at the first bounce",
        f"({1e3 * first['swing_m']:.0f} mm peak to peak) after four seconds",
        f"rows 2 and 3 come to {shipped[250.0, 5.0]:.2f} and {shipped[250.0, 10.0]:.2f} %",
        f"to {shipped[100.0, 5.0]:.1f} % (oscillating) and {shipped[100.0, 10.0]:.2f} %",
        f"falls from {second['rigidity_N_per_m']:.0f} to {third['rigidity_N_per_m']:.0f} N/m",
        f"Row 1 overshoots {passive[0]['overshoot_percent']:.1f} % and settles in {passive[0]['settling_s']:.2f} s",
        f"as before to within {100.0 * change:.1g} %",
        f"({-1e3 * min(row['energy_J'] for row in passive):.0f} mJ)",
    ]


def wall_hands(found: Result) -> list[str]:
    assert {row["hands"]["people"] for row in found["rows"]} == {100}
    shares = [round(100.0 * row["hands"]["limit_cycle_share"]) for row in found["rows"]]
    return [rf"| {row['kd']:g} \|.*\| {share or 'none'} |" for row, share in zip(found["rows"], shares, strict=True)]


TIES = [Tie("wall.md", "wall", (wall_rows, wall_misses, wall_text, wall_hands))]
