"""Makes a wheel for each given interpreter and feels an organ with it, in a fresh environment without a compiler.

    .venv/bin/python tools/wheels.py python3.12 ~/pythons/3.13/bin/python [--wheels dist] [--json FILE]

Each wheel is installed as `uvx --from WHEEL palpate run palpation` does it, with packages that uv may have in its
cache. A wheel that is in --wheels already is not built again. Printed: wall and processor time from the command to the
end of a run of 2 s, the same for `palpate --version` in the installed environment, and, to measure the machine, the
time of importing numpy there.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
UV = shutil.which("uv") or str(ROOT / ".uv" / "bin" / "uv")
RUN = ["run", "palpation", "--headless", "--duration", "2", "--json", "r.json"]


def call(*command: str | Path, folder: Path, path: str | None = None) -> tuple[float, float]:
    """Wall and processor time of a command [s]; ends this program with its output when it fails."""
    env = os.environ if path is None else {**os.environ, "PATH": path}
    before, began = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [str(word) for word in command], cwd=folder, env=env, capture_output=True, text=True, check=False
    )
    wall, after = time.perf_counter() - began, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}\n{done.stdout[-3000:]}{done.stderr[-3000:]}")
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def tag(python: str) -> str:
    """The version in a wheel's name, such as cp312."""
    words = [python, "-c", "import sys; print('cp%d%d' % sys.version_info[:2])"]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()


def wheel(python: str, folder: Path) -> Path:
    """The wheel for an interpreter, made unless it exists."""
    name = f"palpate-*-{tag(python)}-*.whl"
    if not list(folder.glob(name)):
        with tempfile.TemporaryDirectory() as place:
            env = Path(place) / "build"
            call(UV, "venv", "--quiet", "--python", python, env, folder=ROOT)
            packages = ["--constraints", "constraints.txt", "--group", "build"]
            call(UV, "pip", "install", "--quiet", "--python", env / "bin" / "python", *packages, folder=ROOT)
            words = ["build", "--wheel", "--no-build-isolation", "--quiet", "--out-dir", folder.resolve()]
            path = f"{env / 'bin'}:{os.environ['PATH']}"
            call(UV, *words, "--python", env / "bin" / "python", folder=ROOT, path=path)
    return next(iter(folder.glob(name))).resolve()


def tried(python: str, file: Path) -> dict[str, object]:
    """What a wheel does in a fresh environment."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        first = call(
            UV, "tool", "run", "--isolated", "--python", python, "--from", file, "palpate", *RUN, folder=folder
        )
        felt = json.loads((folder / "r.json").read_text())
        env = folder / "env"
        call(UV, "venv", "--quiet", "--python", python, env, folder=folder)
        call(UV, "pip", "install", "--quiet", "--python", env / "bin" / "python", file, folder=folder)
        told = [call(env / "bin" / "palpate", "--version", folder=folder) for _ in range(5)]
        numpy = [call(env / "bin" / "python", "-c", "import numpy", folder=folder) for _ in range(5)]
    return {
        "python": tag(python), "wheel_MB": file.stat().st_size / 1e6, "peak_force_N": felt["peak_force_N"],
        "first_force_wall_s": first[0], "first_force_s": first[1], "version_wall_s": min(told)[0],
        "version_s": min(cpu for _, cpu in told), "numpy_s": min(cpu for _, cpu in numpy),
    }  # fmt: skip


def main() -> None:
    """Make, try, print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pythons", nargs="+", help="interpreters, 3.11 to 3.14")
    parser.add_argument("--wheels", type=Path, default=ROOT / "dist", help="folder of the wheels")
    parser.add_argument("--json", type=Path, help="file for the figures")
    words = parser.parse_args()
    unknown = [one for one in words.pythons if shutil.which(one) is None]
    if unknown:
        sys.exit(f"tools/wheels.py: no such interpreter: {', '.join(unknown)}")
    words.wheels.mkdir(parents=True, exist_ok=True)
    rows = []
    for python in words.pythons:
        row = tried(python, wheel(python, words.wheels))
        rows.append(row)
        print(re.sub(r"(\d\.\d\d)\d+", r"\1", ", ".join(f"{name} {value}" for name, value in row.items())), flush=True)
    if words.json:
        words.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
