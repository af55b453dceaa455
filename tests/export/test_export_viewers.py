"""What Rerun and Foxglove open: an .rrd that Rerun verifies, and a layout whose paths a record has."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from crtk_bag import write as write_bag
from mcap.reader import make_reader

from palpate.cli import main

ROOT = Path(__file__).resolve().parents[2]


def test_rerun_verifies_and_prints_what_is_written(make, tmp_path, monkeypatch, capsys):
    pytest.importorskip("rerun", reason="rerun-sdk, of 0.7 GB, is not installed")
    made = make()
    out = tmp_path / "my run.rrd"
    assert main(["replay", str(made.path), "--to", "rerun", "--out", str(out)]) == 0
    assert "my run.rrd" in capsys.readouterr().out
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a run", "my run.rrd"]
    subprocess.run([sys.executable, "-m", "rerun", "rrd", "verify", str(out)], check=True, capture_output=True)
    told = subprocess.run(
        [sys.executable, "-m", "rerun", "rrd", "print", str(out)], check=True, capture_output=True, text=True
    ).stdout
    for name in ("/force/F_T_W", "/stability/F_H_L", "/world/tool", "/world/force", "/world/floor", "/world/path"):
        assert name in told, name
    rows = [int(n) for n in re.findall(r"with (\d+) rows [^\n]* - /force/F_T_W ", told)]
    assert sum(rows) == len(made.ticks)


def _printed(file, *words):
    command = [sys.executable, "-m", "rerun", "rrd", "print", *words, str(file)]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_rerun_shows_the_scene_that_is_given(make, tmp_path):
    """A bag's poses are in the base of its arm: the scene gives the objects and the base."""
    pytest.importorskip("rerun", reason="rerun-sdk, of 0.7 GB, is not installed")
    scene = tmp_path / "other.yaml"
    text = "arms: {leader: {model: mtm_right}, follower: {model: psm_lnd, base: {xyz: [0.05, 0, 0.15]}}}\n"
    scene.write_text(text + "objects: [{name: table, plane: {size: 0.2}, stiffness: 500}]\n")
    bag, out = write_bag(tmp_path / "bag", posed=True), tmp_path / "out.rrd"
    assert main(["replay", str(bag), "--to", "rerun", "--scene", str(scene), "--out", str(out)]) == 0
    assert "/world/table" in _printed(out)
    path = _printed(out, "-vvv", "--entity", "/world/path")
    (x, y, z), *_ = [[float(v) for v in one] for one in re.findall(r"\[(-?[\d.]+), (-?[\d.]+), (-?[\d.]+)\]", path)]
    np.testing.assert_allclose([x, y, z], [0.05, 0.02, 0.05], atol=2e-4)
    record, out = make().path, tmp_path / "record.rrd"
    assert main(["replay", str(record), "--to", "rerun", "--scene", str(scene), "--out", str(out)]) == 0
    assert "/world/table" in _printed(out)
    assert "/world/floor" not in _printed(out)


def test_rerun_that_is_not_installed_is_named(make, tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "rerun", None)
    assert main(["replay", str(make().path), "--to", "rerun", "--out", str(tmp_path / "a.rrd")]) == 2
    assert "pip install rerun-sdk" in capsys.readouterr().err
    assert not (tmp_path / "a.rrd").exists()


def test_paths_of_the_foxglove_layout_are_in_a_record(make):
    layout = json.loads((ROOT / "docs/layouts/foxglove.json").read_text())
    panels = set(re.findall(r'"(\w+!\w+)"', json.dumps(layout["layout"])))
    assert panels == set(layout["configById"])
    values = [path["value"] for panel in layout["configById"].values() for path in panel.get("paths", ())]
    assert len(values) > 8
    with make().path.open("rb") as file:
        summary = make_reader(file).get_summary()
    texts = {}
    for channel in summary.channels.values():
        texts.setdefault(channel.topic, []).append(summary.schemas[channel.schema_id].data.decode())
    for value in values:
        topic, field, *part = value.split(".")
        lines = [line for text in texts[topic] for line in text.splitlines() if line.split()[1:2] == [field]]
        assert lines, value
        assert not part or lines[0].startswith("geometry_msgs/Vector3"), value
    assert {"/scene/objects", "/scene/arms"} == set(layout["configById"]["3D!palpate"]["topics"])
