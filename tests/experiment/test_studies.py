"""The shipped experiments can run: their scenes, their plans, and one simulated participant each."""

from pathlib import Path

import numpy as np
import pytest

from palpate.experiment import ExperimentFile, plan_of, simulate
from palpate.experiment.scenes import Settings

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("experiment_*.yaml"))


@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_a_shipped_experiment_is_sound(file):
    experiment = ExperimentFile.load(file)
    assert experiment.measures[0] != "success"
    settings = Settings(experiment)
    made = settings.all()
    first = next(iter(experiment.tasks))
    assert len({setting.scene.model_dump_json() for (task, _), setting in made.items() if task == first}) > 1
    assert len(plan_of(experiment, experiment.people)) == len(experiment.people)
    for setting in made.values():
        assert np.isfinite(setting.course.path).all()
        if setting.course.normal is None:
            clear = [surface.nearest(setting.course.path) for surface in settings.rig(setting).surfaces]
            gaps = [((setting.course.path - q) * n).sum(axis=1).min() for q, n in clear]
            assert min(gaps) > setting.scene.contact.radius, "a path in free space touches nothing"


@pytest.mark.long
@pytest.mark.parametrize("file", EXAMPLES, ids=lambda file: file.stem)
def test_a_simulated_participant_does_every_trial(file, tmp_path):
    study = simulate(ExperimentFile.load(file), 1, tmp_path / "data", workers=1)
    done = study.progress("S01")
    assert len(done.ended) == len(study.plan["S01"])
    assert done.aborted == []
    assert np.mean([event["result"] == "success" for event in done.ended.values()]) > 0.5
