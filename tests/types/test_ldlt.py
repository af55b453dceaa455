"""The loops of types/ldlt.cpp give the same numbers as Eigen's LDLT, to the last bit."""

import shutil
import subprocess
from pathlib import Path

import cmeel
import pytest

ROOT = Path(__file__).resolve().parents[2]
EIGEN = Path(cmeel.__path__[0]).parent / "cmeel.prefix" / "include" / "eigen3"
SOURCE = ROOT / "core" / "palpate" / "types" / "ldlt.cpp"
PIVOT = "std::abs(L_[i][i]) > std::abs(L_[best][best])"


pytestmark = pytest.mark.skipif(shutil.which("g++") is None, reason="needs g++")


def compiled(source, out):
    """Compile a file of C++ to an object file."""
    options = ("-std=c++20", "-O0", "-DNDEBUG", "-ffp-contract=off", "-I", ROOT / "core", "-isystem", EIGEN)
    subprocess.run(["g++", *options, "-c", source, "-o", out], check=True)
    return out


@pytest.fixture(scope="module")
def judge(tmp_path_factory):
    """The object file that compares with Eigen."""
    return compiled(Path(__file__).with_name("ldlt.cpp"), tmp_path_factory.mktemp("judge") / "judge.o")


@pytest.mark.parametrize("changed", [PIVOT, "false"], ids=["ours", "without pivots"])
def test_equals_eigen_to_the_last_bit(tmp_path, judge, changed):
    """Also for singular matrices. A factorisation that exchanges no rows is told."""
    text = SOURCE.read_text(encoding="utf-8")
    assert PIVOT in text
    (tmp_path / "ldlt.cpp").write_text(text.replace(PIVOT, changed), encoding="utf-8")
    own = compiled(tmp_path / "ldlt.cpp", tmp_path / "ldlt.o")
    program = tmp_path / "ldlt"
    subprocess.run(["g++", judge, own, "-o", program], check=True)
    found = subprocess.run([program, "20000"], check=True, capture_output=True, text=True).stdout.split()
    assert len(found) == 2
    assert all((int(differing) == 0) == (changed == PIVOT) for differing in found), found
