"""Imports a Python file of a user by its path: a driver or a policy."""

from __future__ import annotations

import sys
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType


def import_file(file: Path, kind: str) -> ModuleType:
    """The module in a file, after reading the file; a name of its own, so that it hides no other module.

    Args:
        file: the file.
        kind: what it holds, such as ``driver``: a part of the module's name.

    Raises:
        FileNotFoundError: there is no such file. Exception: whatever the file raises; nothing stays imported then.
    """
    if not file.is_file():
        raise FileNotFoundError(f"there is no file {file}")
    name = f"palpate_{kind}_{file.stem}_{abs(hash(file.resolve())):x}"
    spec = spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{file} is no Python file")
    sys.modules[name] = made = module_from_spec(spec)
    try:
        spec.loader.exec_module(made)
    except BaseException:
        del sys.modules[name]
        raise
    return made
