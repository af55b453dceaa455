"""Phrases of the pages on guidance."""

from __future__ import annotations

from phrases.values import Result, Tie, least, most, percent, rows_by

TASKS = ("ring", "tracing", "palpation", "insertion")
PATHS = ("ring", "tracing", "insertion")


def joined(values: list[str]) -> str:
    return ", ".join(values)


def effects(found: Result) -> list[str]:
    by = rows_by(found["effects"], "task", "condition", "measure")

    def change(condition: str, measure: str, tasks: tuple[str, ...]) -> str:
        return joined([percent(by[task, condition, measure]["change"], "+") for task in tasks]) + " %"

    def g(condition: str, measure: str, tasks: tuple[str, ...]) -> str:
        values = [f"{by[task, condition, measure]['hedges_g']:+.1f}" for task in tasks]
        return joined([{"-0.0": "0.0", "+0.0": "0.0"}.get(value, value) for value in values])

    names = "ring, tracing, palpation, insertion"
    return [
        f"path error, guidance: ring, tracing, insertion | {change('guidance', 'path_error_mm', PATHS)} |",
        f"the same, hard, contact felt | {change('haptics+hard', 'path_error_mm', PATHS)} |",
        f"path error, guidance: ring, tracing, insertion | {g('guidance', 'path_error_mm', PATHS)} |",
        f"peak force, contact felt: {names} | {change('haptics', 'peak_force_N', TASKS)} |",
        f"peak force, the same | {g('haptics', 'peak_force_N', TASKS)} |",
        f"mean force, the same | {g('haptics', 'mean_force_N', TASKS)} |",
        f"time, contact felt, four tasks | {g('haptics', 'time_s', TASKS)} |",
        f"time, guidance, four tasks | {g('guidance', 'time_s', TASKS)} |",
    ]


def entries(found: Result) -> list[str]:
    by = rows_by(found["rows"], "task", "condition")
    return [
        f"{task} | "
        + joined([f"{by[task, c]['entries']:.2f}" for c in ("none", "haptics+guidance", "haptics+hard")])
        + " |"
        for task in TASKS
    ]


def cues(found: Result) -> list[str]:
    by = rows_by(found["visual_cues"], "task", "condition")
    rows = [[by[task, c] for c in ("none", "visual", "haptics", "visual+haptics")] for task in TASKS]
    return [
        f"| {task} | " + " | ".join(f"{r['path_error_mm']:.2f}, {r['peak_force_N']:.2f}" for r in row) + " |"
        for task, row in zip(TASKS, rows, strict=True)
    ]


def registration(found: Result) -> list[str]:
    control = rows_by(found["control"], "task")
    measures = {"path_error_mm": "path error", "entries": "entries"}
    assert found["control_works"]
    return [
        f"| {r['task']} | {measures[r['measure']]} | {r['break_even_mm']:.1f} mm | "
        f"{control[r['task']]['than_right_mm']:+.2f} mm |"
        for r in found["break_even"]
    ]


def haste(found: Result) -> list[str]:
    by = rows_by(found["ablation"], "task", "measure")

    def both(measure: str) -> str:
        rows = [(task, by[task, measure]) for task in ("tracing", "palpation")]
        return joined([f"{task} {percent(r['change'], '+')} / {percent(r['change_without_haste'], '+')} %"
                       for task, r in rows])  # fmt: skip

    return [f"reduces the {word} force with / without `haste`: {both(f'{word}_force_N')}" for word in ("mean", "peak")]


def yields(found: Result) -> list[str]:
    by = rows_by(found["yields"], "share", "task")
    names = {1.0: "full", 0.5: "half", 0.0: "none"}
    return [
        f"| {name} | " + " | ".join(f"{percent(-by[share, task]['change'])} %" for task in PATHS) + " |"
        for share, name in names.items()
    ]


def stiffness(found: Result) -> list[str]:
    by = rows_by(found["stiffness"], "stiffness_N_per_m", "task")
    every = dict.fromkeys(row["stiffness_N_per_m"] for row in found["stiffness"])
    cells = [joined([percent(-by[K, task]["change"]) for task in PATHS]) + " %" for K in every]
    return [f"| ring, tracing, insertion | {' | '.join(cells)} |", f"The first {found['operators']} operators"]


def care(found: Result) -> list[str]:
    def g(key: str) -> str:
        return joined([f"{round(row[key], 1) + 0.0:.1f}" for row in found["care"]])

    return [f"guidance is {g('hedges_g_without_care')} in place of {g('hedges_g')} ({found['operators']} operators)"]


SHAPES = ("sphere", "cylinder", "box", "tube", "mesh", "distance grid")


def hard_entry(found: Result) -> list[str]:
    by = rows_by(found["entry"]["hard_entry"], "region")

    def row(words: str, *names: str) -> str:
        mine = [by[name] for name in names]
        hands = joined([str(r["hands"]) for r in mine]) if len(names) < 3 else f"{mine[0]['hands']} each"
        low, high = (round(f(r["entry_without_mm"] for r in mine)) for f in (min, max))
        without = f"{low} mm" if low == high else f"{low} to {high} mm"
        return f"| {words} | {hands} | {max(r['entry_mm'] for r in mine):.3f} mm | {without} |"

    line = next(name for name in by if name.endswith("around a line"))
    deepest = max(row["entry_mm"] for row in by.values())
    assert found["entry"]["entry_passed"]
    everyone = sum(row["hands"] for row in by.values())
    return [
        row("floor", "floor"),
        row("floor that breathes by 3 mm", "floor that breathes"),
        row("planes of any tilt", "planes of any tilt"),
        row("6 mm around a line; the same, breathing", line, f"{line}, breathing"),
        row("in a sphere of 2 cm", next(name for name in by if name.startswith("inside of a sphere"))),
        row(joined(list(SHAPES)), *SHAPES),
        f"the forbidden region by at most {deepest:.3f} mm",
        f"at most {most(0, everyone)} enter deeper (0 of {everyone};",
    ]


def soft_entry(found: Result) -> list[str]:
    rows = found["entry"]["soft_entry"]
    (K,) = {row["certified_N_per_m"] for row in rows}
    return [
        f"certificate: {K:.1f} N/m from load cell over depth, a hand that goes to places | "
        + " | ".join(f"{row['certified_mm']:.2f} mm" for row in rows) + " |",
        "an arm with its dry friction | " + " | ".join(f"{row['measured_mm']:.2f} mm" for row in rows) + " |",
    ]  # fmt: skip


def conformance(found: Result) -> list[str]:
    judged = found["conformance"]
    whole = judged["combinations"] + judged["refused"]
    assert judged["passed"] == judged["combinations"]
    assert not judged["failures"]
    return [f"Of {whole} combinations, {judged['refused']} have no meaning"]


def rejected(found: Result) -> list[str]:
    by = rows_by(found["conformance"]["pairs"], "role", "geometry")

    def shares(role: str, *geometries: str) -> str:
        return joined([f"{percent(by[role, name]['rejected_share'])} %" for name in geometries])

    inward, forbid = "orient against the normal", "forbid, no margin"
    return [
        f"| {inward} x cloud | {shares(inward, 'cloud')} |",
        f"| forbid without margin x cloud | {shares(forbid, 'cloud')} |",
        f"| {inward} x mesh, box, offset | {shares(inward, 'mesh', 'box', 'offset')} |",
        f"| forbid without margin x box, mesh | {shares(forbid, 'box', 'mesh')} |",
    ]


def ten_seeds(found: Result) -> list[str]:
    judged = found["conformance"]
    assert judged["passed"] == judged["combinations"]
    n = len(judged["seeds"])
    return [
        f"# {judged['checks']:,} checks, about",
        f"Each of the {judged['checks']:,} checks finds a place and passes",
        f"For one combination {n} of {n} is at least {least(n, n)}",
    ]


def times(found: Result) -> list[str]:
    def row(words: str, key: str, digits: int = 1) -> str:
        return f"{words} | " + " | ".join(f"{found[f'{key}_{p}_us']:.{digits}f} us" for p in ("p50", "p99")) + " |"

    return [
        row("a hard fixture on a mesh of a million triangles", "hard_fixture_added"),
        row("a soft fixture on the same mesh", "fixture_added"),
        row("a hard keep-in on the middle line of a tube of a million triangles", "tube_hard_added"),
        row("the same at the centre of a ball", "ball_hard_added", 0),
        row("the program, 100 rows from scratch", "qp", 0),
        row("the same, all rows contradicting each other", "qp_contradictory", 0),
        f"visits each of them: {found['tube_query_p50_us']:.0f} us on the line",
    ]


TIES = [
    Tie("guidance-study.md", "guidance", (effects, entries, cues, registration, haste, yields)),
    Tie("guidance-study.md", "guidance_assumptions", (stiffness, care)),
    Tie("guidance-hard.md", "guidance_entry", (hard_entry, soft_entry)),
    Tie("guidance-hard.md", "guidance_times", (times,)),
    Tie("guidance-conformance.md", "conformance", (conformance, rejected)),
    Tie("guidance-conformance.md", "conformance_seeds", (ten_seeds,)),
]
