"""`palpate/_core.pyi` names what the compiled module offers, no more and no less."""

import ast
from pathlib import Path

import pytest

from palpate import _core

STUB = ast.parse((Path(__file__).resolve().parents[2] / "palpate" / "_core.pyi").read_text())
CLASSES = {node.name: node for node in STUB.body if isinstance(node, ast.ClassDef)}


def names(body: list[ast.stmt]) -> set[str]:
    """What a module or class of the stub declares, without its underscored names."""
    functions = {node.name for node in body if isinstance(node, ast.FunctionDef | ast.ClassDef)}
    fields = {node.target.id for node in body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)}
    return {name for name in functions | fields if not name.startswith("_")}


def public(thing: object) -> set[str]:
    return {name for name in vars(thing) if not name.startswith("_")}


def test_the_module():
    assert names(STUB.body) == public(_core)


@pytest.mark.parametrize("name", sorted(CLASSES))
def test_a_class(name):
    compiled = getattr(_core, name)
    assert names(CLASSES[name].body) == public(compiled)
    bases = {base.__name__ for base in compiled.__bases__} - {"object"}
    assert {base.id for base in CLASSES[name].bases} == bases
