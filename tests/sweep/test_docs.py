"""The script in docs/studies.md runs unchanged."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

PAGE = Path(__file__).resolve().parents[2] / "docs" / "studies.md"


def test_documented_script_runs(tmp_path):
    (script,) = re.findall(r"```python\n(# my_sweep.py\n.*?)```", PAGE.read_text(), re.S)
    (tmp_path / "my_sweep.py").write_text(script)
    run = subprocess.run([sys.executable, "my_sweep.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert run.returncode == 0, run.stderr
    with netcdf_file(tmp_path / "pressed.nc", mmap=False) as file:
        assert file.variables["peak"].data.shape == (10, 3, 20)
        assert (file.variables["peak"].data > 0).all()
        share = file.variables["oscillates"].data.mean(axis=-1)
        stiffness, delay = file.variables["K"].data[:, None], file.variables["delay"].data
        limit = np.array([np.inf, 1300.0, 700.0])  # between two walls of the page's sentence [N/m]
        assert delay == pytest.approx([0.0, 2e-3, 5e-3])
        assert (share == (stiffness > limit)).all()
    assert (tmp_path / "pressed.csv").read_text().count("\n") == 601
