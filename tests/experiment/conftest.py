from pathlib import Path

import pytest
from small_experiment import FILE, SCENE

from palpate.experiment import ExperimentFile


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder with a small experiment and its scene."""
    (tmp_path / "table.yaml").write_text(SCENE)
    (tmp_path / "small.yaml").write_text(FILE)
    return tmp_path


@pytest.fixture
def small(folder) -> ExperimentFile:
    return ExperimentFile.load(folder / "small.yaml")
