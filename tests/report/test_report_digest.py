"""What a report gathers in one pass is what all ticks give; figures of a long run keep every peak."""

from dataclasses import asdict

import numpy as np
import pytest
import synthetic_run

from palpate.record import Record, Recorder
from palpate.record.ticks import STATUS
from palpate.report import digest as digests
from palpate.report.assumptions import slow_motion, slow_motion_of
from palpate.report.run import Run
from palpate.report.summary import summary_of
from palpate.report.touches import table as touches_table
from palpate.session.rates import recorded
from palpate.session.summary import summarise


@pytest.fixture(scope="module")
def long_run(tmp_path_factory):
    """Three touches of 4 s, with spikes of one tick in what is drawn; and all its ticks."""
    ticks = np.concatenate([synthetic_run.run(4.0) for _ in range(3)])
    ticks["t"] = np.arange(len(ticks)) / 1000.0
    rng = np.random.default_rng(5)
    ticks["status"] = rng.integers(0, 2, len(ticks)) * STATUS["passivity"][0]
    ticks["status"][7001:7100] |= STATUS["too_fast"][0]
    ticks["F_withheld"] = rng.uniform(0, 1, (len(ticks), 7))
    ticks["F_asked"] = rng.uniform(0, 3, (len(ticks), 3))
    for name, at in (("F_cell_L", 1234), ("tau_gravity", 5678), ("energy_damping", 9012), ("F_neglected", 11003)):
        ticks[name].reshape(len(ticks), -1)[at, -1] = 40.0
    path = tmp_path_factory.mktemp("long") / "r.mcap"
    with Recorder(path, "name: floor\n", 0, 1000.0, deterministic=False) as recorder:
        recorder.append(ticks)
    return Record.open(path), ticks


def test_streamed_summary_is_that_of_all_ticks_key_by_key(long_run):
    record, ticks = long_run
    streamed = asdict(summary_of(record))
    known = {key: streamed[key] for key in ("realtime", "instrument", "record", "record_sha256")}
    for key, expected in asdict(summarise(ticks, 1000.0, **known)).items():
        if isinstance(expected, dict):
            assert streamed[key].keys() == expected.keys()
            for name, figures in expected.items():
                assert streamed[key][name] == pytest.approx(figures, rel=1e-12), (key, name)
        else:
            assert streamed[key] == (pytest.approx(expected, rel=1e-12) if isinstance(expected, float) else expected)


def test_a_long_run_has_the_numbers_of_all_ticks(long_run, monkeypatch):
    record, ticks = long_run
    short = Run(record)
    assert short.ticks.shape == ticks.shape
    monkeypatch.setattr(digests, "MOST", 1000)
    monkeypatch.setattr(digests, "INTERVALS", 12)
    run = Run(record)
    assert len(run.ticks) < len(ticks) / 4
    assert (np.diff(run.t) > 0).all()
    cells = [np.linalg.norm(found["F_cell_L"], axis=1) for found in (run.ticks, ticks)]
    assert (cells[0].min(), cells[0].max()) == (cells[1].min(), cells[1].max())
    for name in ("F_H_L", "tau_gravity", "energy_damping", "F_neglected", "depth", "p_WT"):
        drawn, every = run.ticks[name], ticks[name]
        np.testing.assert_array_equal(drawn.min(axis=0), every.min(axis=0), name)
        np.testing.assert_array_equal(drawn.max(axis=0), every.max(axis=0), name)
    assert run.touches == short.touches
    assert len(run.touches) == 3
    assert [phase.name for phase in run.phases] == [phase.name for phase in short.phases]
    for end in ("start", "end"):
        found, expected = ([getattr(phase, end) for phase in one.phases] for one in (run, short))
        assert found == pytest.approx(expected, abs=1e-9)
    assert {phase.name for phase in run.phases} >= {"approach", "slide", "leave"}
    pressed = ticks["depth"] > 0
    depth, force = ticks["depth"][pressed], ticks["F_spring_W"][pressed, 2]
    assert run.stiffness == pytest.approx(float(depth @ force / (depth @ depth)))
    assert slow_motion_of(run.digest) == slow_motion(ticks, 1000.0)
    assert run.digest.touched.table(["tip"], ["floor"], 1000.0) == touches_table(ticks, ["tip"], ["floor"], 1000.0)
    assert run.digest.rates.rows("", 1000.0, None) == recorded("", ticks, 1000.0, None)
    for name, (bit, _) in STATUS.items():
        assert run.digest.status[name] == int(((ticks["status"] & np.uint64(bit)) != 0).sum())


def test_sliding_in_parts_is_that_of_the_whole(long_run, monkeypatch):
    record, _ = long_run
    whole = Run(record).phases
    monkeypatch.setattr("palpate.report.run._PART", 173)
    assert Run(record).phases == whole
