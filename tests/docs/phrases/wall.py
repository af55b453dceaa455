"""Phrases of the page on the paper's virtual wall."""

from __future__ import annotations

from phrases.values import Result, Tie, both, rows_by


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


def two_digits(value: float) -> str:
    return f"{value:.{1 if value >= 1.0 else 2}f}"


def wall_hands(found: Result) -> list[str]:
    phrases = []
    for row in found["rows"]:
        low, middle, high = (two_digits(one) for one in row["hands"]["overshoot_percent"])
        swing, people = round(row["hands"]["limit_cycle_share"] * row["hands"]["people"]), row["hands"]["people"]
        phrases.append(f"| {row['kd']:g} | {middle} % | {low} to {high} % | {swing} ({both(swing, people)}) |")
    (people,) = {row["hands"]["people"] for row in found["rows"]}
    assert found["rows"][-1]["hands"]["limit_cycle_share"] == 0.0
    left = round(found["rows"][1]["hands"]["limit_cycle_share"] * people)
    return [
        *phrases,
        f"Left: {people} other hands",
        f"left out are {left} of {people} ({both(left, people)}) at 5, none at 10 and 20",
    ]


def wall_unmet(found: Result) -> list[str]:
    second, third = found["rows"][1:]
    response, rest = (
        [f"{row['published'][key] * scale:.1f}" for row in (second, third)]
        for key, scale in (("response_s", 1.0), ("steady_state_cm", 0.1))
    )
    return [
        f"the settling times ({second['settling_s']:.2f} and {third['settling_s']:.2f} s against the published "
        f"{response[0]} and {response[1]} s) and the resting depths ({1e3 * second['steady_state_m']:.1f} and "
        f"{1e3 * third['steady_state_m']:.1f} mm against {rest[0]} and {rest[1]} mm) are not met",
        f"The swing grows to {float(peak_mm(found['rows'][0])):.0f} mm inside",
    ]


def wall_sensitivity(found: Result) -> list[str]:
    """Rows 2 and 3 with a value changed by a fifth, against the same rows of the fitted hand."""
    fitted = [row["overshoot_percent"] for row in found["rows"][1:]]

    def changes(*names: str) -> list[float]:
        return [100.0 * abs(mine / own - 1.0) for row in found["sensitivity"] if row["name"] in names
                for mine, own in zip(row["overshoot_percent"][1:], fitted, strict=True)]  # fmt: skip

    (slow,) = (row for row in found["sensitivity"] if row["name"] == "delay_s" and row["factor"] > 1.0)
    assert slow["limit_cycle"] == [True, True, False], "row 2 oscillates, too"
    much, little = changes("push_N", "approach_s", "stiffness_N_per_m"), changes("mass_kg", "damping_N_s_per_m")
    return [f"rows by {min(much):.0f} to {max(much):.0f} %; mass and damping by {max(little):.0f} % at most"]


def wall_rigidity(found: Result) -> list[str]:
    by = rows_by(found["curve"], "kd")
    assert by[20.0]["people"] == 100
    rigidity = [f"{by[kd]['rigidity_N_per_m'][1]:.0f}" for kd in (5.0, 10.0, 20.0)]
    rebound = [f"{by[kd]['rebound'][1]:.2f}" for kd in (5.0, 10.0, 15.0)]
    return [
        "it does not fall: {}, {} and {} N/m at 5, 10 and 20".format(*rigidity),
        "falls with damping: {}, {} and {} at K_d 5, 10 and 15".format(*rebound),
    ]


def wall_fit(found: Result) -> list[str]:
    fit = found["fit"]
    first, second, third = fit["overshoot_percent"]
    return [
        f"ends at {fit['mass_kg']:.2f} kg, {fit['damping_N_s_per_m']:.2f} N s/m, {fit['stiffness_N_per_m']:.0f} N/m, a "
        f"push of {fit['push_N']:.1f} N and {1e3 * fit['delay_s']:.1f} ms, which makes {second:.2f} and {third:.2f} %, "
        f"and {first:.1f} % in row 1"
    ]


TIES = [
    Tie("wall.md", "wall", (wall_rows, wall_misses, wall_text, wall_hands, wall_unmet, wall_sensitivity)),
    Tie("wall.md", "wall", (wall_rigidity,)),
    Tie("wall.md", "wall_fit", (wall_fit,)),
]
