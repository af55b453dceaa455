"""C++ files include only lower layers, and without cycles.

The order is defined here. A stage reads another stage's result through `types`, never through its headers.
"""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

STAGES = ("mapping", "guidance", "contact", "force", "stability", "torque")
LAYERS = (
    ("types",),
    ("arm", "scene"),
    ("clouds", "tissue"),
    STAGES,
    ("plant",),
    ("loop", "dvrk"),
    ("collision", "haply", "network", "reference", "verify"),
    ("bindings",),
)
"""Lowest first. Folders of one layer do not include each other."""
LEVEL = {folder: level for level, folders in enumerate(LAYERS) for folder in folders}

_INCLUDE = re.compile(r'^\s*#\s*include\s+"([^"]+)"', re.MULTILINE)
_SOURCES = {".hpp", ".cpp", ".inl"}


def includes(root: Path) -> dict[str, list[str]]:
    """Each C++ file below `root` with the project's files that it includes, all relative to `root`."""
    files = [p for top in ("core", "simulators", "bindings") for p in sorted((root / top).rglob("*")) if p.is_file()]
    found: dict[str, list[str]] = {}
    for path in (p for p in files if p.suffix in _SOURCES):
        names = _INCLUDE.findall(path.read_text(encoding="utf-8"))
        found[str(path.relative_to(root))] = [t for t in (_resolve(root, path, name) for name in names) if t]
    return found


def _resolve(root: Path, path: Path, name: str) -> str | None:
    for folder in (root / "core", root / "simulators", path.parent):
        if (folder / name).is_file():
            return str((folder / name).resolve().relative_to(root.resolve()))
    return None


def folder_of(file: str) -> str:
    """Folder of a file that belongs to a layer, such as `loop` for `core/palpate/loop/tick.hpp`."""
    parts = Path(file).parts
    return parts[2] if parts[0] == "core" else parts[1] if parts[0] == "simulators" else parts[0]


def uphill(graph: dict[str, list[str]]) -> list[str]:
    """Messages for includes of another folder in the same or a higher layer."""
    return [
        f"{file} ({own}) includes {other} ({theirs})"
        for file, others in graph.items()
        for other in others
        if (own := folder_of(file)) != (theirs := folder_of(other)) and LEVEL[theirs] >= LEVEL[own]
    ]


def circle(graph: dict[str, list[str]]) -> list[str]:
    """Files of an include cycle, with the first one repeated at the end; empty without a cycle."""
    done: set[str] = set()
    trail: list[str] = []

    def visit(file: str) -> list[str]:
        if file in trail:
            return [*trail[trail.index(file) :], file]
        if file in done:
            return []
        trail.append(file)
        for other in graph.get(file, []):
            if found := visit(other):
                return found
        trail.pop()
        done.add(file)
        return []

    return next((found for file in graph if (found := visit(file))), [])


def test_every_include_is_of_a_lower_layer():
    graph = includes(ROOT)
    assert len(graph) > 200
    assert sum(map(len, graph.values())) > 300
    assert {folder_of(file) for file in graph} <= LEVEL.keys(), "a folder has no layer: add it to LAYERS"
    assert uphill(graph) == []


def test_there_is_no_include_cycle():
    assert circle(includes(ROOT)) == []


def tree(root: Path, **files: str) -> dict[str, list[str]]:
    for name, include in files.items():
        path = root / "core/palpate" / name.replace("__", "/")
        path = path.with_suffix(".hpp")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f'#pragma once\n#include "palpate/{include}.hpp"\n' if include else "#pragma once\n")
    return includes(root)


@pytest.mark.parametrize(
    ("includer", "included"),
    [("guidance__law", "loop/tick"), ("force__force", "contact/contact"), ("types__status", "scene/mesh")],
)
def test_include_of_the_same_or_a_higher_layer_is_found(tmp_path, includer, included):
    graph = tree(tmp_path, **{includer: included, included.replace("/", "__"): ""})
    (message,) = uphill(graph)
    assert f"core/palpate/{included}.hpp" in message
    assert circle(graph) == []


def test_include_of_a_lower_layer_passes(tmp_path):
    graph = tree(tmp_path, loop__cycle="torque/law", torque__law="types/status", types__status="")
    assert sum(map(len, graph.values())) == 2
    assert uphill(graph) == []


def test_include_cycle_within_a_folder_is_found(tmp_path):
    graph = tree(tmp_path, scene__mesh="scene/bvh", scene__bvh="scene/weld", scene__weld="scene/mesh")
    assert uphill(graph) == []
    found = circle(graph)
    assert len(found) == 4
    assert found[0] == found[-1]
