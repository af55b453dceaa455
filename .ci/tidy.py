"""clang-tidy over our own C++ as the build compiles it; a file seen clean is looked at again only when it changed."""

import hashlib
import os
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TIDY = Path(sys.executable).with_name("clang-tidy")
GCC_ONLY = ("-mtls-dialect=gnu2",)  # flags of the build's compiler that clang does not know


def fingerprint(file: Path, common: bytes) -> str:
    return hashlib.sha256(common + file.as_posix().encode() + file.read_bytes()).hexdigest()


def main() -> int:
    databases = sorted(ROOT.glob("build/*/compile_commands.json"), key=lambda p: p.stat().st_mtime)
    if not databases:
        print("clang-tidy: no build/*/compile_commands.json. Run `make setup` first, it builds the core.")
        return 1
    # A file younger than the last build borrows the command of its neighbour.
    sources = sorted([*ROOT.glob("core/**/*.cpp"), *ROOT.glob("bindings/*.cpp")])
    build, seen = databases[-1].parent, ROOT / "build" / "tidy"
    seen.mkdir(exist_ok=True)
    headers = sorted([*ROOT.glob("core/**/*.hpp"), *ROOT.glob("bindings/*.hpp"), ROOT / ".clang-tidy"])
    version = subprocess.run([TIDY, "--version"], capture_output=True, check=True).stdout
    common = version + b"".join(h.read_bytes() for h in headers)

    def look(file: Path) -> bool:
        stamp = seen / fingerprint(file, common)
        if stamp.exists():
            return True
        command = [str(TIDY), "--quiet", "-p", str(build), *(f"--removed-arg={a}" for a in GCC_ONLY), str(file)]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        if run.returncode == 0:
            stamp.touch()
        else:
            print(f"{file.relative_to(ROOT)}:\n{run.stdout}{run.stderr}", flush=True)
        return run.returncode == 0

    with ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        return 0 if all(list(pool.map(look, sources))) else 1


if __name__ == "__main__":
    sys.exit(main())
