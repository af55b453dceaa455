"""`palpate study force`: its keys, and simulated force estimates within 5 % of the applied force."""

import json

import json_contract
import numpy as np

from palpate.cli import main
from palpate_lab.studies.force import work as force


def test_command_without_recordings(tmp_path, capsys):
    """The error is below 5 % of the largest force, and on each axis below 5 % of its range."""
    folder = str(tmp_path / "pictures")
    assert main(["study", "force", "--json", "-", "--figures", folder, "--data", str(tmp_path)]) == 0
    out = capsys.readouterr()
    found = json.loads(out.out)
    assert "the study of the weight is skipped" in out.err
    assert set(found) == {"weight", "simulated"} <= json_contract.keys("study force")
    assert set(found["simulated"]) <= json_contract.keys_of("study force", "|")
    assert found["simulated"]["nrmse"] < 0.05
    assert max(found["simulated"]["nrmse_axis"]) < 0.05
    assert (tmp_path / "pictures" / "force.png").stat().st_size > 10_000


def test_score_agrees_with_a_manual_result():
    """A constant error of 1 N on x: 1 N of 5 N, and x has a range of 4 N."""
    t = np.arange(3000) / 1000.0
    sign = (-1.0) ** np.arange(3000)
    truth = sign[:, None] * [2.0, 1.0, np.sqrt(20.0)]
    found = force.score(force.Trace(t, truth, truth + np.array([1.0, 0.0, 0.0])))
    assert np.isclose(found["nrmse"], 1.0 / 5.0)
    np.testing.assert_allclose(found["nrmse_axis"], [0.25, 0.0, 0.0])
