"""Phrases of the pages on motion plans."""

from __future__ import annotations

from phrases.values import Result, Tie, control, least, most

ASSISTANCE = {
    "none": "none",
    "drawn": "the plan drawn in the picture",
    "tube": "the wall of the tube alone",
    "follow": "led along the plan, in its tube",
}
SCENES = ("liver, gallbladder, duodenum", "closed cage with one window of 12 mm", "two instruments crossing")


def planning_rows(found: Result) -> list[str]:
    rows = found["rows"]
    ways = [(r["straight"], r["retracted"], r["queries"] - r["straight"] - r["retracted"]) for r in rows]
    return [
        f"| {name} | {round(r['success_rate'] * r['queries'])} of {r['queries']} | "
        f"{r['median_s']:.2f} and {r['p95_s']:.2f} s | {way[0]}, {way[1]}, {way[2]} | "
        f"{r['violations']} of {r['checked_samples']:,} |"
        for name, r, way in zip(SCENES, rows, ways, strict=True)
    ]


def planning_again(found: Result) -> list[str]:
    return [
        f"| {name} | {1e3 * r['replan_wall_p50_s']:.0f} and {1e3 * r['replan_wall_p95_s']:.0f} ms | "
        f"{round(r['replan_success_rate'] * r['replans'])} of {r['replans']} |"
        for name, r in zip(SCENES, found["rows"], strict=True)
    ]


def planning_limits(found: Result) -> list[str]:
    """What the numbers of plans prove."""
    rows = found["rows"]
    (n,) = {r["queries"] for r in rows}
    assert all(r["success_rate"] == 1.0 for r in rows)
    counts = {(round(r["replan_success_rate"] * r["replans"]), r["replans"]) for r in rows} - {(n, n)}
    return [f"{k} of {m} is at least {least(k, m)}" for k, m in ((n, n), *counts)]


def execution_rows(found: Result) -> list[str]:
    return [
        f"| {row['mode']} | {row['stops']} at {1e3 * row['speed_m_s']:.0f} mm/s | "
        + " | ".join(
            f"{1e3 * row[f'{what}_median_s']:.0f} / {1e3 * row[f'{what}_worst_s']:.0f} ms"
            for what in ("goal", "tool", "slow")
        )
        + " |"
        for row in found["rows"]
    ]


def planning_checks(found: Result) -> list[str]:
    rows = found["rows"]
    assert all(row["straight"] + row["retracted"] == row["queries"] for row in rows), "none needed OMPL"
    assert max(row["largest_step_m"] for row in rows) < 0.25e-3
    return [f"jerks at 1 kHz reach {max(row['worst_rate'] for row in rows):.3f} of their limits"]


def planners(found: Result) -> list[str]:
    rows = {row["planner"]: row for row in found["rows"]}
    best = min(rows.values(), key=lambda row: (-row["success_rate"], row["median_s"]))
    assert best["planner"] == "RRTConnect", "the default"
    (n,) = {row["queries"] for row in rows.values()}
    return [
        f"{n} of {n} is at least {least(n, n)}",
        *(
            f"| {name} | {round(row['success_rate'] * row['queries'])} of {row['queries']} | {row['median_s']:.2f} s |"
            for name, row in rows.items()
        ),
        control("planning_hooks"),
    ]


def collisions(found: Result) -> list[str]:
    judged = found["brute_force"]
    assert judged["disagreements"] == 0
    assert judged["worst_distance_error_m"] < 1e-9, "less than a nanometre"
    return [
        f"On {judged['poses']:,} random poses of a capsule at an organ, Coal and brute force never disagreed (at most "
        f"{most(0, judged['poses'], 2)})"
    ]


def execution_settles(found: Result) -> list[str]:
    (settled,) = {f"{1e3 * row['slow_median_s']:.0f}" for row in found["rows"]}
    assert all(row[f"{what}_worst_s"] < 0.05 for row in found["rows"] for what in ("goal", "tool", "slow"))
    return [f"the tip falls below 1 mm/s after {settled} ms"]


def planning_answer(found: Result) -> list[str]:
    less = found["conditions"]["follow"]["entry_reduction"]
    return [f"simulated operators enter the margin of 3 mm by {100 * less:.0f} % less"]


def execution_load(found: Result) -> list[str]:
    return [f"under a load of {max(row['load'] for row in found['rows']):.0f}"]


def study_rows(found: Result) -> list[str]:
    by = found["conditions"]
    return [
        f"| {words} | {by[name]['entry_mm_s']:.3f} mm s | {by[name]['deepest_mm']:.2f} mm | "
        f"{by[name]['path_error_mm']:.2f} mm |"
        for name, words in ASSISTANCE.items()
    ]


def study_text(found: Result) -> list[str]:
    led = found["conditions"]["follow"]
    low, high = (f"{100 * share:.0f}" for share in led["entry_reduction_95"])
    trials = sum(row["trials"] for row in found["conditions"].values())
    drawn, tube = (f"{100 * found['conditions'][name]['entry_reduction']:.0f}" for name in ("drawn", "tube"))
    assert led["done"] == 1.0
    assert (
        found["conditions"]["tube"]["entry_reduction_95"][0]
        < 0.0
        < found["conditions"]["drawn"]["entry_reduction_95"][0]
    )
    return [
        f"drawn in the picture by {drawn} %, and with the wall of the tube alone by {tube} %",
        f"16 simulated operators, {trials} trials)",
        f"by {100 * led['entry_reduction']:.0f} % less (95 % interval: {low} to {high} %)",
    ]


def stiffness_rows(found: Result) -> list[str]:
    phrases = []
    for name, row in found["conditions"].items():
        low, high = (f"{100 * share:.0f}" for share in row["entry_reduction_95"])
        less = "" if name == "none" else f" {100 * row['entry_reduction']:.0f} % ({low} to {high} %)"
        spring = "none" if name == "none" else f"{name} N/m"
        phrases.append(f"| {spring} | {row['entry_mm_s']:.3f} mm s |{less} | {row['deepest_mm']:.2f} mm | "
                       f"{row['path_error_mm']:.2f} mm |")  # fmt: skip
    return phrases


TIES = [
    Tie("planning-study.md", "planning_study", (study_rows, study_text)),
    Tie("planning-study.md", "planning_stiffness", (stiffness_rows,)),
    Tie("planning.md", "planning", (planning_rows, planning_again, planning_checks, planning_limits)),
    Tie("planning.md", "planning_study", (planning_answer,)),
    Tie("planning.md", "planning_hooks", (planners,)),
    Tie("planning.md", "collisions", (collisions,)),
    Tie("planning-execution.md", "execution", (execution_rows, execution_settles)),
    Tie("planning-execution.md", "execution_ros", (execution_rows, execution_load)),
]
