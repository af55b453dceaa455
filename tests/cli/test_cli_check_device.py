"""`palpate check` of a scene with a driver speaks of the device, and a record of one can be run again from anywhere."""

import json
import os
import textwrap
from pathlib import Path

import pytest

from palpate.cli import main
from palpate.record.reader import Record
from palpate.scene import Scene
from palpate.session import Session
from palpate.viewer.staging import stage_of_record

DRIVER = """
    import helper_beside_my_driver
    import numpy as np

    class Omega:
        rate, force_max, workspace = 500.0, 2.0, (0.16, 0.12, 0.08)
        opened = False
        def open(self): Omega.opened = True
        def close(self): pass
        def write(self, wrench): pass
        def read(self): return np.eye(4)
"""
SCENE = "objects: [{name: ball, sphere: {radius: 0.03}, stiffness: 400}]\narms:\n  leader: {driver: DRIVER}\n"


@pytest.fixture
def folder(tmp_path):
    """A folder with a driver and a scene that names it."""
    (tmp_path / "my_omega_driver.py").write_text(textwrap.dedent(DRIVER))
    (tmp_path / "helper_beside_my_driver.py").write_text("")
    (tmp_path / "scene.yaml").write_text(SCENE.replace("DRIVER", "my_omega_driver:Omega"))
    return tmp_path


def checked(capsys, *arguments):
    assert main(["check", "--trust", *map(str, arguments)]) == 0
    return capsys.readouterr().out


def test_check_tells_the_facts_of_the_device_without_opening_it(folder, capsys):
    text = " ".join(checked(capsys, folder / "scene.yaml").split())
    assert "device: my_omega_driver:Omega: 500 Hz, at most 2 N; a workspace of 160 x 120 x 80 mm" in text
    assert "the tool reaches 80 x 60 x 40 mm without the clutch" in text
    assert "mapping: indexed, 0.5 mm of the tool per mm of the hand" in text
    assert "Jacobian" not in text
    assert "both arms" not in text
    import my_omega_driver

    assert not my_omega_driver.Omega.opened
    found = json.loads(checked(capsys, folder / "scene.yaml", "--json", "-"))
    assert found["device"] == {
        "driver": "my_omega_driver:Omega", "rate_Hz": 500.0, "force_cap_N": 2.0, "workspace_m": [0.16, 0.12, 0.08],
        "mapping": "indexed", "scale": 0.5,
    }  # fmt: skip
    assert found["start"]["leader_jacobian_condition"] is None


@pytest.mark.parametrize(
    ("driver", "words"),
    [
        ("mouse", "mouse: 250 Hz, no force; a workspace of 200 x 200 x 200 mm"),
        ("loop", "loop: 1000 Hz, at most 3 N; its workspace is known only while it runs"),
        ("./device.so", "./device.so: 1000 Hz, at most 3 N; its workspace is known only while it runs"),
    ],
)
def test_check_without_the_device(tmp_path, capsys, driver, words):
    (tmp_path / "scene.yaml").write_text(SCENE.replace("DRIVER", driver))
    assert words in " ".join(checked(capsys, tmp_path / "scene.yaml").split())


def test_check_of_a_simulated_arm_still_tells_its_jacobian(tmp_path, capsys):
    (tmp_path / "scene.yaml").write_text(SCENE.partition("arms")[0])
    text = checked(capsys, tmp_path / "scene.yaml")
    assert "condition" in text
    assert "device:" not in text


@pytest.mark.parametrize(
    ("driver", "words"),
    [
        ("no_such_module_here:Omega", "cannot be imported"),
        ("./none.py:Omega", "there is no file"),
        ("./scene.yaml.py:Omega", "there is no file"),
        ("./broken.py:Omega", "SyntaxError"),
        ("./my_omega_driver.py:Sigma", "Sigma"),
    ],
)
def test_a_driver_that_cannot_be_found_is_told_by_check_with_its_line(folder, capsys, driver, words):
    (folder / "broken.py").write_text("class Omega(:\n")
    (folder / "scene.yaml").write_text(SCENE.replace("DRIVER", driver))
    assert main(["check", "--trust", str(folder / "scene.yaml")]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert words in told
    assert "scene.yaml:3" in told
    assert "mend:" in told


@pytest.mark.usefixtures("without_figures")
@pytest.mark.parametrize("driver", ["my_omega_driver:Omega", "./my_omega_driver.py:Omega"])
def test_a_record_runs_and_replays_from_another_folder(folder, tmp_path, capsys, monkeypatch, driver):
    (folder / "scene.yaml").write_text(SCENE.replace("DRIVER", driver))
    summary = Session(Scene.load(folder / "scene.yaml", trust=True), tmp_path / "runs").run(0.1)
    os.mkdir(tmp_path / "elsewhere")
    monkeypatch.chdir(tmp_path / "elsewhere")
    kept = Path(summary.record).parent / "scene.yaml"
    assert f"driver: {folder}/my_omega_driver.py:Omega" in kept.read_text()
    assert str(folder) not in Record.open(summary.record).scene, "the record itself holds no path of this machine"
    arguments = ["run", str(kept), "--trust", "--headless", "--duration", "0.1", "--out", str(tmp_path / "again")]
    assert main(arguments) == 0
    assert "500 Hz" in capsys.readouterr().out
    assert [obj.name for obj in stage_of_record(Record.open(summary.record)).objects] == ["ball"]


def test_a_shared_object_beside_the_scene_is_kept_by_its_path(tmp_path):
    (tmp_path / "device.so").write_bytes(b"")
    scene = Scene.parse(SCENE.replace("DRIVER", '"./device.so:0"'), str(tmp_path / "scene.yaml"))
    assert scene.resolved_driver() == f"{tmp_path}/device.so:0"
    assert Scene.parse(SCENE.replace("DRIVER", "simulated:free")).resolved_driver() == "simulated:free"


def test_the_model_that_a_bench_writes_is_no_scene(tmp_path, capsys):
    model = tmp_path / "device.yaml"
    model.write_text("kind: device\nmass: 0.2\nrate: 1000\n")
    assert main(["check", str(model)]) == 2
    said = capsys.readouterr().err
    assert "is the model of a device, not a scene" in said
    assert "palpate certify" in said
