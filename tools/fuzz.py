"""Coverage-guided fuzzing of the C++ core: `make fuzz` compiles it with clang's sanitizers and runs each target.

A target of tests/fuzz turns bytes into a scene, a path or messages, and ends the process where a condition is violated;
libFuzzer looks for bytes that reach new code. Inputs that found a fault stay in build/fuzz/faults.
"""

from __future__ import annotations

import argparse
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[1]
BUILD = ROOT / "build" / "fuzz"
TARGETS = tuple(sorted(file.stem for file in (ROOT / "tests" / "fuzz").glob("*.cpp")))

SEEDS = 40  # random inputs with which each target begins


def build(targets: list[str]) -> None:
    """Compile the core and the targets."""
    names = ("clang++", *(f"clang++-{version}" for version in range(29, 13, -1)))
    compiler = next(filter(shutil.which, names), None)
    if compiler is None:
        sys.exit("fuzz: no clang++ found. Mend: sudo apt install clang")
    import nanobind

    options = ("-DCMAKE_BUILD_TYPE=Release", f"-DCMAKE_CXX_COMPILER={compiler}", "-DPALPATE_FUZZ=ON")
    found = (f"-DPython_EXECUTABLE={sys.executable}", f"-Dnanobind_DIR={nanobind.cmake_dir()}")
    configure = ["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", *options, *found]
    subprocess.run(configure, check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cmake", "--build", BUILD, "--target", *(f"fuzz_{name}" for name in targets)], check=True)


def run(target: str, runs: int, seconds: int, seed: int) -> tuple[int, bool]:
    """Number of cases that a target has run, and whether none violated a condition.

    Args:
        target: its name.
        runs: number of cases; -1: no bound.
        seconds: time after which it ends [s]; 0: no bound.
        seed: of the first case.
    """
    corpus, faults = BUILD / "corpus" / target, BUILD / "faults"
    corpus.mkdir(parents=True, exist_ok=True)
    random = Random(seed)
    for k in range(SEEDS):  # the fuzzer grows short inputs slowly
        (corpus / f"seed{k}").write_bytes(random.randbytes(random.choice((100, 200, 400, 800))))
    faults.mkdir(exist_ok=True)
    options = (
        f"-runs={runs}",
        f"-max_total_time={seconds}",
        f"-seed={seed}",
        "-max_len=1024",
        "-len_control=0",
        "-timeout=10",
        "-print_final_stats=1",
    )
    command = [BUILD / f"fuzz_{target}", *options, f"-artifact_prefix={faults}/{target}-", corpus]
    done = subprocess.run(command, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        print(done.stderr[-4000:])
    counted = re.search(r"number_of_executed_units: (\d+)", done.stderr)
    if "INFO: seed corpus" not in done.stderr:
        sys.exit(f"fuzz: {command[0]} ended with code {done.returncode} before its first case: no input is at fault")
    return int(counted[1]) if counted else 0, done.returncode == 0


def main() -> None:
    """Print the number of cases of each target."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("targets", nargs="*", default=list(TARGETS), help=f"targets: {', '.join(TARGETS)}")
    parser.add_argument("--runs", type=int, help="cases per target; 400,000 when --seconds is left out, too")
    parser.add_argument("--seconds", type=int, default=0, help="time per target")
    parser.add_argument("--seed", type=int, default=1, help="seed of the first case; the corpus of build/fuzz is kept")
    parser.add_argument("--json", type=Path, help="file for the number of cases and the faults")
    options = parser.parse_args()
    runs = options.runs or (-1 if options.seconds else 400_000)
    build(options.targets)
    total, faults = 0, list[str]()
    for target in options.targets:
        cases, fine = run(target, runs, options.seconds, options.seed)
        total, faults = total + cases, faults + ([] if fine else [f"{target}, seed {options.seed}: build/fuzz/faults"])
        print(f"{target}: {cases:,} cases, {'no fault' if fine else 'a fault: build/fuzz/faults'}", flush=True)
    print(f"{total:,} cases, seed {options.seed}")
    if options.json:
        options.json.write_text(json.dumps({"cases": total, "faults": faults}), encoding="utf-8")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
