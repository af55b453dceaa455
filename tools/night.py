"""Runs the long judges, which no test can wait for: `make night`, or for a part of it `make night ARGS="--hours 8"`.

Each judge is a command of its own and is run in slices of minutes. The next slice is of the judge that is farthest from
its end, so that a short night has a part of all. A journal holds each finished slice: after Ctrl-C, or on another
night, the same command continues. docs/results/night.json and the printed table tell what ran, what it found, and
what did not run yet. The soak on ROS 2 judges real time, and wants an otherwise idle machine.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))
from results import commit  # noqa: E402

JOURNAL = ROOT / "runs" / "night" / "journal.jsonl"
RESULT = ROOT / "docs" / "results" / "night.json"
PALPATE = (sys.executable, "-m", "palpate")
LAST = ("nice", "-n", "19")
KILLED = 0.85  # least share of the planted faults that the tests of a group shall find
SHOWN = 20  # faults of a judge that are kept in the result


@dataclass
class Slice:
    """A finished slice."""

    judge: str
    done: float
    """Amount in the judge's unit."""
    faults: list[str] = field(default_factory=list)
    count: dict[str, float] = field(default_factory=dict)
    """Further sums, such as the number of planted faults that were found."""
    seconds: float = 0.0
    commit: str = ""
    load: float = 0.0
    """Load of the machine at the end."""


Reader = Callable[[Any, float], Slice]
"""Turns the JSON of a command and the amount asked of it into a slice without its name."""


@dataclass(frozen=True)
class Judge:
    """A command that is run in slices."""

    name: str
    asked: float
    unit: str
    step: float
    """Amount of a slice."""
    command: Callable[[float, float, Path], list[str]]
    """Its words: amount before the slice, amount of the slice, file for the JSON."""
    read: Reader

    def verdict(self, slices: Sequence[Slice]) -> tuple[bool, str]:
        """Whether its slices so far fail, and what they say."""
        faults = sum(len(one.faults) for one in slices)
        tried, killed = (sum(one.count.get(key, 0.0) for one in slices) for key in ("tried", "killed"))
        if not slices:
            return False, "not run"
        if tried:  # planted faults: those not found are counted
            return killed < KILLED * tried, f"{killed / tried:.0%} of the planted faults found ({KILLED:.0%} asked)"
        return faults > 0, f"{faults or 'no'} fault{'s' if faults > 1 else ''}"


def _fuzzed(found: Any, _: float) -> Slice:
    return Slice("", found["runs"], [f"seed {one['seed']}: {one['what']}" for one in found["faults"]])


def _guided(found: Any, step: float) -> Slice:
    return Slice("", step, found["faults"], {"cases": found["cases"]})


def _soaked(found: Any, step: float) -> Slice:
    return Slice("", min(step, found["hours"]), list(found["wrong"]))


def _conform(found: Any, step: float) -> Slice:
    judged = found["conformance"]
    faults = [json.dumps(one) for one in judged["failures"]] + judged["unjudged"]
    faults += [] if judged["entry_passed"] else ["penetration of fixtures"]
    return Slice("", step, faults, {"checks": judged["checks"]})


def _mutated(found: Any, _: float) -> Slice:
    tried, survived = found["tried"], found["survived"]
    return Slice("", tried, survived, {"tried": tried, "killed": tried - len(survived)})


def _covered(found: Any, step: float) -> Slice:
    return Slice(
        "", step, [f"{r['form']}: cover {r['cover']}, told {r['told']}" for r in found["rows"] if not r["met"]]
    )


def judges(workers: int = 1) -> list[Judge]:
    """All judges."""

    def fuzz(target: str, cases: int, step: int) -> Judge:
        def command(before: float, step: float, out: Path) -> list[str]:
            words = ["fuzz", target, "--runs", f"{step:.0f}", "--seed", f"{before:.0f}", "--faults", "1000000"]
            return [*PALPATE, *words, "--workers", str(workers), "--json", str(out)]

        return Judge(f"fuzz {target}", cases, "cases", step, command, _fuzzed)

    def guided(target: str) -> Judge:
        def command(before: float, step: float, out: Path) -> list[str]:
            words = [target, "--seconds", f"{60 * step:.0f}", "--seed", f"{1 + before:.0f}", "--json", str(out)]
            return [sys.executable, "tools/fuzz.py", *words]

        return Judge(f"libFuzzer {target}", 60, "minutes", 5, command, _guided)

    def mutants(group: str) -> Judge:
        def command(before: float, step: float, out: Path) -> list[str]:
            words = [group, "--sample", f"{step:.0f}", "--seed", f"{before / step:.0f}", "--json", str(out)]
            return [sys.executable, "tools/mutants.py", *words]

        return Judge(f"mutants {group}", 200, "planted faults", 20, command, _mutated)

    def coverage(name: str) -> Judge:
        def command(before: float, step: float, out: Path) -> list[str]:
            words = ["coverage", "--estimate", name, "--trials", f"{step:.0f}", "--workers", str(workers)]
            return [*PALPATE, *words, "--resume", str(JOURNAL.parent / "coverage"), "--json", str(out)]

        return Judge(f"coverage {name}", 200, "trials a form", 200, command, _covered)

    def soak(before: float, step: float, out: Path) -> list[str]:
        log = str(JOURNAL.parent / "soak_ros.jsonl")
        return [*PALPATE, "soak", "ros", "--hours", f"{before + step:g}", "--log", log, "--json", str(out)]

    def conformance(before: float, step: float, out: Path) -> list[str]:
        words = ["study", "guidance", "--conformance", "--seeds", f"{step:.0f}", "--first-seed", f"{1 + before:.0f}"]
        return [*PALPATE, *words, "--workers", str(workers), "--figures", str(JOURNAL.parent), "--json", str(out)]

    from fuzz import TARGETS
    from mutants import GROUPS

    from palpate_lab.verify.coverage.run import names

    return [
        *(guided(target) for target in TARGETS),
        *(mutants(group) for group in GROUPS),
        Judge("conformance", 10, "seeds", 1, conformance, _conform),
        fuzz("contact", 400_000, 2000), fuzz("grids", 200_000, 4000), fuzz("models", 150_000, 2000),
        fuzz("tables", 100_000, 1500), fuzz("files", 60_000, 600), fuzz("packets", 50_000, 500),
        fuzz("records", 20_000, 250), fuzz("scenes", 20_000, 200),
        fuzz("ports", 10_000, 10),
        fuzz("loops", 20_000, 100),
        Judge("soak ros", 4, "h", 0.1, soak, _soaked),
        *(coverage(name) for name in names()),
    ]  # fmt: skip


def read_journal(path: Path) -> list[Slice]:
    """Finished slices; a last line that was cut off is ignored."""
    found = []
    for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else []:
        try:
            found.append(Slice(**json.loads(line)))
        except ValueError:
            break
    return found


def of(judge: Judge, slices: Sequence[Slice]) -> list[Slice]:
    """The slices of a judge."""
    return [one for one in slices if one.judge == judge.name]


def share(judge: Judge, slices: Sequence[Slice]) -> float:
    """Share of what is asked of a judge that has run."""
    return sum(one.done for one in of(judge, slices)) / judge.asked


def next_judge(chosen: Sequence[Judge], slices: Sequence[Slice], broken: set[str]) -> Judge | None:
    """The judge that is farthest from its end; None if all have ended."""
    open_ = [one for one in chosen if one.name not in broken and share(one, slices) < 1.0 - 1e-9]
    return min(open_, key=lambda one: share(one, slices), default=None)


def run(judge: Judge, slices: Sequence[Slice]) -> Slice:
    """Run the next slice of a judge at the lowest priority.

    Raises:
        OSError: the command ended without a result; the message has its last lines.
    """
    before = sum(one.done for one in of(judge, slices))
    step, began = min(judge.step, judge.asked - before), time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "result.json"
        words = judge.command(before, step, out)
        done = subprocess.run([*LAST, *words], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode not in (0, 1) or not out.exists():  # 1: it found something
            raise OSError(f"{' '.join(words)} ended with {done.returncode}: {done.stdout[-600:].strip()}")
        found = judge.read(json.loads(out.read_text(encoding="utf-8")), step)
    found.judge, found.seconds, found.commit = judge.name, time.monotonic() - began, commit()
    found.load = os.getloadavg()[0]
    return found


def rows(chosen: Sequence[Judge], slices: Sequence[Slice], broken: dict[str, str]) -> list[dict[str, Any]]:
    """A row for each judge, as docs/results/night.json holds it."""
    found = []
    for judge in chosen:
        mine = of(judge, slices)
        fails, verdict = judge.verdict(mine)
        found.append({
            "judge": judge.name, "asked": judge.asked, "ran": sum(one.done for one in mine), "unit": judge.unit,
            "fails": fails or judge.name in broken, "verdict": broken.get(judge.name, verdict),
            "faults": [fault for one in mine for fault in one.faults][:SHOWN],
            "seconds": round(sum(one.seconds for one in mine)), "load": max((one.load for one in mine), default=0.0),
            "commits": sorted({one.commit for one in mine}),
        })  # fmt: skip
    return found


def table(found: Sequence[dict[str, Any]]) -> str:
    """The rows as text."""
    lines = [f"{'judge':24} {'ran':>10} {'of':>10} {'':15} {'time':>7}  verdict"]
    for row in found:
        lines.append(f"{row['judge']:24} {row['ran']:>10,.6g} {row['asked']:>10,.6g} {row['unit']:15}"
                     f" {row['seconds']:>5} s  {row['verdict']}")  # fmt: skip
    whole = sum(row["ran"] >= row["asked"] - 1e-9 for row in found)
    none = ", ".join(row["judge"] for row in found if row["ran"] == 0) or "none"
    failed = ", ".join(row["judge"] for row in found if row["fails"]) or "none"
    return "\n".join([*lines, f"{whole} of {len(found)} judges ran whole; not run: {none}; fail: {failed}"])


def night(
    chosen: Sequence[Judge], hours: float, journal: Path, result: Path, known: Sequence[Judge] = ()
) -> list[dict[str, Any]]:
    """Run slices until the chosen judges have ended or the time is over; the rows of the known ones."""
    journal.parent.mkdir(parents=True, exist_ok=True)
    slices, broken, end = read_journal(journal), dict[str, str](), time.monotonic() + 3600.0 * hours
    while time.monotonic() < end and (judge := next_judge(chosen, slices, set(broken))):
        try:
            slices.append(run(judge, slices))
        except OSError as error:  # the others go on
            broken[judge.name] = f"it did not end well: {error}"
            print(f"{judge.name}: {error}", flush=True)
            continue
        write(journal, "".join(json.dumps(asdict(one)) + "\n" for one in slices))
        last = slices[-1]
        print(f"{judge.name}: {last.done:g} {judge.unit} in {last.seconds:.0f} s, {len(last.faults)} faults;"
              f" {share(judge, slices):.1%} of it have run", flush=True)  # fmt: skip
        write(result, document(rows(known or chosen, slices, broken)))
    found = rows(known or chosen, slices, broken)
    write(result, document(found))
    return found


def write(path: Path, text: str) -> None:
    """Replace a file at once, so that a stop leaves the old or the new one."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def document(found: Sequence[dict[str, Any]]) -> str:
    """The text of docs/results/night.json."""
    head = {"command": "make night", "commit": commit(), "cores": os.cpu_count(), "result": {"rows": list(found)}}
    return json.dumps(head, indent=1) + "\n"


def main() -> None:
    """Run the judges; 1 if one of them fails."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("judges", nargs="*", help="judges to run, for example 'soak ros'; all when left out")
    parser.add_argument("--hours", type=float, default=1000.0, help="time after which no further slice begins")
    parser.add_argument("--workers", type=int, default=os.cpu_count(), help="processes of a judge; one per core")
    parser.add_argument("--list", action="store_true", help="print what has run, and run nothing")
    options = parser.parse_args()
    known = judges(options.workers)
    if unknown := set(options.judges) - {one.name for one in known}:
        sys.exit(f"night: there is no judge {', '.join(unknown)}. Judges: {', '.join(one.name for one in known)}")
    chosen = [one for one in known if not options.judges or one.name in options.judges]
    found = night(chosen, 0.0 if options.list else options.hours, JOURNAL, RESULT, known)
    print(table(found))
    sys.exit(any(row["fails"] for row in found))


if __name__ == "__main__":
    main()
