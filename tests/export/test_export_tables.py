"""Tables hold every tick bit for bit, read by other tools: pandas, pyarrow, scipy, h5py, xarray."""

import os
import sys
import tracemalloc

import numpy as np
import pytest
from crtk_bag import write as write_bag

from palpate.base.errors import OutputError, PalpateError, RecordError
from palpate.export import export
from palpate.export.export import formats
from palpate.record import SIGNALS

pytest.importorskip("pyarrow", reason="pyarrow (extra learning) is not installed")
h5py = pytest.importorskip("h5py", reason="h5py (extra learning) is not installed")


def test_csv_and_parquet_hold_the_bits_that_pandas_reads(make, tmp_path):
    import pandas as pd

    made = make()
    for kind, read in (("csv", pd.read_csv), ("parquet", pd.read_parquet)):
        facts = export(made.path.parent, tmp_path / kind, to=kind)
        assert facts["files"] == [f"a run.{kind}"]
        assert facts["rows"] == [len(made.ticks)]
        table = read(tmp_path / kind / f"a run.{kind}")
        assert table.columns[0] == "t [s]"
        np.testing.assert_array_equal(table["t [s]"], made.ticks["t"])
        for k, axis in enumerate("xyz"):
            np.testing.assert_array_equal(table[f"F_T_W.{axis} [N]"], made.ticks["F_T_W"][:, k])
        np.testing.assert_array_equal(table["depth [m]"], made.ticks["depth"])
        assert table["status"].dtype.kind in "iu"


def test_columns_of_parquet_say_what_they_are(make, tmp_path):
    import pyarrow.parquet as pq

    export(make().path, tmp_path / "out", to="parquet", signals=("F_T_W",), every=10)
    table = pq.read_table(tmp_path / "out" / "a run.parquet")
    assert table.column_names == ["t [s]", "F_T_W.x [N]", "F_T_W.y [N]", "F_T_W.z [N]"]
    about = table.schema.field("F_T_W.x [N]").metadata
    assert (about[b"unit"], about[b"frame"]) == (b"N", b"W")
    assert about[b"doc"].decode() == SIGNALS["F_T_W"].doc
    assert table.schema.metadata[b"rate_Hz"] == b"100"
    assert table.num_rows == 50


def test_matlab_file_holds_signals_and_units(make, tmp_path):
    from scipy.io import loadmat

    made = make()
    export(made.path, tmp_path / "out", to="mat")
    found = loadmat(tmp_path / "out" / "a run.mat", squeeze_me=True, simplify_cells=True)
    for name in ("t", "F_T_W", "p_WT", "depth", "q", "touch_force"):
        np.testing.assert_array_equal(found[name], made.ticks[name])
    assert found["units"]["F_T_W"] == "N"
    assert found["frames"]["F_T_W"] == "W"
    assert found["about"]["rate_Hz"] == "1000"


def test_hdf5_is_what_xarray_and_h5py_read(make, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray (test group) is not installed")
    made = make()
    export(made.path, tmp_path / "out", to="hdf5")
    with h5py.File(tmp_path / "out" / "a run.h5") as file:
        np.testing.assert_array_equal(file["F_T_W"], made.ticks["F_T_W"])
        assert file["F_T_W"].attrs["units"] == "N"
    with xarray.open_dataset(tmp_path / "out" / "a run.h5", engine="h5netcdf") as data:
        assert data["F_T_W"].dims == ("t", "xyz")
        np.testing.assert_array_equal(data["F_T_W"].sel(t=0.25, method="nearest"), made.ticks["F_T_W"][250])


def test_long_records_need_constant_memory(make, tmp_path):
    made = make(seconds=20.0)
    sizes = {}
    for every in (20, 1):
        tracemalloc.start()
        export(made.path, tmp_path / f"out{every}", to="csv", signals=("F_T_W",), every=every)
        sizes[every] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert sizes[1] < 8e6


def test_names_with_spaces_and_equal_names_keep_their_files_apart(make, tmp_path):
    made = make("a run")
    facts = export([made.path, made.path.parent], tmp_path / "of two", to="csv", signals=("depth",))
    assert facts["files"] == ["a run.csv", "a run-2.csv"]
    assert sorted(os.listdir(tmp_path / "of two")) == ["a run-2.csv", "a run.csv"]


def test_a_name_that_is_given_already_is_not_given_again(make, tmp_path):
    paths = [make(name).path for name in ("same", "other/same", "other/same-2")]
    facts = export(paths, tmp_path / "out", to="csv", signals=("depth",))
    assert facts["files"] == ["same.csv", "same-2.csv", "same-2-2.csv"]
    assert len(os.listdir(tmp_path / "out")) == 3


def test_a_folder_of_several_runs_is_no_run_of_several_pairs(make, tmp_path):
    for name in ("runs/one", "runs/two"):
        make(name)
    with pytest.raises(RecordError, match=r"records \(one, two\), and no scene.yaml with pairs"):
        export(tmp_path / "runs", tmp_path / "out", to="csv")
    (tmp_path / "runs/scene.yaml").write_text("pairs: {two: {}, one: {}}\n")
    facts = export(tmp_path / "runs", tmp_path / "out", to="csv", signals=("depth",))
    assert facts["files"] == ["runs-psm1.csv", "runs-psm2.csv"]


def test_a_full_disk_leaves_nothing_behind(make, tmp_path, monkeypatch):
    import resource
    import signal

    made = make()
    limits, handler = resource.getrlimit(resource.RLIMIT_FSIZE), signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, limits[1]))
        monkeypatch.setattr(sys, "dont_write_bytecode", True)  # the limit would cut off a compiled module
        for kind in ("csv", "parquet", "mat", "lerobot"):
            with pytest.raises(OutputError, match="cannot be written"):
                export(made.path, tmp_path / "out", to=kind)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert sorted(os.listdir(tmp_path)) == ["a run"]


def test_a_folder_that_holds_something_is_not_touched(make, tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")
    with pytest.raises(OutputError, match="not empty"):
        export(make().path, tmp_path / "out", to="csv")
    assert os.listdir(tmp_path / "out") == ["mine.txt"]
    (tmp_path / "empty").mkdir()
    export(tmp_path / "a run", tmp_path / "empty", to="csv", signals=("depth",))
    assert os.listdir(tmp_path / "empty") == ["a run.csv"]


def test_formats_come_from_other_packages_too(make, tmp_path, monkeypatch):
    (tmp_path / "site" / "mine-1.0.dist-info").mkdir(parents=True)
    (tmp_path / "site" / "mine-1.0.dist-info" / "entry_points.txt").write_text("[palpate.exporters]\nlines = mine:go\n")
    (tmp_path / "site" / "mine-1.0.dist-info" / "METADATA").write_text(
        "Metadata-Version: 2.1\nName: mine\nVersion: 1.0\n"
    )
    (tmp_path / "site" / "mine.py").write_text(
        "def go(runs, folder, options):\n"
        "    (folder / 'n.txt').write_text(str(len(runs[0].arms[0].ticks)))\n    return {'rows': [1]}\n"
    )
    monkeypatch.syspath_prepend(tmp_path / "site")
    assert "lines" in formats()
    facts = export(make().path, tmp_path / "out", to="lines")
    assert (tmp_path / "out" / "n.txt").read_text() == "500"
    assert facts["rows"] == [1]
    sys.modules.pop("mine")


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ({"to": "parket"}, PalpateError, "did you mean parquet"),
        ({"to": "csv", "signals": ("F_T_w",)}, RecordError, "does not hold F_T_w"),
        ({"to": "csv", "every": 0}, PalpateError, "at least 1"),
        ({"to": "minari", "fps": 0}, PalpateError, "0 frames/s"),
        ({"to": "minari", "fps": 1}, RecordError, "one frame at 1 Hz, and no action"),
    ],
)
def test_mistakes_are_named(make, tmp_path, given, error, words):
    if given["to"] == "minari":
        pytest.importorskip("minari", reason="minari (extra learning) is not installed")
    with pytest.raises(error, match=words):
        export(make().path, tmp_path / "out", **given)
    assert not (tmp_path / "out").exists()


def test_bag_of_a_real_arm_becomes_a_table(tmp_path):
    from scipy.io import loadmat

    bag = write_bag(tmp_path / "bag")
    export(bag, tmp_path / "out", to="mat")
    found = loadmat(tmp_path / "out" / "bag.mat", squeeze_me=True)
    assert np.ptp(found["q"][:, 0]) > 0.05
    assert np.isfinite(found["F_H_L"]).any()


@pytest.mark.parametrize("to", ["minari", "csv", "lerobot"])
def test_a_relative_folder_with_spaces_is_written(make, tmp_path, monkeypatch, to):
    if to == "minari":
        pytest.importorskip("minari", reason="minari (extra learning) is not installed")
    made = make()
    monkeypatch.chdir(tmp_path)
    export([made.path.relative_to(tmp_path)], "a data set", to=to)
    assert any(path.is_file() for path in (tmp_path / "a data set").rglob("*"))
    assert not list(tmp_path.glob(".*part*"))


def test_minari_reads_what_is_exported(make, tmp_path, monkeypatch):
    minari = pytest.importorskip("minari", reason="minari (extra learning) is not installed")
    made = make()
    facts = export([made.path] * 2, tmp_path / "out", to="minari")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "out"))
    data = minari.load_dataset(facts["dataset"])
    assert data.total_episodes == 2
    episode = next(iter(data.iterate_episodes()))
    at = [round(k * 1000 / 30) for k in range(15)]
    np.testing.assert_allclose(episode.observations["force"][:, :3], made.ticks["F_T_W"][at], atol=1e-6)
    np.testing.assert_allclose(episode.actions[:, :3], made.ticks["p_WT_goal"][at[:-1]], atol=1e-7)
