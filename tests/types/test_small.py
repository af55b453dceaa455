"""The operators of small.hpp and Eigen's give the same numbers to the last bit."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import cmeel
import pytest

ROOT = Path(__file__).resolve().parents[2]
EIGEN = Path(os.path.dirname(cmeel.__file__)).parent / "cmeel.prefix" / "include" / "eigen3"


def printed(folder: Path, *flags: str) -> str:
    """What small.cpp prints when it is compiled with these flags."""
    program = folder / ("own" if flags else "eigen")
    subprocess.run(
        ["g++", "-std=c++20", "-O1", "-DNDEBUG", *flags, "-I", str(ROOT / "core"), "-isystem", str(EIGEN),
         str(Path(__file__).with_name("small.cpp")), "-o", str(program)],
        check=True,
    )  # fmt: skip
    return subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
def test_equals_eigen_to_the_last_bit(tmp_path: Path) -> None:
    eigen, own = printed(tmp_path), printed(tmp_path, "-DOWN")
    assert len(eigen.splitlines()) > 10_000
    assert own == eigen
