"""Compares the factor of lockstep with that of another commit: `python tools/lockstep_ratio.py COMMIT`.

Checks the commit out into a temporary worktree, compiles its core with this environment's compiler and packages, and
runs the scene of `palpate bench loop` (an organ) with both, in turns. Prints the factor of each round (simulated
seconds per second of the thread's CPU time), the ratio of the medians, and the median compute time of the haptic cycle.
A commit that does not compile needs `--patch FILE`, which git applies to the worktree.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from pathlib import Path
from statistics import median
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
RUN = """
import json, sys, time
root, seconds, packages = sys.argv[1:]
sys.path[:0] = [root]
sys.path.append(packages)
import palpate
from palpate.scene import Scene, rig
assert palpate.__file__.startswith(root), palpate.__file__
scene = {"objects": [{"shape": "organ", "stiffness": 400.0}], "rates": {"haptic": 1000.0}}
simulation = rig.build(Scene.model_validate(scene)).simulation()
simulation.run(250)
begin = time.thread_time()
for _ in range(4 * int(seconds)):
    simulation.run(250)
spent = time.thread_time() - begin
print(json.dumps([int(seconds) / spent, simulation.timing()["cycle_us"]["p50"]]))
"""


class Round(NamedTuple):
    """One run of one state."""

    factor: float
    """Simulated seconds per second of CPU time."""
    cycle_us: float
    """Median compute time of the haptic cycle [us]."""


def table(before: list[Round], now: list[Round]) -> str:
    """One line per round, and one with the medians and their ratio."""
    rows: list[tuple[str, ...]] = [("round", "before", "now", "ratio", "cycle before [us]", "cycle now [us]")]
    middle = [Round(*map(median, zip(*rounds, strict=True))) for rounds in (before, now)]
    named = [(str(i), b, n) for i, (b, n) in enumerate(zip(before, now, strict=True), 1)]
    for name, b, n in [*named, ("median", middle[0], middle[1])]:
        numbers = (b.factor, n.factor, n.factor / b.factor, b.cycle_us, n.cycle_us)
        rows.append((name, *(f"{x:.{digits}f}" for x, digits in zip(numbers, (1, 1, 2, 2, 2), strict=True))))
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join("  ".join(map(str.rjust, row, widths)) for row in rows)


def run(root: Path, seconds: int) -> Round:
    """Runs the scene with the package in `root`; another checkout without the hooks of this environment's install."""
    packages = sysconfig.get_paths()["platlib"]
    command = [sys.executable, *([] if root == ROOT else ["-S"]), "-c", RUN, str(root), str(seconds), packages]
    output = subprocess.run(command, check=True, capture_output=True, text=True, cwd=root).stdout
    return Round(*json.loads(output.splitlines()[-1]))


def build(root: Path) -> None:
    """Compiles the core of the source tree and puts it into its package."""
    folder = root / "build" / "lockstep"
    # An editable build looks for the wheels' libraries where this environment has them.
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DPALPATE_PARTS=", "-DSKBUILD_STATE=editable",
               f"-DPython_EXECUTABLE={sys.executable}"]  # fmt: skip
    hints = subprocess.check_output([sys.executable, "-m", "nanobind", "--cmake_dir"], text=True).strip()
    subprocess.run(["cmake", "-S", str(root), "-B", str(folder), "-G", "Ninja", f"-Dnanobind_DIR={hints}", *options],
                   check=True, stdout=subprocess.DEVNULL)  # fmt: skip
    subprocess.run(["cmake", "--build", str(folder)], check=True, stdout=subprocess.DEVNULL)
    for library in folder.glob("*.so"):
        (root / "palpate" / library.name).symlink_to(library)


@contextlib.contextmanager
def worktree(commit: str, patch: Path | None) -> Iterator[Path]:
    """A temporary checkout of the commit, with the patch applied."""
    git = ["git", "-C", str(ROOT), "worktree"]
    with tempfile.TemporaryDirectory(prefix="lockstep-") as temporary:
        root = Path(temporary) / "palpate"
        subprocess.run([*git, "add", "--quiet", "--detach", str(root), commit], check=True)
        try:
            if patch is not None:
                subprocess.run(["git", "-C", str(root), "apply", str(patch.resolve())], check=True)
            yield root
        finally:
            subprocess.run([*git, "remove", "--force", str(root)], check=True)


def main() -> None:
    """Reads the command line, runs the comparison and prints the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", help="commit to compare with")
    parser.add_argument("--rounds", type=int, default=5, help="runs of each state, in turns")
    parser.add_argument("--seconds", type=int, default=20, help="simulated time of one run [s]")
    parser.add_argument("--patch", type=Path, help="file of changes without which the commit does not compile")
    arguments = parser.parse_args()
    with worktree(arguments.commit, arguments.patch) as root:
        build(root)
        rounds = [(run(root, arguments.seconds), run(ROOT, arguments.seconds)) for _ in range(arguments.rounds)]
    before, now = map(list, zip(*rounds, strict=True))
    print(table(before, now))


if __name__ == "__main__":
    main()
