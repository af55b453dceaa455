"""`palpate calibrate gravity`, `import`, `export`: files, figures, lossless conversion; and a model in a scene."""

import json
import sys
from pathlib import Path

import json_contract
import pytest
import yaml

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "identify"))
import synthetic_arm as synthetic


@pytest.fixture
def poses(tmp_path) -> Path:
    synthetic.write(tmp_path / "poses.csv", synthetic.recording(60, 1))
    synthetic.write(tmp_path / "others.csv", synthetic.recording(40, 2))
    return tmp_path / "poses.csv"


def test_model_figure_and_json(palpate, poses, tmp_path):
    done = palpate("calibrate", "gravity", poses, "--arm", "mtmr", "--out", "m.yaml", "--test", "others.csv",
                   "--json", "m.json")  # fmt: skip
    assert done.code == 0, done.err
    report = json.loads((tmp_path / "m.json").read_text())
    assert set(report) == json_contract.keys("calibrate gravity")
    assert report["model"] == "potential"
    assert [len(report[part][key]) for part in ("train", "test") for key in ("rms_Nm", "r2")] == [6] * 4
    assert report["rank"] == report["structural_rank"] == 10
    assert yaml.safe_load((tmp_path / "m.yaml").read_text())["arm"] == "mtm_right"
    assert (tmp_path / "m.png").stat().st_size > 10_000
    assert "friction floor" in done.out
    assert "next pose" in done.out
    assert "base parameters" in done.out


def test_existing_files_are_overwritten_only_with_force(palpate, poses, tmp_path):
    (tmp_path / "m.yaml").write_text("precious")
    command = ("calibrate", "gravity", poses, "--arm", "mtmr", "--out", "m.yaml", "--model", "paper")
    done = palpate(*command)
    assert done.code == 2
    assert "m.yaml: the file exists already\n  mend: give --force, or another name" in done.err
    assert (tmp_path / "m.yaml").read_text() == "precious"
    (tmp_path / "old.json").write_text("precious")
    assert "old.json: the file exists already" in palpate(*command, "--out", "new.yaml", "--json", "old.json").err
    assert not (tmp_path / "new.yaml").exists()
    for command_name, file in (("import", "gc.json"), ("export", "m.yaml")):
        done = palpate("calibrate", command_name, file, "--out", "old.json")
        assert done.code == 2
        assert (tmp_path / "old.json").read_text() == "precious", command_name
    assert palpate(*command, "--force").code == 0
    assert "precious" not in (tmp_path / "m.yaml").read_text()


def test_arm_option_is_required(palpate, poses):
    done = palpate("calibrate", "gravity", poses, "--out", "m.yaml")
    assert done.code == 2
    assert "--arm" in done.err


def test_export_and_import(palpate, poses, tmp_path):
    palpate("calibrate", "gravity", poses, "--arm", "mtmr", "--out", "m.yaml", "--model", "dvrk")
    assert palpate("calibrate", "export", "m.yaml", "--out", "gc.json", "--serial", "7").code == 0
    done = palpate("calibrate", "import", "gc.json", "--out", "back.yaml")
    assert done.code == 0
    assert "serial 7" in done.out
    done = palpate("calibrate", "import", "m.yaml", "--out", "no.yaml")
    assert done.code == 2
    assert "this is no gravity compensation of the dVRK" in done.err


SCENE = """\
objects: [{shape: organ, triangles: 3000}]
operator: {palpate: {approach: 0.2, press: 0.1, slide: 0.2, leave: 0.1}}
arms: {leader: {model: mtm_%s, gravity_model: m.yaml, plant_gravity_model: m.yaml}}
duration: 0.1
record: {report: false}
"""


def test_scene_uses_the_gravity_model(palpate, poses, tmp_path):
    from palpate import Arm
    from palpate.arm.gravity_model import GravityModel
    from palpate.record import Record

    palpate("calibrate", "gravity", poses, "--arm", "mtmr", "--out", "m.yaml", "--model", "gravity+springs")
    (tmp_path / "s.yaml").write_text(SCENE % "right")
    done = palpate("run", "s.yaml", "--headless", "--out", "o", "--json", "run.json")
    assert done.code == 0, done.err
    ticks = Record.open(json.loads((tmp_path / "run.json").read_text())["record"]).ticks
    arm = GravityModel.load(tmp_path / "m.yaml").apply(Arm.mtm("right"))
    row = ticks[-1]
    assert arm.holding(row["q"][:7])[:6] == pytest.approx(row["tau_gravity"][:6], abs=1e-9)

    (tmp_path / "s.yaml").write_text(SCENE % "left")
    done = palpate("run", "s.yaml", "--headless", "--out", "o")
    assert done.code == 2
    assert "the gravity model is of mtm_right, the arm is mtm_left" in done.err
    assert "s.yaml:3" in done.err
