import json

import pytest
from json_contract import keys

SCENE = """
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, damping: 1}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, -0.001]}]}
"""


def test_certify_writes_report_and_figure(palpate, tmp_path):
    scene, out, picture = tmp_path / "wall.yaml", tmp_path / "c.json", tmp_path / "c.png"
    scene.write_text(SCENE)
    done = palpate("certify", scene, "--json", out, "--figure", picture)
    assert done.code == 0, done.err
    assert "table: stable: no delay at 1000 Hz, 10.6 ms of the follower's servo and 1 N s/m" in done.out
    assert "with other hands: stable below relaxed" in done.out
    report = json.loads(out.read_text())
    assert {"k_max_N_per_m", "verdict", "reason", "margin"} <= set(report)
    assert set(report) == keys("certify")
    assert report["verdict"] == "stable"
    assert picture.stat().st_size > 5000


@pytest.mark.usefixtures("without_figures")
def test_run_warns_of_an_unstable_scene(palpate, tmp_path):
    scene = tmp_path / "wall.yaml"
    scene.write_text(SCENE + "loop_delay: 0.04\n")
    assert "table: unstable: 40 ms of delay" in palpate("certify", scene).out
    done = palpate("run", scene, "--headless", "--duration", "0.1", "--out", tmp_path)
    assert done.code == 0
    assert "table: unstable: 40 ms of delay at 1000 Hz" in done.err
    assert "stable below" in done.err
