"""The labelled file, read back by scipy and, where it is installed, by xarray."""

import csv

import numpy as np
import pytest
import sweep_points
from scipy.io import netcdf_file

from palpate.base.errors import OutputError, SweepError
from palpate.base.sweep import Axis, Label, sweep


@pytest.fixture(scope="module")
def swept():
    grid = {"K": Axis([1.0, 2.5], "N/m", "stiffness"), "k": [0, 1, 2], "law": ["paper", "ä"]}
    labels = {"yes": Label("1", "whether it did")}
    return sweep(sweep_points.rich, grid, 3, "serial", labels=labels, where=lambda p: p["k"] < 2 or p["law"] == "paper")


def test_dimensions_units_and_values(swept, tmp_path):
    swept.to_netcdf(tmp_path / "a.nc")
    with netcdf_file(tmp_path / "a.nc", mmap=False) as file:
        found = file.variables
        assert file.dimensions["K"] == 2
        assert found["K"].units == b"N/m"
        assert found["K"].long_name == b"stiffness"
        assert found["K"].data.tolist() == [1.0, 2.5]
        assert found["k"].data.dtype.kind == "i"
        assert [b"".join(row).rstrip(b"\0").decode() for row in found["law"].data] == ["paper", "ä"]
        assert found["list"].dimensions == ("K", "k", "law", "list_0")
        assert found["list"].data[1, 0, 1].tolist() == [1.0, 2.5]
        assert found["by_cap_5"].data[0, 1, 0] == 0.5
        assert np.isnan(found["by_cap_50"].data).all()
        assert found["yes"].long_name == b"whether it did"
        assert b"".join(found["word"].data[0, 2, 0]) == b"wavywavy"
        assert file.seed == 3
        assert file.fn == b"sweep_points.rich"
        assert file.version.startswith(b"palpate 0.")


def test_absent_points_are_blank(swept):
    assert np.isnan(swept.array("yes")[:, 2, 1]).all()
    assert np.isnan(swept.array("yes")[0]).all()  # None
    assert (swept.array("yes")[1, :2] == 1.0).all()
    assert swept.array("word")[0, 2, 1] == ""


def test_xarray_opens_it(swept, tmp_path):
    xarray = pytest.importorskip("xarray", reason="xarray is not installed; scipy reads the file back above")
    swept.to_netcdf(tmp_path / "a.nc")
    with xarray.open_dataset(tmp_path / "a.nc") as data:
        assert data["list"].sel(K=2.5, k=1, law="ä").values.tolist() == [1.0, 2.5]
        assert data["K"].attrs["units"] == "N/m"
        assert data.attrs["seed"] == 3


def test_csv_table(swept, tmp_path):
    swept.to_csv(tmp_path / "a.csv")
    rows = list(csv.DictReader((tmp_path / "a.csv").open(encoding="utf-8")))
    assert len(rows) == 10
    assert rows[-1] == {"K": "2.5", "k": "2", "law": "paper", "list_0": "1.0", "list_1": "2.5", "by cap_5": "0.5",
                        "by cap_50": "", "word": "wavywavy", "yes": "True"}  # fmt: skip


def test_write_errors(swept, tmp_path):
    with pytest.raises(OutputError, match="the file cannot be written"):
        swept.to_netcdf(tmp_path / "none" / "a.nc")
    clash = sweep(sweep_points.draw, {"K": [1.0], "law": ["a"], "x": [1]}, executor="serial")
    with pytest.raises(SweepError, match=r"\['x'\] name both an axis and a value"):
        clash.to_netcdf(tmp_path / "a.nc")
    assert list(tmp_path.iterdir()) == []
