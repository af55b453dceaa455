"""`palpate fuzz`."""

from __future__ import annotations

from pathlib import Path

from palpate.cli.output import console_for, require_writable, say, write_json
from palpate.verify.fuzz import Outcome, run


def fuzz(target: str, runs: int, seed: int, json: Path | None) -> int:
    """Run the cases, tell every fault with its seed. Returns 1 when there was one."""
    console = console_for(json)
    require_writable(json)
    every = max(runs // 10, 1)

    def progress(outcome: Outcome) -> None:
        if outcome.runs % every == 0:
            say(console, f"{outcome.runs:,} of {runs:,} cases, {len(outcome.faults)} faults")

    outcome = run(target, runs, seed, progress)
    for fault in outcome.faults:
        say(console, f"seed {fault['seed']}: {fault['what']}", "fault:", "red")
    made = ", ".join(f"{name} {n:,}" for name, n in sorted(outcome.counts.items()))
    say(console, f"{outcome.runs:,} cases in {outcome.seconds:.0f} s: {len(outcome.faults)} faults ({made})")
    write_json(json, outcome.to_json())
    return 1 if outcome.faults else 0
