"""The stubs `palpate/_core.pyi` and `_dvrk.pyi` declare exactly the names of the compiled modules."""

import ast
from pathlib import Path

import pytest

from palpate import _core, _dvrk

PACKAGE = Path(__file__).resolve().parents[2] / "palpate"
STUBS = {
    module: ast.parse((PACKAGE / f"{module.__name__.split('.')[-1]}.pyi").read_text()) for module in (_core, _dvrk)
}
CLASSES = [(module, node) for module, stub in STUBS.items() for node in stub.body if isinstance(node, ast.ClassDef)]


def names(body: list[ast.stmt]) -> set[str]:
    """Public names that a module or class of the stub declares."""
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    fields = {node.target.id for node in body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)}
    return {name for name in functions | fields if not name.startswith("_")}


def public(owner: object) -> set[str]:
    return {name for name in vars(owner) if not name.startswith("_")}


@pytest.mark.parametrize("module", STUBS, ids=lambda module: module.__name__)
def test_stub_declares_all_names_of_a_module(module):
    assert names(STUBS[module].body) == public(module)


@pytest.mark.parametrize(("module", "node"), CLASSES, ids=lambda x: getattr(x, "name", None))
def test_stub_declares_all_names_of_a_class(module, node):
    compiled = getattr(module, node.name)
    assert names(node.body) == public(compiled)
    bases = {base.__name__ for base in compiled.__bases__} - {"object"}
    assert {base.id for base in node.bases} == bases


def test_core_module_has_no_dvrk_names():
    assert not [name for name in vars(_core) if "dvrk" in name.lower()]
