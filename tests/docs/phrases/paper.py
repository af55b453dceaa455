"""Phrases of the page that sets the paper beside Palpate."""

from __future__ import annotations

from collections import Counter

from phrases.values import Result, Tie

_WALL = ("eq12", "fig13", "table1")


def counts(found: Result) -> list[str]:
    verdicts = Counter(one["verdict"] for one in found["items"].values())
    assert verdicts["not made"] == 0
    assert tuple(name for name, one in found["items"].items() if one["verdict"] == "differs") == _WALL
    return [
        f"{verdicts['agrees']} of {len(found['items'])} items agree, {verdicts['differs']} differ, and "
        f"{verdicts['not testable without the robot']} is not testable"
    ]


def times(found: Result) -> list[str]:
    return [f"{found['wall_s']:.0f} s and {found['cpu_s']:.0f} s of processor time"]


def wall(found: Result) -> list[str]:
    over = found["items"]["fig13"]["value"]["overshoot_percent"]
    return ["{:.1f}, {:.2f} and {:.2f} %".format(*over)]


def together(found: Result) -> list[str]:
    value = found["items"]["table1"]["value"]
    best = value["best_hand_for_all_rows"]
    return [
        f"Of {value['tried']:,} combinations",
        f"velocity filter {value['give_all_three_within_20_percent'] or 'none'} gives all three overshoots within",
        f"the best is off by {100 * value['largest_relative_error']:.0f} % in its worst row",
        f"{best['mass_kg']:.2f} kg, {best['damping_N_s_per_m']:.2f} N s/m, {best['stiffness_N_per_m']:.0f} N/m, "
        f"a push of {best['push_N']:.2f} N, {1e3 * best['delay_s']:.0f} ms of delay, "
        f"{best['friction_scale']:.2f} times the friction of the model, "
        f"velocities filtered at {best['velocity_cutoff_Hz']:.0f} Hz",
    ]


def rows(found: Result) -> list[str]:
    lines = []
    for r in found["items"]["table1"]["value"]["rows"]:
        response = "never" if r["response_best_s"] is None else f"{r['response_best_s']:.2f}"
        rest = "+-" if r["oscillates_best"] else ""
        lines.append(
            f"| {r['kd']:g} | {r['overshoot_published']:g}, {r['overshoot_best_of_all_rows']:.2f} | "
            f"{r['response_published_s']:g}, {response} | "
            f"{r['steady_state_read_mm']:.1f}, {rest}{r['steady_state_best_mm']:.1f} |"
        )
    return lines


def others(found: Result) -> list[str]:
    value = {name: one["value"] for name, one in found["items"].items()}
    at = value["fig9"]["normal_error_deg_at_depth_mm"]
    noise = value["eq18"]["error_deg_at_noise_um"]
    approach = value["approach"]["normal_error_deg_at_0_and_45_deg"]
    return [
        f"{at['1']:.0f}° after 1 mm",
        "{:.0f}, {:.0f} and {:.0f}°".format(noise["1"], noise["10"], noise["100"]),
        f"off by {approach['paper-alg1'][0]:.1f}° at any angle",
    ]


TIES = [Tie("paper.md", "paper", (counts, times, wall, together, rows, others))]
