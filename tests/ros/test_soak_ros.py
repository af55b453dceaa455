"""`palpate soak ros`: its judge on given rows, and a few seconds of robot, node and hand that continue a log."""

import json
from dataclasses import asdict, replace

import json_contract
import numpy as np
import pytest

from palpate.base.errors import PalpateError
from palpate.cli import main
from palpate_lab.verify.soak import ros as soak

GOOD = soak.Row(1, 7200.0, 3_600_500, 3_600_000, 0, 0, 2000, 30, 0.5, dict.fromkeys(soak.PARTS, 100.0))


def rows(slope=0.0, **last):
    """Two hours of rows; the memory of haptics grows by `slope` [MB/h], and the last row has these fields."""
    out = [replace(GOOD, t_s=float(t), memory_MB=GOOD.memory_MB | {"haptics": 100.0 + slope * t / 3600.0})
           for t in np.arange(60.0, 7201.0, 60.0)]  # fmt: skip
    return [*out[:-1], replace(out[-1], **last)]


@pytest.mark.parametrize(
    ("spoiled", "words"),
    [
        (rows(), []),
        (rows(2.0), []),  # 4 MB in all
        (rows(10.0), ["the memory of haptics grows by 10.0 MB/h"]),
        (rows(touches=0), ["the hand never felt the wall"]),
        (rows(ended=True), ["a process ended by itself in segment 1, after 7200 s"]),
        (rows(wrenches=3_500_000), ["100000 states without a wrench, of 3600000"]),
        (rows(lines=1000), ["1000 lines printed in 2.00 h"]),
    ],
)
def test_judge_finds_each_kind_of_wrong(spoiled, words):
    assert soak.judge(spoiled, 50.0).wrong == words


def test_segments_add_up_and_missed_ticks_count_against_the_rate():
    both = [*rows(), *(replace(row, segment=2, states=row.states - 500) for row in rows())]
    done = soak.judge(both, 50.0)
    assert (done.segments, done.hours) == (2, 4.0)
    assert (done.wrenches, done.expected, done.missed, done.touches) == (7_201_000, 7_199_500, 500, 4000)


def test_line_that_was_cut_off_is_ignored_and_another_file_is_refused(tmp_path):
    log = tmp_path / "soak.jsonl"
    whole = json.dumps(asdict(GOOD)) + "\n"
    log.write_text(whole + whole[:40])
    assert soak.read(log) == [GOOD]
    assert log.read_text() == whole, "the next row begins a new line"
    log.write_text("t, force\n1, 2\n")
    with pytest.raises(PalpateError, match="line 1 is no row of a soak"):
        soak.read(log)
    with pytest.raises(PalpateError, match="hours must be above 0"):
        soak.run(0.0, log)


def test_a_few_seconds_continue_a_log(built, tmp_path, capsys):
    log, file = tmp_path / "soak.jsonl", tmp_path / "soak.json"
    before = replace(GOOD, t_s=3600.0, states=1_800_000, wrenches=1_800_000)
    log.write_text(json.dumps(asdict(before)) + "\n")
    hours = 1.0 + 4.0 / 3600.0
    assert main(["soak", "ros", "--hours", str(hours), "--interval", "1", "--log", str(log), "--json", str(file)]) == 0
    done = json.loads(file.read_text())
    assert set(done) == json_contract.keys("soak ros")
    assert done["segments"] == 2
    assert done["hours"] >= hours
    added = soak.read(log)[-1]
    assert (added.segment, added.ended) == (2, False)
    assert 4.0 <= added.t_s < 60.0
    assert added.touches >= 1
    assert added.wrenches > 0.5 * soak.RATE * added.t_s
    assert min(added.memory_MB.values()) > 10.0
    assert "touches" in capsys.readouterr().out
    assert main(["soak", "ros", "--hours", "1", "--log", str(log)]) == 0, "nothing left to run"
