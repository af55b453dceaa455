"""Commands on a scene with several pairs."""

import json

import pytest

from palpate.cli import main

TWO = """\
objects: [{shape: organ, triangles: 3000, stiffness: 300, damping: 2}]
pairs:
  right:
    arms:
      leader: {base: {xyz: [0.345, 0.243, 0.219], rpy_deg: [0, 0, -20]}}
      follower: {base: {xyz: [0.060, -0.060, 0.155], rpy_deg: [0, 0, 155]}}
    operator: {palpate: {at: [0.03, -0.012, 0.1], length: 0.01}}
  left:
    arms:
      leader: {model: mtm_left, base: {xyz: [-0.345, 0.243, 0.219], rpy_deg: [0, 0, 20]}}
      follower: {base: {xyz: [-0.120, -0.060, 0.155], rpy_deg: [0, 0, 205]}}
    operator: {palpate: {at: [-0.035, -0.012, 0.1], length: 0.002}}
"""


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(TWO)
    return path


def ran(arguments, out):
    assert main([*map(str, arguments), "--json", str(out)]) == 0
    return json.loads(out.read_text())


def test_run_report_check_and_certify_speak_of_every_pair(scene, tmp_path, capsys):
    out = tmp_path / "out.json"
    run = ran(["run", scene, "--headless", "--duration", "0.3", "--out", tmp_path / "runs"], out)
    assert list(run["pairs"]) == ["right", "left"]
    assert run["pairs"]["right"]["ticks"] == 300
    assert run["instruments"]["momentum_error_N_s"] == 0.0
    assert "handles closest" in capsys.readouterr().out
    report = ran(["report", run["record"]], out)
    assert report["pairs"]["left"]["record_sha256"] == run["pairs"]["left"]["record_sha256"]
    check = ran(["check", scene], out)
    assert check["instruments_apart_m"] > 0.0
    assert check["pairs"]["left"]["objects"][0]["name"] == "organ"
    certify = ran(["certify", scene], out)
    alone, both = certify["pairs"]["right"], certify["pairs"]["right"]["with_instrument"]
    assert both["K_N_per_m"] == alone["K_N_per_m"] + both["K_instrument_N_per_m"] == 800.0


@pytest.mark.parametrize("arguments", [["--openigtlink", "18944"]])
def test_options_of_one_pair_are_refused(scene, arguments, capsys):
    assert main(["run", str(scene), "--headless", *arguments]) == 2
    assert "the scene has several" in capsys.readouterr().err


def test_a_pair_with_a_driver_is_refused_before_anything_runs(scene, capsys):
    scene.write_text(TWO.replace("leader: {model: mtm_left,", "leader: {driver: loop, model: mtm_left,"))
    assert main(["run", str(scene), "--headless"]) == 2
    assert "pair left is felt on a device" in capsys.readouterr().err
