"""Commands on a scene with several pairs."""

import json
import os
import struct

import numpy as np
import pytest
from two_pairs import TWO

from palpate.cli import main
from palpate.record import Record
from palpate.session import machine


@pytest.fixture
def scene(tmp_path):
    path = tmp_path / "two.yaml"
    path.write_text(TWO)
    return path


def ran(arguments, out):
    assert main([*map(str, arguments), "--json", str(out)]) == 0
    return json.loads(out.read_text())


@pytest.mark.usefixtures("without_figures")
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


@pytest.mark.usefixtures("without_figures")
def test_frames_and_places_are_those_of_all_pairs(scene, tmp_path):
    """What Slicer gets is in tests/trackers/test_openigtlink.py, what a pedal records in tests/session."""
    pytest.importorskip("pyigtl")
    more = ["--openigtlink", "18957", "--record-places", tmp_path / "places.yaml"]
    ran(["run", scene, "--headless", "--duration", "0.1", "--out", tmp_path / "runs", *more],
        tmp_path / "out.json")  # fmt: skip
    assert sorted(file.name for file in tmp_path.glob("places*")) == ["places-left.yaml", "places-right.yaml"]


@pytest.mark.usefixtures("without_figures")
def test_pedals_press_those_of_all_pairs(scene, tmp_path, capsys):
    """A foot switch, as a pipe with events of the kernel, holds the camera pedal during the run."""
    pipe = tmp_path / "pedals"
    os.mkfifo(pipe)
    writer = os.open(pipe, os.O_RDWR)
    os.write(writer, struct.pack("llHHi", 0, 0, 1, 48, 1))  # key B goes down: camera
    command = ["run", scene, "--headless", "--duration", "0.4", "--out", tmp_path / "runs"]
    pedals = ["--pedals", f"footswitch:{pipe}"]
    run = ran([*command, "--realtime", *pedals], tmp_path / "out.json")
    for one in run["pairs"].values():
        states = Record.open(one["record"]).ticks["session_state"]
        assert np.mean(states == machine.NAMES.index("camera")) > 0.5
    assert main([*map(str, command), *pedals]) == 2
    assert "--pedals has no effect in lockstep" in capsys.readouterr().err
    os.close(writer)


def test_a_pair_that_a_loop_of_its_own_drives_is_refused_before_anything_runs(scene, capsys):
    scene.write_text(TWO.replace("leader: {model: mtm_left,", "leader: {driver: loop, model: mtm_left,"))
    assert main(["run", str(scene), "--headless"]) == 2
    assert "pair left: this scene is driven by a loop of your own" in capsys.readouterr().err
    assert main(["run", str(scene), "--headless", "--fast"]) == 2
    assert "pair left is felt on a device" in capsys.readouterr().err
