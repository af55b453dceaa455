"""Phrases of the pages on certificates, oscillations and passivity."""

from __future__ import annotations

from phrases.values import Result, Tie, both, least, mj, most, percent


def certificate_devices(found: Result) -> list[str]:
    share = "all" if found["share_within"] == 1.0 else f"{100 * found['share_within']:.1f} %"
    broken = found["certified_broken"] or "none"
    return [
        f"{found['count']} random devices (`--devices {found['count']}`) | median {100 * found['median_error']:.2f} %, "
        f"largest {100 * found['largest_error']:.1f} %, {share} within 5 %; "
        f"the linear part alone: median {100 * found['linear_median_error']:.1f} %",
        f"of {found['certified_gains']} certified pairs {broken} oscillates",
    ]


def certificate_limits(found: Result) -> list[str]:
    """What the counts prove; the certified pairs of one device are not independent of each other."""
    n, arms = found["count"], len(found["arms"])
    assert found["share_within"] == 1.0
    assert found["certified_broken"] == 0
    return [
        f"{n} of {n} devices is at least {least(n, n)}, none of {n} that oscillates at most {most(0, n)}, "
        f"{arms} of {arms} at least {least(arms, arms)}"
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


def passivity_answer(found: Result) -> list[str]:
    """The page's first sentences: the modes of the layer that a scene offers, and the mode without it."""
    by = {row["mode"]: row for row in found["modes"]}
    lowest = min(row["lowest_port_J"] for mode, row in by.items() if mode != "off")
    oscillating = max(by[mode]["oscillates"] for mode in by if mode != "off")
    assert not any(by[mode]["diverged"] or by[mode]["below_bound"] for mode in by if mode != "off")
    (all_runs,) = (row for row in found["changes"] if row["runs"] == found["runs"])
    return [
        f"In {found['runs']:,} simulated runs none falls below the bound of -1 mJ, and {oscillating} keep oscillating. "
        f"In these runs with the layer the lowest energy is {mj(lowest)} mJ, without it "
        f"{mj(by['off']['lowest_port_J'])} mJ",
        f"Of the wall alone, {by['alone']['rendered_below_bound']} runs miss the bound",
        f"changes the force of {percent(all_runs['changed'] / all_runs['runs'])} % of the runs "
        f"({both(all_runs['changed'], all_runs['runs'])}) by 1 % or more",
    ]


def passivity_limits(found: Result) -> list[str]:
    return [f"0 of {found['runs']:,} is at most {most(0, found['runs'], 2)} of such runs"]


def passivity_guarantee(found: Result) -> list[str]:
    assert not any(row["below_bound"] for row in found["modes"] if row["mode"] in ("observer", "tank"))
    return [f"in all of {found['runs']:,} simulated runs (so in at most {most(0, found['runs'], 2)} not"]


def passivity_changes(found: Result) -> list[str]:
    rows = {row["of"]: row for row in found["changes"]}
    every = [f"{row['runs']:,}" if row["runs"] >= 10_000 else str(row["runs"]) for row in rows.values()]
    assert rows["silent"]["changed"] == 0
    return [f"| {runs} | {row['changed']} ({both(row['changed'], row['runs'])}) |"
            for runs, row in zip(every, rows.values(), strict=True) if row["of"] != "silent"]  # fmt: skip


def passivity_delays(found: Result) -> list[str]:
    rows = found["by_delay"]
    shares = [row["changed"] / row["runs"] for row in rows]
    assert shares == sorted(shares)
    return [f"{percent(shares[0])} % below 1 ms, {percent(shares[1])} % from there to 5 ms, "
            f"{percent(shares[-1])} % from 20 to 50 ms"]  # fmt: skip


def extracted(found: Result) -> list[str]:
    return [
        f"{found['motions']} random motions per case",
        *(f"| {row['case']} | {1e3 * row['extracted_J']:.2f} mJ | {1e3 * row['without_J']:.0f} mJ |"
          for row in found["extract"]),
    ]  # fmt: skip


def swings(found: Result) -> list[str]:
    n, sure = (sum(found["runs"][0][key] for key in keys) for keys in
               (("growing", "decaying"), ("growing_called", "decaying")))  # fmt: skip
    assert found["runs"][0]["decaying_called"] == found["runs"][0]["decaying_undecided"] == 0
    names = {"needed": "as long as the judge needs", "short": "2 s, whatever the mode"}
    return [
        f"For {found['loops']} random ones",
        f"{sure} of {n} is an agreement of at least {least(sure, n)}",
        *(f"| {names[r['run']]} | {r['growing_called']}, {r['growing'] - r['growing_called']} "
          f"({r['growing_undecided']}) | {r['decaying_called']}, {r['decaying'] - r['decaying_called']} "
          f"({r['decaying_undecided']}) | {100 * r['agreement']:.1f} % |" for r in found["runs"]),
    ]  # fmt: skip


def loops(found: Result) -> list[str]:
    """The campaign of random loops: its size, and the kinds that fail."""
    counts = found["counts"]
    failed = {kind.removesuffix(": failed"): n for kind, n in counts.items() if kind.endswith(": failed")}
    size = f"In {found['runs']:,} scenes {counts['loops']:,} loops were run"
    return [
        size,
        f"{sum(failed.values()):,} failed",
        *(f"| `{k}` | {n} of {counts[k]:,} | {both(n, counts[k])} |" for k, n in failed.items()),
    ]


TIES = [
    Tie("stability-passivity.md", "passivity", (passivity_guarantee,)),
    Tie("oscillation.md", "swings", (swings,)),
    Tie("verification.md", "loops", (loops,)),
    Tie("stability-study.md", "extract", (extracted,)),
    Tie("certificate.md", "certificate", (certificate_devices, certificate_arms, certificate_limits)),
    Tie("stability-study.md", "passivity", (passivity_rows, passivity_text, passivity_changes, passivity_delays)),
    Tie("stability-study.md", "passivity", (passivity_answer, passivity_limits)),
]
