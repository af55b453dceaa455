"""`palpate study geometry`: the figures of the paper and the documented numbers."""

import json

import json_contract
import pytest

from palpate_lab.studies.geometry.command import Command
from palpate_lab.studies.geometry.work import run


@pytest.fixture(scope="module")
def result():
    return run()


def test_normals_become_collinear(result):
    rows = result["point_contact"]
    assert [r["cross"] for r in rows] == sorted((r["cross"] for r in rows), reverse=True)
    assert rows[-1]["cross"] < 1e-6
    assert rows[-1]["dot"] == pytest.approx(-1.0, abs=1e-12)


def test_deflection_equals_the_depth(result):
    assert all(r["deflection_m"] == pytest.approx(r["depth_m"], abs=1e-15) for r in result["deflection"])


def test_slopes_equal_the_face_angles(result):
    assert [r["face_deg"] for r in result["slopes"]] == [15, 30, 45, 60, 75, 90]
    assert max(r["slope_error_deg"] for r in result["slopes"]) < 1e-12


def test_noise_and_results_of_eq_20(result):
    assert [r["error_rms_deg"] for r in result["noise"]] == pytest.approx([1.0, 10.0, 82.0], rel=0.06)
    assert all(bool(r["fails"]) == (r["face_deg"] > 90) for r in result["eq20"])


def test_command_writes_figures_and_the_documented_keys(tmp_path, capsys):
    assert Command(json=tmp_path / "g.json", figures=tmp_path / "figures")() == 0
    report = json.loads((tmp_path / "g.json").read_text())
    assert set(report) == json_contract.keys("study geometry")
    assert {key for rows in report.values() for key in rows[0]} == json_contract.keys_of(
        "study geometry", "Keys of the rows"
    )
    pictures = sorted((tmp_path / "figures").glob("geometry-*.png"))
    assert len(pictures) == 7
    assert all(2_000 < p.stat().st_size < 150_000 for p in pictures)
    assert "Eq 20" in capsys.readouterr().out
