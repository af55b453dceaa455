"""Phrases of the page on soft bodies."""

from __future__ import annotations

from palpate.base.arrays.intervals import proportion
from palpate_lab.verify.bench.tissue.ticks import CONTROL_MS
from phrases.values import Result, Tie, control, least, most


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
    m = found["mujoco"]
    return [f"errs by {100 * m['layer_error']:+.1f} %, Palpate by {100 * m['own_layer_error']:+.1f} %"]


def tissue_finding(found: Result) -> list[str]:
    """What the operators prove: the lump that reaches the surface, and the control."""
    rows = found["finding"]
    n = len(rows)
    k, shallow, wrong = (sum(row[key] for row in rows) for key in ("found", "shallow_found", "control_found"))
    assert proportion(k / n, n)[0] < 0.75 <= proportion(shallow / n, n)[0]
    assert proportion(wrong / n, n)[1] < 0.25
    return [
        f"{k} of {n} is at least {least(k, n)}, {shallow} of {n} at least {least(shallow, n)}, "
        f"{wrong} of {n} at most {most(wrong, n)}",
    ]


def soak_limits(found: Result) -> list[str]:
    n = found["actions"]
    return [f"0 of {n:,} is at most {most(0, n)} of the actions"]


def tissue_loops(found: Result) -> list[str]:
    cycle, thread = found["real_time"]
    return [control("tissue_loops")] + [
        f"{loop['tets']:,} tetrahedra {where} missed {loop['missed']} of {loop['ticks']:,} ticks, a bare loop in turns "
        f"with it {loop['control_missed']}"
        for loop, where in ((cycle, "in the cycle"), (thread, "on a thread of 4 ms"))
    ]


def tissue_mujoco(found: Result) -> list[str]:
    return [f"MuJoCo takes {found['mujoco']['tick_ms']['p50']:.1f} ms a step"]


def tissue_controls(found: Result) -> list[str]:
    """The control beside the ticks, and the two limits scaled by the control beside each."""
    cycle, thread = (row["value"] for row in found["rows"])
    return [
        f"sorting 20,000 numbers, takes {found['control_ms']['p50']:.2f} ms here, and {CONTROL_MS:.2f} ms on the idle",
        f"by the control beside each, they are {cycle:.2f} and {thread:.2f} ms: the second is missed",
    ]


def theories(found: Result) -> list[str]:
    rows = {(r["poisson"], r["thickness_radii"], r["theory"]): [100 * one for one in r["error"]]
            for r in found["theories"]}  # fmt: skip
    names = {None: "half-space", 2.0: "2 R", 1.0: "R"}

    def line(nu: str, h: float | None, theory: str, cells: list[str]) -> str:
        return f"| {nu} | {names[h]} | {theory} | {' | '.join(f'{cell} %' for cell in cells)} |"

    soft, hard = (rows[nu, None, "Sneddon"] for nu in (0.40, 0.49))
    both = [f"{one:+.1f} / {other:+.1f}" for one, other in zip(soft, hard, strict=True)]
    thin = [[-100 * error for error in row["error"]] for row in found["polynomial"]]
    shares = [f"{min(row):.0f} to {max(row):.0f} %" for row in thin]
    return [
        *(line(f"{nu:.2f}".removeprefix("0"), h, theory, [f"{error:+.1f}" for error in errors])
          for (nu, h, theory), errors in rows.items() if (nu, h) not in ((0.40, None), (0.49, None))),
        line(".40 / .49", None, "Sneddon", both),
        f"it lies {shares[0]} below the exact force at sqrt(R d)/h = .5, and {shares[1]} below at 1",
    ]  # fmt: skip


def thread_rows(found: Result) -> list[str]:
    assert {row["period"] for row in found["threads"]} == {0.01}
    return [
        f"| {1e-3 * r['young']:.0f} kPa | {100 * r['rms']:.2f} % | {100 * r['peak']:.1f} % | {1e3 * r['taken']:g} mJ |"
        for r in found["threads"]
    ]


def soak(found: Result) -> list[str]:
    counts = [body["counts"] for body in found["bodies"]]
    never = ("not_finite", "popped", "guarded", "guarded_hard", "inverted_at_rest")
    assert not any(c[key] for c in counts for key in never)
    moved, rests, restless, held = (
        sum(c[key] for c in counts) for key in ("moved_at_rest", "rests", "restless", "held")
    )
    return [
        f"All {found['actions']:,} actions of seed {found['seed']} on {len(counts)} bodies",
        f"In {moved} of {rests:,} checks at rest",
        f"In {restless} of {held} held pokes",
    ]


TIES = [
    Tie("grasping.md", "soak_tissue", (soak, soak_limits)),
    Tie("soft-thread.md", "tissue", (thread_rows,)),
    Tie("tissue-figures.md", "tissue", (tissue_rows, tissue_text)),
    Tie("tissue-figures.md", "tissue_finding", (tissue_rows, tissue_finding)),
    Tie("tissue-figures.md", "tissue_times", (tissue_ticks, tissue_mujoco, tissue_controls)),
    Tie("tissue-figures.md", "tissue_loops", (tissue_loops,)),
    Tie("tissue-theories.md", "theories", (theories,)),
]
