"""Decides whether the code of a driver that a scene names may be loaded: what is installed, or what the user trusts.

A scene is data that people exchange. Only code that somebody has installed in this environment runs by its name alone;
a file beside the scene runs when the user says so (`--trust`, ``Scene.load(path, trust=True)``). Nothing here imports
the code in question.
"""

from __future__ import annotations

import ast
import json
import site
import sysconfig
from importlib.machinery import SOURCE_SUFFIXES
from importlib.metadata import Distribution, distributions
from importlib.util import find_spec
from pathlib import Path
from urllib.parse import unquote, urlsplit

from palpate.base.errors import DeviceError
from palpate.base.plugins import source

GROUP = "palpate.drivers"
"""Group of entry points by which a distribution offers drivers."""


def require_trust(name: str, trust: bool) -> None:
    """Check that the code of a driver may be loaded.

    Args:
        name: ``MODULE:CLASS``, ``FILE.py:CLASS`` or ``FILE.so``.
        trust: True if the user trusts the code that the scene names.

    Raises:
        DeviceError: the code is neither trusted nor installed.
    """
    if trust or is_installed(name):
        return
    what = f"driver {name!r} is code, which a scene may not run by naming it"
    why = "it is not installed in this environment, so that anybody who sends a scene could have written it"
    mend = "read it, then allow it: palpate run or check with --trust, Scene.load(path, trust=True); or install it"
    raise DeviceError(what, why=why, mend=mend)


def is_installed(name: str) -> bool:
    """True for an entry point of the group `palpate.drivers`, or a class in a module of an installed distribution."""
    module, _, cls = name.partition(":")
    if not all(part.isidentifier() for part in module.split(".")) or module.endswith(("__main__", ".py")):
        return False
    if module.startswith("palpate.devices."):
        return True
    folders = _installed_folders()
    found = list(distributions(path=[str(folder) for folder in folders]))
    for one in found:
        if any(point.group == GROUP and point.value.replace(" ", "") == name for point in one.entry_points):
            return _is_what_imports(module, [*folders, *_project_of(one)])
    return _in_distribution(module, cls, folders, found)


def _in_distribution(module: str, cls: str, folders: list[Path], found: list[Distribution]) -> bool:
    """True if a file of an installed distribution states the class; a function, for example, is no driver."""
    file = source(module, folders)
    if file is None or not _is_what_imports(module, folders):
        return False
    owned = any(Path(str(one.locate_file(entry))) == file for one in found for entry in one.files or ())
    return owned and (file.suffix not in SOURCE_SUFFIXES or _states(file, cls))


def _is_what_imports(module: str, folders: list[Path]) -> bool:
    """True if an import of the module takes it from these folders, not from another one in front of them."""
    try:
        spec = find_spec(module.partition(".")[0])
    except (ImportError, ValueError, AttributeError):
        return False
    origin = None if spec is None else spec.origin
    return origin is not None and any(Path(origin).resolve().is_relative_to(folder) for folder in folders)


def _states(file: Path, cls: str) -> bool:
    """True if a class of this name is defined at the top of a source file, or a name as of classes is imported."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError):
        return False
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and node.name == cls:
            return True
        if (
            isinstance(node, ast.ImportFrom)
            and cls[:1].isupper()
            and any((alias.asname or alias.name) == cls for alias in node.names)
        ):
            return True
    return False


def _installed_folders() -> list[Path]:
    """Folders into which distributions of this environment are installed; neither PYTHONPATH nor the present folder."""
    named = [*site.getsitepackages(), *(sysconfig.get_path(key) for key in ("purelib", "platlib"))]
    if site.ENABLE_USER_SITE:
        named.append(site.getusersitepackages())
    return list(dict.fromkeys(Path(one).resolve() for one in named))


def _project_of(one: Distribution) -> list[Path]:
    """Folder of a distribution that is installed as editable."""
    try:
        told = json.loads(one.read_text("direct_url.json") or "{}")
        editable = told["dir_info"]["editable"] is True
    except (ValueError, KeyError, TypeError):
        return []
    return [Path(unquote(urlsplit(str(told["url"])).path)).resolve()] if editable else []
