"""Files and functions stay small. Their complexity is held by ruff (C901 in pyproject.toml)."""

import ast
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[2]


def test_files_and_functions_stay_small():
    files, functions = [], []
    for path in (*(ROOT / "palpate").rglob("*.py"), *(ROOT / "lab").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        files.append(len(text.splitlines()))
        nodes = (n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef | ast.AsyncFunctionDef))
        functions += [n.end_lineno - n.lineno + 1 for n in nodes]
    assert np.quantile(files, 0.95) <= 250
    assert np.quantile(functions, 0.95) <= 27
    assert max(functions) <= 65  # a screen
