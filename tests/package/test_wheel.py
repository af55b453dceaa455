"""The wheel in an empty environment without a compiler, from installation to the first force."""

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from palpate import rebuild

ROOT = Path(__file__).resolve().parents[2]
FIRST_FORCE = 25.0 / 0.15
"""Longest first run over the time of `python -c "import numpy"`: 25 s over 0.15 s [-]."""


def call(*command, env=None, cwd=None):
    done = subprocess.run(
        [str(word) for word in command], env=env, cwd=cwd, capture_output=True, text=True, timeout=600
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done


def seconds(*command, **where):
    began = time.perf_counter()
    call(*command, **where)
    return time.perf_counter() - began


@pytest.fixture(scope="module")
def uv():
    found = shutil.which("uv") or (ROOT / ".uv" / "bin" / "uv")
    if not Path(found).exists():
        pytest.skip("uv is not here: make setup installs it")
    return found


@pytest.fixture(scope="module")
def python(uv, tmp_path_factory):
    """The interpreter of a new environment with the wheel installed."""
    folder = tmp_path_factory.mktemp("wheel")
    call("make", "wheel", f"OUT={folder}", cwd=ROOT)
    (wheel,) = folder.glob("palpate-*.whl")
    call(uv, "venv", "--quiet", "--python", sys.executable, folder / "env")
    python = folder / "env" / "bin" / "python"
    call(uv, "pip", "install", "--quiet", "--python", python, f"palpate[viewer,report] @ {wheel.as_uri()}")
    return python


def test_wheel_renders_an_organ_without_a_compiler(python, tmp_path):
    env = {name: os.environ[name] for name in ("HOME", "LANG") if name in os.environ}
    env |= {"PATH": str(python.parent), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert shutil.which("g++", path=env["PATH"]) is None
    where = call(python, "-c", "import palpate; print(palpate.__file__)", env=env, cwd=tmp_path).stdout.strip()
    assert Path(where).is_relative_to(python.parent.parent)
    scene = Path(where).parent / "scenes" / "palpation.yaml"
    run = ("-m", "palpate", "run", scene, "--headless", "--duration", "2", "--json", "run.json")
    first = seconds(python, *run, env=env, cwd=tmp_path)
    control = min(seconds(python, "-c", "import numpy", env=env, cwd=tmp_path) for _ in range(5))
    result = json.loads((tmp_path / "run.json").read_text())
    assert result["peak_force_N"] > 0.5
    assert first < FIRST_FORCE * control
    print(f"the wheel's first run, 2 s simulated and the report: {first:.1f} s; importing numpy: {control:.2f} s")


def test_wheel_holds_every_part(python, tmp_path):
    names = ", ".join(["_core", *rebuild._PARTS])
    call(python, "-c", f"from palpate import {names}", cwd=tmp_path)
