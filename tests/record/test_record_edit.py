"""Parts of a record, joined records and repaired ones hold the same bits, for Palpate and for stock readers."""

import json

import json_contract
import numpy as np
import pytest
import synthetic_run
from mcap.reader import make_reader

from palpate import Record, Session
from palpate.base.errors import RecordError
from palpate.cli import main
from palpate.record import Recorder, as_rows
from palpate.record.edit import copy
from palpate.scene import Scene
from palpate_lab.verify.bench import record

SCENE = """
objects:
  - {name: ball, sphere: {radius: 0.03}}
operator: {palpate: {object: ball, at: [0, 0, 0.1], force: 1.0, length: 0.01}}
"""


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    with Session(Scene.parse(SCENE), out=tmp_path_factory.mktemp("runs")) as session:
        return Record.open(session.run(2.0).record)


def topics(path):
    with path.open("rb") as file:
        found = {}
        for _, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            found.setdefault(channel.topic, []).append(message.log_time)
        return found


def test_cut_holds_the_ticks_of_its_span_and_the_meshes(run, tmp_path, capsys):
    out = tmp_path / "part.mcap"
    command = ["record", "cut", str(run.path), "--start", "0.7", "--end", "1.61", "--out", str(out)]
    assert main(command) == 0
    assert "910 ticks from 0.700 to 1.609 s" in capsys.readouterr().out
    part = Record.open(out)
    assert part.complete
    assert part.scene == run.scene
    assert as_rows(part.ticks).tobytes() == as_rows(run.ticks[700:1610]).tobytes()
    found = topics(out)
    assert {"/tf", "/scene/objects", "/leader/robot_description"} <= set(found)
    assert min(min(times) for times in found.values()) >= 700_000_000
    assert len(found["/loop"]) == 910


def test_join_of_two_parts_is_the_whole(run, tmp_path):
    copy([run.path], tmp_path / "a.mcap", stop=1.234)
    copy([run.path], tmp_path / "b.mcap", start=1.234)
    assert (
        main(["record", "join", str(tmp_path / "a.mcap"), str(tmp_path / "b.mcap"), "--out", str(tmp_path / "c.mcap")])
        == 0
    )
    assert as_rows(Record.open(tmp_path / "c.mcap").ticks).tobytes() == as_rows(run.ticks).tobytes()
    assert topics(tmp_path / "c.mcap")["/tf"] == topics(run.path)["/tf"]
    with pytest.raises(RecordError, match="before the end of the one before"):
        copy([tmp_path / "b.mcap", tmp_path / "a.mcap"], tmp_path / "d.mcap")


def test_repaired_record_is_complete_for_every_reader(run, tmp_path, capsys):
    data = run.path.read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(data[: int(0.8 * len(data))] + bytes(5000))
    broken = Record.open(cut)
    assert not broken.complete
    assert main(["record", "repair", str(cut), "--out", str(tmp_path / "whole.mcap")]) == 0
    assert "had no end" in capsys.readouterr().out
    whole = Record.open(tmp_path / "whole.mcap")
    assert whole.complete
    assert as_rows(whole.ticks).tobytes() == as_rows(run.ticks[: len(whole)]).tobytes()
    assert len(whole) == len(broken) > 1000
    assert len(topics(tmp_path / "whole.mcap")["/follower"]) == len(whole)


def test_info_tells_span_size_and_signals(run, tmp_path, capsys):
    assert main(["record", "info", str(run.path)]) == 0
    text = capsys.readouterr().out
    assert "2.000 s from 0.000 to 1.999 s, 2,000 ticks" in text
    assert "1000 Hz" in text
    assert "F_H_L" in text


def test_keys_of_info_are_the_documented_ones(run, tmp_path):
    assert main(["record", "info", str(run.path), "--json", str(tmp_path / "i.json")]) == 0
    found = json.loads((tmp_path / "i.json").read_text())
    assert set(found) == json_contract.keys("record info")
    assert (found["ticks"], found["complete"], found["duration_s"]) == (2000, True, pytest.approx(2.0))


def test_keys_of_the_bench_are_the_documented_ones():
    assert set(record.Figures.__annotations__) == json_contract.keys("bench record")


def test_a_record_is_not_written_over_itself(run):
    with pytest.raises(Exception, match="overwrite itself"):
        copy([run.path], run.path)


def test_parts_of_an_incomplete_record_with_growing_layouts_join(tmp_path):
    ticks = synthetic_run.run(3.0)
    with Recorder(tmp_path / "r.mcap", "", 0, 1000.0, True) as recorder:
        recorder.append(ticks)
    copy([tmp_path / "r.mcap"], tmp_path / "a.mcap", stop=0.5)
    copy([tmp_path / "r.mcap"], tmp_path / "b.mcap", start=0.5)
    copy([tmp_path / "a.mcap", tmp_path / "b.mcap"], tmp_path / "c.mcap")
    for name in ("depth", "normal", "F_T_W", "q", "status", "touch_force"):
        np.testing.assert_array_equal(Record.open(tmp_path / "c.mcap")[name], ticks[name])
