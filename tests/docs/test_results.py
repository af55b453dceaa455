"""Figures on the pages are those of the results kept in docs/results (written by tools/results.py).

PHRASES is the one place that ties them: each entry computes a phrase from a result, and the page must contain it.
"""

import json
import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
Result = dict[str, Any]


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


SCENES = ("liver, gallbladder, duodenum", "closed cage with one window of 12 mm", "two instruments crossing")


def planning_rows(found: Result) -> list[str]:
    rows = found["rows"]
    ways = [(r["straight"], r["retracted"], r["queries"] - r["straight"] - r["retracted"]) for r in rows]
    return [
        f"| {name} | {100 * r['success_rate']:.0f} % | {r['median_s']:.2f} and {r['p95_s']:.2f} s | "
        f"{way[0]}, {way[1]}, {way[2]} | {r['violations']} of {r['checked_samples']:,} |"
        for name, r, way in zip(SCENES, rows, ways, strict=True)
    ]


def planning_again(found: Result) -> list[str]:
    return [
        f"| {name} | {1e3 * r['replan_wall_p50_s']:.0f} and {1e3 * r['replan_wall_p95_s']:.0f} ms | "
        f"{round(r['replan_success_rate'] * r['replans'])} of {r['replans']} |"
        for name, r in zip(SCENES, found["rows"], strict=True)
    ]


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


def execution_load(found: Result) -> list[str]:
    return [f"under a load of {max(row['load'] for row in found['rows']):.0f}"]


def tissue_ticks(found: Result) -> list[str]:
    return [f"| {int(n):,} | {t['p50']:.2f} / {t['p99']:.2f} ms |" for n, t in found["tick_ms"].items()]


def tissue_rows(found: Result) -> list[str]:
    return [
        f"| {r['name']} | {r['value']:.3g} {r['unit']} | {'>=' if r['least'] else '<='} {r['asked']:g} {r['unit']} | "
        f"{'yes' if r['met'] else '**no**'} |"
        for r in found["rows"]
        if r["unit"] != "ms"  # times are those of the idle machine
    ]


def tissue_text(found: Result) -> list[str]:
    m, (cycle, thread) = found["mujoco"], found["real_time"]
    errors = f"errs by {100 * m['layer_error']:+.1f} %, Palpate by {100 * m['own_layer_error']:+.1f} %"
    return [errors] + [
        f"{loop['tets']:,} tetrahedra {where} missed {loop['missed']} of {loop['ticks']:,} ticks, a bare loop in turns "
        f"with it {loop['control_missed']}"
        for loop, where in ((cycle, "in the cycle"), (thread, "on a thread of 4 ms"))
    ]


def tissue_mujoco(found: Result) -> list[str]:
    return [f"MuJoCo takes {found['mujoco']['tick_ms']['p50']:.1f} ms a step"]


def certificate_devices(found: Result) -> list[str]:
    share = "all" if found["share_within"] == 1.0 else f"{100 * found['share_within']:.1f} %"
    broken = found["certified_broken"] or "none"
    return [
        f"{found['count']} random devices (`--devices {found['count']}`) | median {100 * found['median_error']:.2f} %, "
        f"largest {100 * found['largest_error']:.1f} %, {share} within 5 %; "
        f"the linear part alone: median {100 * found['linear_median_error']:.1f} %",
        f"of {found['certified_gains']} certified pairs {broken} oscillates",
    ]


def certificate_arms(found: Result) -> list[str]:
    largest = {scene: max(abs(row["error"]) for row in found["arms"] if row["scene"] == scene)
               for scene in ("palpation", "paper")}  # fmt: skip
    assert not any(row["certified_broken"] for row in found["arms"])
    return [
        f"3 directions, 0 and 6 ms, two dampings | largest {100 * largest['palpation']:.1f} %",
        f"mode `paper` at 500 Hz | largest {100 * largest['paper']:.1f} %",
        f"at 97 % of the limit | all of {len(found['arms'])} come to rest",
    ]


def mj(joules: float) -> str:
    return f"{float(f'{1e3 * joules:.3g}'):,.{max(0, 2 - int(math.log10(abs(1e3 * joules)) // 1))}f}"


def passivity_rows(found: Result) -> list[str]:
    def bold(text: str, is_bold: bool) -> str:
        return f"**{text}**" if is_bold else text

    return [
        f"| {row['mode']} | {bold(mj(row['lowest_port_J']) + ' mJ', row['mode'] in ('observer', 'tank'))} | "
        f"{bold(str(row['below_bound']), row['mode'] in ('observer', 'tank'))} | "
        f"{bold(mj(row['lowest_rendered_J']) + ' mJ', row['mode'] == 'alone')} | "
        f"{bold(str(row['rendered_below_bound']), row['mode'] == 'alone')} | {row['diverged']} | {row['oscillates']} |"
        for row in found["modes"]
    ]


def passivity_text(found: Result) -> list[str]:
    (off,) = (row for row in found["modes"] if row["mode"] == "off")
    return [
        f"Without the layer {off['oscillates']} runs keep oscillating. "
        f"{off['oscillates_certified']} of them are certified with their hand"
    ]


def passivity_changes(found: Result) -> list[str]:
    rows = {row["of"]: row for row in found["changes"]}
    every = [f"{row['runs']:,}" if row["runs"] >= 10_000 else str(row["runs"]) for row in rows.values()]
    assert rows["silent"]["changed"] == 0
    return [f"| {runs} | {row['changed']} ({100 * row['changed'] / row['runs']:.0f} %) |"
            for runs, row in zip(every, rows.values(), strict=True) if row["of"] != "silent"]  # fmt: skip


def of(rows: list[Result], key: str) -> str:
    return f"{sum(round(row[key] * row['trials']) for row in rows)} of {sum(row['trials'] for row in rows)}"


def registration_markers(found: Result) -> list[str]:
    both, (estimated, stated) = found["predicted"].values(), found["wrong_marker"].values()
    return [
        "isotropic; anisotropic | " + "; ".join(f"{1e3 * one['largest_p95_m']:.3f} mm" for one in both),
        "isotropic; anisotropic | " + "; ".join(f"{100 * one['largest_error']:.1f} %" for one in both),
        f"unknown correspondence found | {of(list(found['unknown'].values()), 'right')}",
        f"FLE estimated; stated | {of([estimated], 'found')}; {of([stated], 'found')}",
        f"false alarms, FLE estimated; stated | {100 * estimated['false_alarms']:.1f} %; "
        f"{100 * stated['false_alarms']:.1f} %",
    ]


def registration_surfaces(found: Result) -> list[str]:
    rough, none, arm, beside = *(found["surface"][k] for k in ("rough", "none")), *found["handeye"].values()
    wrong = sum(one["wrong"] for one in found["surface"].values())
    assert found["wrong_told"] == 1.0
    return [
        f"from +-30 deg and +-30 mm | {of([rough], 'converged')}",
        f"rms error of its points, 95 % | {1e3 * rough['p95_m']:.2f} mm",
        f"without a start | {of([none], 'converged')}",
        f"other organ) | {wrong} of {wrong}",
        f"on the arm | {1e3 * arm['position_p95_m']:.2f} mm, {math.degrees(arm['rotation_p95_rad']):.2f} deg",
        f"beside the arm | {1e3 * beside['position_p95_m']:.2f} mm, {math.degrees(beside['rotation_p95_rad']):.2f} deg",
    ]


def registration_chain(found: Result) -> list[str]:
    touched, chain = found["touched"], found["chain"]
    return [
        f"{touched['trials']} runs | {1e3 * touched['simulated_m']:.2f} mm rms, "
        f"predicted {1e3 * touched['predicted_m']:.2f} mm",
        f"median; largest | {1e3 * chain['tip_median_m']:.2f} mm; {1e3 * chain['tip_largest_m']:.1f} mm",
        f"within 1 mm of the surface | {100 * chain['felt_within_1mm']:.1f} % of {20 * chain['trials']} places",
    ]


def organ_ridges(found: Result) -> list[str]:
    rows = {(row["mesh"], row["depth_mm"]): row for row in found["rows"]}
    out = []
    for R, depth in ((0, 1.0), (1, 1.0), (1, 2.0), (2, 1.0), (2, 2.0)):
        fine, coarse = (rows[f"ridge {R} mm, facets {edge} mm", depth] for edge in (0.3, 2.6))
        out.append(
            f"| {depth:g} mm | {fine['true_step_deg']:.1f} deg | {fine['step_deg']:.1f} deg | "
            f"{coarse['step_deg']:.1f} deg | {coarse['limited_step_deg']:.1f} deg |"
        )
    return out


def organ_slides(found: Result) -> list[str]:
    rows = [row for row in found["rows"] if row["true_step_deg"] is None and row["noise_mm"] == 0.0]
    cells = {
        (row["mesh"], row["depth_mm"]): f"{row['step_deg']:.1f} deg | {row['limited_step_deg']:.1f} deg | "
        f"{100 * row['large_share']:.2f} %" for row in rows
    }  # fmt: skip
    return [f"| {mesh} | {cells[mesh, 1.0]} | {cells[mesh, 2.0]} |" for mesh in dict.fromkeys(r["mesh"] for r in rows)]


def organ_noise(found: Result) -> list[str]:
    raw, smooth = (r for r in found["rows"] if r["mesh"] == "gallbladder_visual" and r["depth_mm"] == 1.0)
    return [
        f"noise of {smooth['noise_mm']:.2f} mm, from {raw['step_deg']:.1f} to {smooth['step_deg']:.1f} degrees",
    ]


PHRASES: dict[str, tuple[str, list[Callable[[Result], list[str]]]]] = {
    "wall": ("wall.md", [wall_rows, wall_misses, wall_text, wall_hands]),
    "certificate": ("certificate.md", [certificate_devices, certificate_arms]),
    "passivity": ("stability-study.md", [passivity_rows, passivity_text, passivity_changes]),
    "registration": ("registration.md", [registration_markers, registration_surfaces, registration_chain]),
    "organs": ("contact-organs.md", [organ_ridges, organ_slides, organ_noise]),
    "planning": ("planning.md", [planning_rows, planning_again]),
    "execution": ("planning-execution.md", [execution_rows]),
    "execution_ros": ("planning-execution.md", [execution_rows, execution_load]),
    "tissue": ("tissue-figures.md", [tissue_rows, tissue_text]),
    "tissue_times": ("tissue-figures.md", [tissue_ticks, tissue_mujoco]),
}
"""By result: its page, and what computes phrases of it. A phrase with `\\|.*\\|` leaves columns of other runs out."""


def missing(page: str, phrases: list[str]) -> list[str]:
    """The phrases that are not on the page; line breaks count as spaces."""
    text = " ".join(page.split())
    parts = {phrase: re.escape(phrase).replace(re.escape(r"\|.*\|"), r"\|[^|]*\|[^|]*\|") for phrase in phrases}
    return [phrase for phrase, pattern in parts.items() if not re.search(pattern, text)]


def kept(name: str) -> Result:
    return json.loads((DOCS / "results" / f"{name}.json").read_text(encoding="utf-8"))


KEPT = {path.stem for path in (DOCS / "results").glob("*.json")}


@pytest.mark.parametrize("name", PHRASES)
def test_the_result_of_a_page_is_kept(name):
    if name not in KEPT:
        pytest.skip(f"run: python tools/results.py {name}")


@pytest.mark.parametrize(
    ("name", "phrases"), [(k, one) for k, (_, all_) in PHRASES.items() if k in KEPT for one in all_]
)
def test_pages_have_the_figures_of_the_kept_results(name, phrases):
    page = (DOCS / PHRASES[name][0]).read_text(encoding="utf-8")
    assert missing(page, phrases(kept(name)["result"])) == []


@pytest.mark.parametrize("name", [name for name in PHRASES if name in KEPT])
def test_a_figure_that_differs_is_found(name):
    """The page has no phrase whose last digit is changed."""
    page, makers = PHRASES[name]
    result = kept(name)["result"]
    text = (DOCS / page).read_text(encoding="utf-8")
    for maker in makers:
        for phrase in maker(result):
            other = re.sub(r"none|(\d)(?=\D*$)", lambda m: str((int(m[1] or 4) + 1) % 10), phrase)
            assert missing(text, [other]) == [other], phrase


@pytest.mark.parametrize("path", sorted((DOCS / "results").glob("*.json")), ids=lambda path: path.stem)
def test_a_result_says_how_to_repeat_it(path):
    found = json.loads(path.read_text(encoding="utf-8"))
    assert found["command"].startswith("palpate ")
    assert re.fullmatch(r"[0-9a-f]{12}\+?", found["commit"])
    assert found["control_numpy_import_s"] > 0.0
    assert isinstance(found["seed"], int)
    assert path.stem in PHRASES, "no page is compared with it"
