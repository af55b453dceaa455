"""`palpate bench network`, and `palpate run` of the scene that starts both ends: two processes and a relay."""

import json

import pytest

from palpate.cli import main
from palpate_lab.verify.bench import network as bench

pytest.importorskip("cryptography", reason="links need the extra remote")


@pytest.mark.long
def test_both_ends_are_measured_beside_forged_packets_of_which_none_is_accepted(tmp_path):
    file = tmp_path / "n.json"
    assert main(["bench", "network", "--seconds", "2", "--flood", "3000", "--json", str(file)]) == 0
    found = json.loads(file.read_text())
    control, linked, filmed, flooded = found["rows"]
    assert control["follower_ticks"] is None
    assert linked["follower_ticks"] > 500
    assert filmed["run"] == "linked, video"
    assert filmed["follower_ticks"] > 500
    assert linked["refused"] < 10  # the last ones, after the end
    assert flooded["refused"] > 500
    assert linked["accepted_forged"] == flooded["accepted_forged"] == 0
    assert bench.table(found).row_count == 4


@pytest.mark.long
def test_the_scene_remote_runs_both_ends_by_one_command(tmp_path, capsys):
    file = tmp_path / "r.json"
    code = main(["run", "remote", "--headless", "--duration", "2", "--out", str(tmp_path), "--json", str(file)])
    assert code == 0, capsys.readouterr()
    found = json.loads(file.read_text())["remote"]
    assert found["received"] > 200
    assert 0.2 < 1e-3 * found["round_trip_ms"] < 0.5
    assert found["models"][0]["object"] == "liver"
