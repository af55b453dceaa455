"""What Rerun and Foxglove open: an .rrd that Rerun verifies, and a layout whose paths a record has."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
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
