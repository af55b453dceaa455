"""Phrases of the page on remote sites."""

from __future__ import annotations

from phrases.values import Result, Tie


def conditions(found: Result) -> list[str]:
    """The networks by name, with a plane that lies lower and is stiffer than the scene says."""
    model, passivity, direct = (
        [row for row in found["conditions"] if row["mode"] == mode and row["condition"] != "none"]
        for mode in ("model", "passivity", "direct")
    )
    felt = [row["felt_over_true"] for row in model]
    away = [-row["energy_mJ"] for row in direct]
    assert f"{min(felt):.2f}" == f"{max(felt):.2f}"
    assert min(row["energy_mJ"] for row in model) > -0.005
    return [
        f"`model` feels {max(felt):.2f} of the true force within {max(row['force_rms_N'] for row in model):.3f} N rms, "
        f"gives no energy away, and presses the tissue by at most {max(row['force_site_N'] for row in model):.1f} N",
        f"`direct` gives {min(away):.0f} to {max(away):.0f} mJ away",
        f"`passivity` feels at most {max(row['felt_over_true'] for row in passivity):.2f} of the force",
    ]


def random(found: Result) -> list[str]:
    model, passivity = (next(row for row in found["random"] if row["mode"] == mode) for mode in ("model", "passivity"))
    n = model["runs"]
    felt, rms = (100 * (1 - model[key] / n) for key in ("felt_outside", "rms_outside"))
    return [
        f"Of {n:,} random networks",
        f"| {model['energy_lowest_mJ']:.2f} mJ; {model['not_passive'] or 'no'} runs below -0.5 |",
        f"| in {felt:.0f} % of the runs, {model['felt_over_true'][1]:.3f} in the median; 99 % of the runs within "
        f"{model['felt_over_true'][0]:.2f}-{model['felt_over_true'][2]:.2f} |",
        f"| in {rms:.0f} % of the runs, {model['force_rms_N'][1]:.3f} in the median, "
        f"99.5 % below {model['force_rms_N'][2]:.2f}",
        f"| {model['force_site_largest_N']:.2f} N, {model['drift_largest_mm']:.2f} mm |",
        f"a port falls to {passivity['energy_lowest_mJ']:.2f} mJ and both together to "
        f"{passivity['energy_ports_lowest_mJ']:.1f} mJ: {passivity['not_passive']} of the {n:,} runs",
    ]


def moving(found: Result) -> list[str]:
    breathing, pushed = (
        sorted((row for row in found["moving"] if row["case"] == case), key=lambda row: row["round_trip_ms"])
        for case in ("breathing", "pushed")
    )
    return [
        f"| 0.35 N rms | {max(row['force_rms_N'] for row in breathing):.3f} |",
        f"| {pushed[0]['relearnt_s']:.2f} s at 20 ms, {pushed[-1]['relearnt_s']:.2f} s at 500 ms; kick "
        f"{max(row['kick_N'] for row in pushed):.3f} N |",
    ]


def outages(found: Result) -> list[str]:
    told = [row["outage_told_ms"] for row in found["conditions"] if row["mode"] == "model"]
    return [f"| {max(one for one in told if one is not None):.0f} ms |"]


TIES = [Tie("network.md", "network", (conditions, random, moving, outages))]
