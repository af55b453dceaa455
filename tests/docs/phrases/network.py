"""Phrases of the page on figures of remote sites."""

from __future__ import annotations

from phrases.values import Result, Tie, both, most


def _of(found: Result, mode: str) -> list[Result]:
    return [row for row in found["conditions"] if row["mode"] == mode]


def conditions(found: Result) -> list[str]:
    """A row of the table for each network, with a plane that lies lower and is stiffer than the scene says."""
    rows = []
    for row in _of(found, "model"):
        energy = f"{abs(min(row['energy_mJ'], 0.0)):.2f}"
        rows.append(
            f"| `{row['condition']}` | {'-' if float(energy) else ''}{energy} | {row['felt_over_true']:.3f} | "
            f"{row['force_rms_N']:.3f} | {row['force_site_N']:.2f} | {row['palpation_s']:.1f} | "
            f"{100 * row['palpation_longer']:.0f} % |"
        )
    return rows


def modes(found: Result) -> list[str]:
    """What the other modes do on networks with a delay."""
    passivity, direct = (
        [row for row in _of(found, one) if row["condition"] != "none"] for one in ("passivity", "direct")
    )
    away = [-row["energy_mJ"] for row in direct]
    longer = [row["palpation_longer"] for row in passivity if row["palpation_longer"] is not None]
    ended = sum(row["palpation_s"] is not None for row in direct)
    return [
        f"`direct` gives {min(away):.0f} to {max(away):.0f} mJ away and ends {ended or 'none'} of these palpations "
        "within a minute",
        f"`passivity` feels at most {max(row['felt_over_true'] for row in passivity):.2f} of the force and takes "
        f"{100 * min(longer):.0f} to {100 * max(longer):.0f} % longer, if it ends at all",
    ]


def random(found: Result) -> list[str]:
    model = next(row for row in found["random"] if row["mode"] == "model")
    n = model["runs"]
    felt, rms = (n - model[key] for key in ("felt_outside", "rms_outside"))
    return [
        f"Of {n:,} random networks",
        f"| {model['energy_lowest_mJ']:.2f} mJ; {model['not_passive'] or 'no'} runs below -0.5 "
        f"(at most {most(model['not_passive'], n, 2)}) |",
        f"| in {felt} of the runs ({both(felt, n)}), {model['felt_over_true'][1]:.3f} in the median; "
        f"99 % of the runs within {model['felt_over_true'][0]:.2f}-{model['felt_over_true'][2]:.2f} |",
        f"| in {rms} of the runs ({both(rms, n)}), {model['force_rms_N'][1]:.3f} in the median, "
        f"99.5 % below {model['force_rms_N'][2]:.2f}",
        f"| {model['force_site_largest_N']:.2f} N |",
        f"| {model['kick_largest_N']:.3f} N |",
        f"| {model['drift_largest_mm']:.4f} mm |",
    ]


def unknown(found: Result) -> list[str]:
    """Worlds that the scene does not have, felt as planes."""
    row = next(row for row in found["random"] if row["mode"] == "unknown")
    n = row["runs"]
    felt, rms = (n - row[key] for key in ("felt_outside", "rms_outside"))
    return [
        f"| {row['energy_lowest_mJ']:.2f} mJ; {row['not_passive'] or 'none'} of {n} runs below -0.5 "
        f"(at most {most(row['not_passive'], n)}) |",
        f"| in {felt} runs ({both(felt, n)}), {row['felt_over_true'][1]:.3f} in the median; "
        f"99 % of the runs within {row['felt_over_true'][0]:.2f}-{row['felt_over_true'][2]:.2f} |",
        f"| in {rms} runs ({both(rms, n)}), {row['force_rms_N'][1]:.3f} in the median, "
        f"99.5 % below {row['force_rms_N'][2]:.2f} |",
        f"| at most {row['kick_largest_N']:.3f} N |",
        f"| at most {row['force_site_largest_N']:.2f} N |",
    ]


def passivity(found: Result) -> list[str]:
    row = next(row for row in found["random"] if row["mode"] == "passivity")
    return [
        f"a port falls to {row['energy_lowest_mJ']:.2f} mJ and both together to "
        f"{row['energy_ports_lowest_mJ']:.1f} mJ: {row['not_passive']} of the {row['runs']:,} runs "
        f"({both(row['not_passive'], row['runs'])})"
    ]


def moving(found: Result) -> list[str]:
    breathing, pushed = (
        sorted((row for row in found["moving"] if row["case"] == case), key=lambda row: row["round_trip_ms"])
        for case in ("breathing", "pushed")
    )
    half = next(row for row in pushed if row["round_trip_ms"] == 500.0)
    return [
        f"| 0.35 N rms | {max(row['force_rms_N'] for row in breathing):.3f} |",
        f"| {pushed[0]['relearnt_s']:.2f} s at 20 ms, {half['relearnt_s']:.2f} s at 500 ms, "
        f"{pushed[-1]['relearnt_s']:.2f} s at 700 ms |",
        f"| 0.1 N a tick | {max(row['kick_N'] for row in pushed):.3f} |",
        f"energy of {min(row['energy_mJ'] for row in breathing):.2f} mJ at 700 ms",
    ]


def outages(found: Result) -> list[str]:
    told = [row["outage_told_ms"] for row in _of(found, "model")]
    worst = max(found["alarms"], key=lambda row: row["false_alarms_per_hour"])
    late = [row for row in found["alarms"] if row["told_ms"] > 50.5]
    words = ", ".join(
        f"{row['told_ms']:.0f} ms on `{row['condition']}` ({row['possible_ms']:.0f} possible)" for row in late
    )
    return [
        f"told {max(one for one in told if one is not None):.0f} ms after",
        f"at most {worst['false_alarms_per_hour']:.1f} false alarms an hour",
        words,
    ]


TIES = [
    Tie("network-figures.md", "network", (conditions, modes, passivity, moving, outages)),
    Tie("network-figures.md", "network_runs", (random,)),
    Tie("network-figures.md", "network_unknown", (unknown,)),
]
