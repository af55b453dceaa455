"""Version, public names, models and scenes of the package."""

import re
import tomllib
from pathlib import Path

import pytest

import palpate

ROOT = Path(__file__).resolve().parents[2]


def test_version_is_that_of_the_project_file():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert palpate.__version__ == project["version"]
    assert f"## {palpate.__version__}" in (ROOT / "CHANGELOG.md").read_text()


def test_public_names_exist():
    for name in palpate.__all__:
        assert getattr(palpate, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'Sessoin'"):
        palpate.Sessoin  # noqa: B018


def test_package_contains_models_and_scenes():
    """CMake installs both folders into the package; the wheel itself is built in test_wheel.py."""
    cmake = (ROOT / "CMakeLists.txt").read_text()
    assert re.search(r"install\(DIRECTORY models scenes DESTINATION palpate\b", cmake)
    for name in ("mtm_right", "mtm_left", "psm_lnd", "psm_prograsp"):
        assert (ROOT / "models" / f"{name}.urdf").is_file()
        assert (ROOT / "models" / f"{name}.yaml").is_file()
