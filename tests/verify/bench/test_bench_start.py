"""The JSON of `palpate bench start` and `palpate bench simulate` has the documented keys. No timing is asserted."""

import json_contract
from rich.console import Console

from palpate.scene import shipped
from palpate_lab.verify.bench import simulate, start

SCENE = "objects: [{name: ball, sphere: {radius: 0.04}, stiffness: 300}]\nrecord: {report: false}\n"


def test_keys_of_start_and_its_table(tmp_path):
    scene = tmp_path / "ball.yaml"
    scene.write_text(SCENE)
    progress = []
    result = start.run(1, scene, on_progress=progress.append)
    assert set(result) == json_contract.keys("bench start")
    assert set(result["seconds"]) == {"help_s", "first_tick_s", "check_s", "control_s"}
    assert len(progress) == 2
    Console(width=120, record=True, quiet=True).print(start.table(result))
    assert shipped.file("palpation").is_file()


def test_simulate_has_the_documented_keys_and_equal_numbers(tmp_path):
    scene = tmp_path / "ball.yaml"
    scene.write_text(SCENE)
    result = simulate.run(4, 0.3, 1, scene)
    assert set(result) == json_contract.keys("bench simulate")
    assert result["identical"] is True
    assert result["share"] > 0.0
    Console(width=120, record=True, quiet=True).print(simulate.table(result))
