"""`palpate licenses` names every package that the product imports, and its bill of materials is valid CycloneDX."""

import ast
import json
import sys
from importlib import metadata
from pathlib import Path

import json_contract
import pytest

import palpate
import palpate_lab
from palpate.cli import main
from palpate.cli.commands import _licenses

PACKAGES = [Path(package.__file__).parent for package in (palpate, palpate_lab)]


@pytest.fixture(scope="module")
def found():
    return _licenses.components()


def imported():
    """Names of the packages of others that the sources import."""
    names = set()
    for path in (path for package in PACKAGES for path in package.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
                names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - {"palpate", "palpate_lab"}


#: Modules that only tests, benchmarks or sourced ROS installations have.
ELSEWHERE = {"mujoco", "pinocchio"}


def test_every_imported_package_is_listed(found):
    listed = {_licenses._key(one.name) for one in found}
    owners = metadata.packages_distributions()
    missing = {
        name
        for name in imported() - ELSEWHERE
        if name in owners and not {_licenses._key(one) for one in owners[name]} & listed
    }
    assert missing == set()
    assert {"numpy", "mcap", "eigen", "nanobind", "palpate"} <= listed


def test_licences_of_the_core_are_known(found):
    assert [one.name for one in found if one.needed_by in ("core", "compiled in") and not one.licence] == []
    assert [name for name in _licenses.SILENT if metadata.metadata(name).get("License-Expression")] == []
    by_name = {one.name: one for one in found}
    assert by_name["palpate"].licence == "BSD-3-Clause"
    assert by_name["numpy"].licence == metadata.metadata("numpy")["License-Expression"]


def test_files_have_the_documented_keys(tmp_path, capsys):
    assert main(["licenses", "--json", str(tmp_path / "a.json"), "--sbom", str(tmp_path / "b.json")]) == 0
    listed = json.loads((tmp_path / "a.json").read_text())
    assert set(listed) == json_contract.keys("licenses")
    assert set(listed["components"][0]) == json_contract.keys_of("licenses", "A row of `components`:")
    bom = json.loads((tmp_path / "b.json").read_text())
    assert (bom["bomFormat"], bom["specVersion"]) == ("CycloneDX", "1.5")
    assert len(bom["components"]) == len(listed["components"]) - 1
    assert "palpate" in capsys.readouterr().out


def test_bill_of_materials_is_valid(found):
    validation = pytest.importorskip("cyclonedx.validation.json", reason="cyclonedx-python-lib[json-validation]")
    from cyclonedx.schema import SchemaVersion

    text = json.dumps(_licenses.bill_of_materials(found))
    assert validation.JsonStrictValidator(SchemaVersion.V1_5).validate_str(text) is None
