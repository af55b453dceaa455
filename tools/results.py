"""Keeps results of documented runs: `python tools/results.py wall` runs the command and writes docs/results/wall.json.

A file holds the command, the commit of the code, the seed, a control of the machine's speed, and the numbers. The test
tests/docs/test_results.py compares the figures on the pages with them.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
RUNS: dict[str, tuple[str, tuple[str, ...]]] = {
    "wall": ("study wall --hands 100", ("curve", "sensitivity")),
    "certificate": ("study certificate --devices 500", ("devices",)),
    "passivity": ("study passivity", ()),
    "registration": ("study registration", ("layouts",)),
    "organs": ("bench contact --organs", ()),  # with the organ meshes of the test data
    "planning": ("bench planning", ()),
    "execution": ("bench execution --stops 50", ()),
    "execution_ros": ("bench execution --ros --stops 20", ()),
    "tissue": ("bench tissue", ("tick_ms", "control_ms", "viscosity")),
    "tissue_times": ("bench tissue --only ticks --only mujoco", ()),  # on an idle machine
}
"""Arguments of `palpate`, and the keys of its JSON that no page needs."""


def control() -> float:
    """Processor time of an import of numpy in a process of its own: the speed of the machine at this moment [s]."""
    code = "import resource, numpy; r = resource.getrusage(resource.RUSAGE_SELF); print(r.ru_utime + r.ru_stime)"
    return min(float(subprocess.check_output([sys.executable, "-c", code])) for _ in range(3))


def commit() -> str:
    """The commit of the code; with a + when files of the core or of the package differ from it."""

    def git(*words: str) -> str:
        return subprocess.check_output(["git", *words], cwd=ROOT, text=True).strip()

    changed = git("status", "--porcelain", "--untracked-files=no", "palpate", "core", "simulators", "models", "scenes")
    return git("rev-parse", "--short=12", "HEAD") + ("+" if changed else "")


def rounded(value: Any) -> Any:
    """The value with numbers of six significant digits."""
    if isinstance(value, float):
        return float(f"{value:.6g}")
    if isinstance(value, dict):
        return {key: rounded(one) for key, one in value.items()}
    return [rounded(one) for one in value] if isinstance(value, list) else value


def run(name: str, folder: Path) -> dict[str, Any]:
    """Run a documented command; its result with what is needed to repeat it."""
    arguments, left_out = RUNS[name]
    head: dict[str, Any] = {"command": f"palpate {arguments}", "commit": commit(), "control_numpy_import_s": control()}
    file, start = folder / "result.json", time.monotonic()
    more = ["--figures", str(folder), "--out", str(folder / "data.nc")] if arguments.startswith("study") else []
    subprocess.run(
        [sys.executable, "-m", "palpate", *arguments.split(), "--json", str(file), *more], check=True, cwd=ROOT
    )
    found = json.loads(file.read_text(encoding="utf-8"))
    found = {"rows": found} if isinstance(found, list) else found
    head["seed"] = found.get("seed", 0)  # a sweep without a seed of its own has 0
    kept = {key: value for key, value in found.items() if key not in left_out}
    return rounded(head | {"wall_s": time.monotonic() - start, "cores": os.cpu_count(), "result": kept})


def main() -> None:
    """Write docs/results/NAME.json for each name."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("names", nargs="+", choices=list(RUNS))
    for name in parser.parse_args().names:
        with tempfile.TemporaryDirectory() as folder:
            text = json.dumps(run(name, Path(folder)), indent=1)
        target = ROOT / "docs" / "results" / f"{name}.json"
        target.parent.mkdir(exist_ok=True)
        target.write_text(text + "\n", encoding="utf-8")
        print(f"{target.relative_to(ROOT)}: {len(text) / 1e3:.0f} kB")


if __name__ == "__main__":
    main()
