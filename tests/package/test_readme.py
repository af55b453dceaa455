"""The Python examples of README.md run; one of them is a session in real time."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def test_readme_example_runs(tmp_path):
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.S)
    if not blocks:
        pytest.skip("README.md has no python block yet")
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    for block in blocks:
        script = tmp_path / "readme.py"
        script.write_text(block)
        run = subprocess.run(
            [sys.executable, script],
            cwd=tmp_path,
            env={**os.environ, "MPLBACKEND": "Agg"},
            capture_output=True,
            text=True,
            timeout=120,
        )
        assert run.returncode == 0, run.stderr
