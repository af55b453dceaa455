"""Runs clang-tidy on Palpate's C++ with the flags of the builds; a clean file is checked again only after a change."""

import hashlib
import json
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TIDY = Path(sys.executable).with_name("clang-tidy")
GCC_ONLY = ("-mtls-dialect=gnu2",)  # flags of the build's compiler that clang does not know
SEEN = ROOT / "build" / "tidy"
FOLDERS = ("core", "simulators", "bindings")
NODES = ROOT / "palpate" / "ros" / "cpp"


def fingerprint(file: Path, common: bytes) -> str:
    return hashlib.sha256(common + file.as_posix().encode() + file.read_bytes()).hexdigest()


def core_database() -> Path:
    """Compilation database with a command per file: the build's own compiles folders as one, with GCC's headers."""
    folder = SEEN / "core"
    beside = Path(sys.executable).parent
    nanobind = subprocess.run(
        [sys.executable, "-m", "nanobind", "--cmake_dir"], capture_output=True, text=True, check=True
    )
    settings = {
        "CMAKE_BUILD_TYPE": "Release",
        "CMAKE_EXPORT_COMPILE_COMMANDS": "ON",
        "CMAKE_MAKE_PROGRAM": beside / "ninja",
        "PALPATE_UNITY": "OFF",
        "Python_EXECUTABLE": sys.executable,
        "nanobind_DIR": nanobind.stdout.strip(),
    }
    defines = [f"-D{key}={value}" for key, value in settings.items()]
    configure = [beside / "cmake", "-S", ROOT, "-B", folder, "-G", "Ninja", *defines]
    subprocess.run(configure, capture_output=True, check=True)
    return folder


def nodes_database() -> Path | None:
    """Compilation database of the ROS nodes, from the newest build that `palpate ros` has left in the user's cache."""
    cache = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "palpate" / "ros"
    ours = f"CMAKE_HOME_DIRECTORY:INTERNAL={NODES}\n"
    builds = [c.parent for c in cache.glob("*/build/CMakeCache.txt") if ours in c.read_text()]
    if not builds:
        return None
    build = max(builds, key=lambda p: p.stat().st_mtime)
    compdb = subprocess.run(["ninja", "-C", build, "-t", "compdb"], capture_output=True, check=True).stdout
    joined = next(entry for entry in json.loads(compdb[compdb.index(b"[") :]) if "/Unity/" in entry["file"])
    entries = [  # the build compiles several files as one; clang-tidy needs the command of each
        joined | {"file": str(source), "command": joined["command"].replace(joined["file"], str(source))}
        for source in NODES.glob("**/*.cpp")
    ]
    folder = SEEN / "nodes"
    folder.mkdir(exist_ok=True)
    (folder / "compile_commands.json").write_text(json.dumps(entries))
    return folder


def main() -> int:
    SEEN.mkdir(parents=True, exist_ok=True)
    core = core_database()
    sources = dict.fromkeys(sorted(file for folder in FOLDERS for file in ROOT.glob(f"{folder}/**/*.cpp")), core)
    nodes = nodes_database()
    if nodes is None:
        print("clang-tidy: the ROS nodes are skipped, as they are not compiled here; `palpate ros setup` compiles them")
    else:
        sources |= dict.fromkeys(sorted(NODES.glob("**/*.cpp")), nodes)
    headers = [file for folder in FOLDERS for file in ROOT.glob(f"{folder}/**/*.hpp")] + [*NODES.glob("**/*.hpp")]
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    common = version + b"".join(h.read_bytes() for h in [*sorted(headers), ROOT / ".clang-tidy"])

    def check(file: Path) -> bool:
        stamp = SEEN / fingerprint(file, common)
        if stamp.exists():
            return True
        removed = (f"--removed-arg={a}" for a in GCC_ONLY)
        unused = "--extra-arg=-Wno-unused-command-line-argument"  # flags of GCC that clang takes and ignores
        command = [str(TIDY), "--quiet", "-p", str(sources[file]), *removed, unused, str(file)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode == 0:
            stamp.touch()
        else:
            print(f"{file.relative_to(ROOT)}:\n{run.stdout}{run.stderr}", flush=True)
        return run.returncode == 0

    with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        return 0 if all(list(pool.map(check, sources))) else 1


if __name__ == "__main__":
    sys.exit(main())
