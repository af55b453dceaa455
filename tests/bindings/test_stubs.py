"""The committed stubs are what the generator prints for the compiled extensions, and say what each call returns."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

from palpate import _core, _dvrk, _guidance, _tissue, _verify

ROOT = Path(__file__).resolve().parents[2]
STUBS = {
    module: ast.parse((ROOT / f"{module.__name__.replace('.', '/')}.pyi").read_text())
    for module in (_core, _dvrk, _guidance, _tissue, _verify)
}
CLASSES = [(module, node) for module, stub in STUBS.items() for node in stub.body if isinstance(node, ast.ClassDef)]


def names(body: list[ast.stmt]) -> set[str]:
    """Public names that a module or class of the stub declares."""
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    fields = {node.target.id for node in body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)}
    members = {t.id for node in body if isinstance(node, ast.Assign) for t in node.targets if isinstance(t, ast.Name)}
    return {name for name in functions | fields | members if not name.startswith("_")}


def public(owner: object) -> set[str]:
    return {name for name in vars(owner) if not name.startswith("_")}


def test_they_are_up_to_date():
    run = subprocess.run([sys.executable, ROOT / "tools" / "stubs.py", "--check"], capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.mark.parametrize("module", STUBS, ids=lambda module: module.__name__)
def test_stub_declares_all_names_of_a_module(module):
    assert names(STUBS[module].body) == public(module)


@pytest.mark.parametrize(("module", "node"), CLASSES, ids=lambda x: getattr(x, "name", None))
def test_stub_declares_all_names_of_a_class(module, node):
    compiled = getattr(module, node.name)
    assert names(node.body) == public(compiled)
    bases = {base.__name__ for base in compiled.__bases__} - {"object"}
    assert {ast.unparse(base).split(".")[-1] for base in node.bases} == bases


@pytest.mark.parametrize("module", STUBS, ids=lambda module: module.__name__)
def test_results_are_typed(module):
    """A bare `tuple`, `list`, `dict` or `object` says nothing: bindings name the types inside (bindings/types.hpp)."""
    functions = [node for node in ast.walk(STUBS[module]) if isinstance(node, ast.FunctionDef)]
    bare = [f.name for f in functions if f.returns and ast.unparse(f.returns) in ("tuple", "list", "dict", "object")]
    assert not [name for name in bare if not name.startswith("__")]


def test_core_module_has_no_dvrk_names():
    assert not [name for name in vars(_core) if "dvrk" in name.lower()]
