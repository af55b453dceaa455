"""`palpate study force`: its keys, and force in simulation within 5 % of what pushes."""

import json

import json_contract
import numpy as np

from palpate.cli import main
from palpate.studies.force import work as force


def test_command_without_recordings(tmp_path, capsys):
    """5 % of the largest force, and on no axis more than 5 % of that axis' own range."""
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


def test_score_by_hand():
    """Told 1 N beside the truth on x, always: 1 N of 5 N; x ranges over 4 N."""
    t = np.arange(3000) / 1000.0
    sign = (-1.0) ** np.arange(3000)
    truth = sign[:, None] * [2.0, 1.0, np.sqrt(20.0)]
    found = force.score(force.Trace(t, truth, truth + np.array([1.0, 0.0, 0.0])))
    assert np.isclose(found["nrmse"], 1.0 / 5.0)
    np.testing.assert_allclose(found["nrmse_axis"], [0.25, 0.0, 0.0])
