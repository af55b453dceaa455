"""A network as a condition: the far tool is judged, later, and the same seed gives the same record."""

import numpy as np
import pytest

from palpate.base.errors import PalpateError, SceneError
from palpate.experiment import ExperimentFile
from palpate.experiment.course import judge
from palpate.experiment.plan import plan_of
from palpate.experiment.scenes import Settings
from palpate.experiment.simulated import SimulatedParticipant
from palpate.metrics import summary
from palpate.record import Record


def experiment(folder, condition):
    text = (folder / "small.yaml").read_text()
    (folder / "far.yaml").write_text(text.replace("  force: {}", f"  force: {condition}"))
    return ExperimentFile.load(folder / "far.yaml")


def performed(file, out):
    """Outcome and record of the first trial in the condition `force`."""
    trial = next(one for one in plan_of(file, ("P01",))["P01"] if one.condition == "force")
    settings = Settings(file)
    done = SimulatedParticipant(0, 3, settings).perform(trial, out)
    return done, settings.of(trial.task, "force").course


def test_the_tool_across_the_network_is_judged(folder, tmp_path):
    near, course = performed(experiment(folder, "{}"), tmp_path / "near")
    far, _ = performed(experiment(folder, "{network: netfi-delay-1}"), tmp_path / "far")
    assert (near.outcome.result, far.outcome.result) == ("success", "success")
    assert far.outcome.time_s > near.outcome.time_s + 0.05  # it is seen after both ways
    record = Record.open(far.record)
    assert judge(record, course, remote=True) == far.outcome
    assert judge(record, course).time_s < far.outcome.time_s  # the local tool is there before
    measured = np.linalg.norm(record["F_remote_W"], axis=1).max()
    assert summary(record, remote=True)["peak_force_N"] == pytest.approx(measured)
    assert 0.3 < measured < 3.0


def test_the_same_seed_gives_the_same_record(folder, tmp_path):
    file = experiment(folder, "{network: netfi-loss-2}")
    first, again = (performed(file, tmp_path / name)[0] for name in ("first", "again"))
    one, other = (Record.open(done.record) for done in (first, again))
    for signal in ("p_WT", "p_WR", "F_H_L", "F_remote_W", "remote_age"):
        assert one[signal].tobytes() == other[signal].tobytes()


@pytest.mark.parametrize(
    ("condition", "words"),
    [
        ("{network: wifi}", r"(?s)condition 'force', task .*no network condition is named 'wifi'"),
        ("{network: missing.csv}", r"(?s)condition 'force'.*there is no such file"),
        ("{network: fibre, delay: 0.1}", r"(?s)a network has its own delay.*leave delay or network out"),
    ],
)
def test_a_network_that_does_not_exist_is_told(folder, condition, words):
    with pytest.raises((PalpateError, SceneError), match=words):
        Settings(experiment(folder, condition)).all()
