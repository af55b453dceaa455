"""The loops of types/ldlt.cpp give the same numbers as Eigen's LDLT, to the last bit."""

import shutil
import subprocess
from pathlib import Path

import cmeel
import pytest

ROOT = Path(__file__).resolve().parents[2]
EIGEN = Path(cmeel.__path__[0]).parent / "cmeel.prefix" / "include" / "eigen3"
SOURCE = "palpate/types/ldlt.cpp"
PIVOT = "std::abs(L_[i][i]) > std::abs(L_[best][best])"


@pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")
@pytest.mark.parametrize("changed", [PIVOT, "false"], ids=["ours", "without pivots"])
def test_equals_eigen_to_the_last_bit(tmp_path, changed):
    """Also for singular matrices. A factorisation that exchanges no rows is told."""
    text = (ROOT / "core" / SOURCE).read_text(encoding="utf-8")
    assert PIVOT in text
    (tmp_path / SOURCE).parent.mkdir(parents=True)
    (tmp_path / SOURCE).write_text(text.replace(PIVOT, changed), encoding="utf-8")
    program = tmp_path / "ldlt"
    subprocess.run(
        ["g++", "-std=c++20", "-O1", "-DNDEBUG", "-ffp-contract=off", "-I", str(tmp_path), "-I", str(ROOT / "core"),
         "-isystem", str(EIGEN), str(Path(__file__).with_name("ldlt.cpp")), "-o", str(program)],
        check=True,
    )  # fmt: skip
    found = subprocess.run([str(program), "20000"], check=True, capture_output=True, text=True).stdout.split()
    assert len(found) == 2
    assert all((int(differing) == 0) == (changed == PIVOT) for differing in found), found
