"""A released arm: a correct gravity model holds it, a wrong one does not, and the study reports both."""

import json
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from palpate import Arm, _core
from palpate.base.errors import RecordingError
from palpate.base.sweep import sweep
from palpate_lab.studies.drift import plant as drift_plant
from palpate_lab.studies.drift import work as drift
from palpate_lab.studies.drift.command import Command

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "identify"))
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
import json_contract
import synthetic_arm as synthetic

MEASURED = np.arange(7) < 6


def plant(coulomb=synthetic.COULOMB) -> drift_plant.Plant:
    motors = synthetic.COULOMB[:, None]
    return drift_plant.Plant(synthetic.true_arm(), np.array(coulomb), motors, synthetic.NOISE, MEASURED,
                       synthetic.poses(100, 1), np.zeros(7))  # fmt: skip


def controller(scale: float) -> Arm:
    """A gravity model of the plant with all torques multiplied by `scale`."""
    arm = synthetic.true_arm()
    true = plant().arm
    fields = [
        _core.Field([0, 1, 2], np.array([[0.2, -0.1, 0.1], [-0.3, 0.2, -0.2]]), [0.6, 0.5, 0.9]),
        _core.Field([3], np.array([[0.5], [2.5]]), [1.2]),
    ]
    theta = np.concatenate([arm.moments, np.zeros(14), [0.035, -0.03], [0.03, -0.04]])
    arm.set_gravity_model(_core.GravityTerms(degree=1, fields=fields), scale * theta)
    assert np.allclose(controller_holds := arm.holding(np.zeros(7)), scale * true.holding(np.zeros(7))), (
        controller_holds
    )
    return arm


def test_correct_model_holds_the_arm_and_a_wrong_one_does_not():
    q = synthetic.poses(1, 4)[0]
    assert drift_plant.release(plant(), controller(1.0), q) < 1e-4
    assert drift_plant.release(plant(), controller(0.5), q) > 0.02


def test_friction_compensates_a_small_model_error():
    """An error below the friction of every joint gives no motion; without friction the arm moves."""
    q = synthetic.poses(1, 4)[0]
    nearly = controller(1.02)
    assert (np.abs(nearly.holding(q) - plant().arm.holding(q)) < synthetic.COULOMB + 1e-12)[:6].all()
    assert drift_plant.release(plant(), nearly, q) < 1e-4
    assert drift_plant.release(plant(np.zeros(7)), nearly, q) > 1e-3


def test_samples_of_the_plant_are_torques_with_friction_and_noise():
    poses = drift_plant.sampled(plant(), 200, seed=3)
    true = np.array([plant().arm.holding(q) for q in poses.q])
    left = poses.tau - true
    assert (np.abs(left[:, 6] + true[:, 6]) < 1e-12).all(), "the last joint is not measured"
    spread = np.sqrt((left[:, 3] ** 2).mean())
    assert spread == pytest.approx(np.hypot(synthetic.COULOMB[3], synthetic.NOISE[3]), rel=0.25)
    both = drift_plant.sampled(plant(), 200, seed=3, both_ways=True)
    assert np.sqrt(((both.tau - true)[:, 3] ** 2).mean()) == pytest.approx(synthetic.NOISE[3] / 2**0.5, rel=0.3)
    assert both.start.all()


def test_study_reports_every_model_on_every_plant(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(Command, "sweeper", lambda self, console: partial(sweep, executor="serial"))  # one process
    monkeypatch.setattr(drift, "TRAINED", 60)
    synthetic.write(tmp_path / "poses.csv", synthetic.recording(60, 1))
    files = {"json": tmp_path / "d.json", "figures": tmp_path / "figures"}
    Command(recordings=(tmp_path / "poses.csv",), arm="mtmr", releases=2, **files)()
    report = json.loads((tmp_path / "d.json").read_text())
    assert report["simulated"] is True
    assert set(report) | set(report["arms"][0]) | set(report["rows"][0]) == json_contract.keys("study drift")
    assert [(row["plant"], row["model"]) for row in report["rows"]] == [
        (name, form) for name in drift_plant.PLANTS for form in drift.FORMS
    ]
    by_form = {row["model"]: row for row in report["rows"] if row["plant"] == "as identified"}
    assert by_form["potential"]["torque_error_Nm"][0] < by_form["paper"]["torque_error_Nm"][0]
    assert "simulated arms, made from recordings" in capsys.readouterr().out
    assert (tmp_path / "figures/drift.png").stat().st_size > 10_000


def test_rough_plant_deviates_from_the_identified_model(tmp_path):
    synthetic.write(tmp_path / "poses.csv", synthetic.recording(60, 1))
    plants = drift_plant.make_plants([tmp_path / "poses.csv"], "mtmr")
    assert (plants["rough"].beyond[:3] > plants["as identified"].beyond[:3]).all()
    q = drift_plant.unseen_poses(plants["rough"], 50, 3)
    apart = [plants["rough"].arm.holding(x) - plants["as identified"].arm.holding(x) for x in q]
    assert np.abs(apart)[:, 1].max() > 1e-3


def test_mistakes_are_reported(monkeypatch, tmp_path):
    monkeypatch.setenv("PALPATE_DATA", str(tmp_path))
    with pytest.raises(RecordingError, match="the recordings for the plants are missing"):
        drift.real_arms("mtmr")
    with pytest.raises(RecordingError, match="add --arm mtml or --arm mtmr"):
        Command(recordings=(tmp_path / "a.csv",), figures=tmp_path)()
    with pytest.raises(RecordingError, match="0 releases"):
        Command(releases=0, figures=tmp_path)()
