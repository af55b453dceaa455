"""The order of layers (pyproject.toml, import-linter), and no import cycles of files or folders; lazy imports count."""

import ast
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp
import pytest
from importlinter.cli import lint_imports

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"palpate": ROOT / "palpate", "palpate_lab": ROOT / "lab" / "palpate_lab"}
CONTRACT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"]["contracts"][0]


def circles(package: str) -> list[list[str]]:
    """Import cycles of files, and of files and folders in each folder, without the root, which imports all parts."""
    graph = grimp.build_graph(package, cache_dir=None)
    files = {m: graph.find_modules_directly_imported_by(m) - {package} for m in graph.modules - {package}}
    found = [_circle(files)]
    for folder in sorted(graph.modules):
        depth, inside = folder.count(".") + 2, folder + "."
        parts: dict[str, set[str]] = {}
        for file, others in files.items():
            if file.startswith(inside):
                part = _first(file, depth)
                parts.setdefault(part, set()).update(
                    {_first(o, depth) for o in others if o.startswith(inside)} - {part}
                )
        found.append(_circle(parts))
    return [circle for circle in found if circle]


def _first(module: str, depth: int) -> str:
    return ".".join(module.split(".")[:depth])


def _circle(graph: Mapping[str, Iterable[str]]) -> list[str]:
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def from_the_root(source: str) -> set[str]:
    """Names that a file takes from the root: `from palpate import x`, or `palpate.x` after `import palpate`."""
    tree = list(ast.walk(ast.parse(source)))
    taken = {name.name for n in tree if isinstance(n, ast.ImportFrom) and n.module == "palpate" for name in n.names}
    used = {n.attr for n in tree if isinstance(n, ast.Attribute) and getattr(n.value, "id", "") == "palpate"}
    return taken | used


def test_imports_only_go_down_the_layers():
    assert lint_imports(str(ROOT / "pyproject.toml"), no_cache=True, no_logo=True) == 0


@pytest.mark.parametrize("package", PACKAGES)
def test_there_are_no_import_cycles_of_files_or_folders(package):
    assert circles(package) == []


def test_rooms_of_the_product_and_the_arrows_between_them_stay_few():
    """A room is a folder of the package, an arrow an import between two of them; those for type checkers count."""
    graph = grimp.build_graph("palpate", cache_dir=None)
    rooms = {f"palpate.{path.name}" for path in PACKAGES["palpate"].iterdir() if (path / "__init__.py").is_file()}
    arrows = {
        (_first(module, 2), _first(other, 2))
        for module in graph.modules
        for other in graph.find_modules_directly_imported_by(module)
        if {_first(module, 2), _first(other, 2)} <= rooms and _first(module, 2) != _first(other, 2)
    }
    assert len(rooms) <= 18
    assert len(arrows) <= 110


def test_architecture_lists_every_room_with_the_first_sentence_of_its_docstring():
    table = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    for package in PACKAGES.values():
        for file in package.glob("*/__init__.py"):
            sentence = (ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "").splitlines()[0]
            assert f"| `{file.parent.name}` | {sentence.replace('``', '`')} |" in table


def test_parts_of_the_package_import_only_modules_from_the_root():
    """A graph of modules does not show names that a part imports from the root, such as `palpate.Session`."""
    parts = {path.name.removesuffix(".py") for path in (ROOT / "palpate").iterdir()}
    for path in (path for folder in PACKAGES.values() for path in folder.rglob("*.py")):
        others = (
            from_the_root(path.read_text(encoding="utf-8"))
            - parts
            - {"_collision", "_core", "_dvrk", "_guidance", "_haply", "_network", "_reference", "_tissue", "_verify"}
            - {"__version__", "__file__"}
        )
        assert path == ROOT / "palpate" / "__init__.py" or not others, f"{path}: {others}"


def sample_package(folder: Path, name: str, files: Mapping[str, str], monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package with an empty part for every layer and some files, and its contract; returns the contract's file."""
    layers = [layer.replace("|", " ").split() for layer in CONTRACT["layers"]]
    for path in ["", *(f"{part}/" for layer in layers for part in layer)]:
        (folder / name / path).mkdir(parents=True)
        (folder / name / path / "__init__.py").touch()
    for path, source in files.items():
        (folder / name / path).write_text(source.replace("palpate", name))
    contract = folder / "contract.toml"
    contract.write_text(
        f'[tool.importlinter]\nroot_package = "{name}"\n[[tool.importlinter.contracts]]\nname = "layers"\n'
        f'type = "layers"\ncontainers = ["{name}"]\nlayers = {CONTRACT["layers"]}\nexhaustive = true\n'
        f'ignore_imports = ["{name}.** -> {name}"]\nunmatched_ignore_imports_alerting = "none"\n'
    )
    monkeypatch.syspath_prepend(folder)
    return contract


@pytest.mark.parametrize(
    ("uphill", "kept"),
    [
        ("def f():\n    from palpate.scene import text\n", False),
        ("from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from palpate.scene import text\n", False),
        ("from palpate.base.errors import PalpateError\n", True),
    ],
)
def test_import_of_a_higher_layer_is_found(tmp_path, monkeypatch, uphill, kept):
    name = f"made_up_{abs(hash(uphill))}"
    files = {"arm/arm.py": uphill, "scene/text.py": "", "base/errors.py": "class PalpateError(Exception): ...\n"}
    contract = sample_package(tmp_path, name, files, monkeypatch)
    assert (lint_imports(str(contract), no_cache=True, no_logo=True) == 0) == kept


@pytest.mark.parametrize(
    ("files", "circle"),
    [
        ({"arm/a.py": "from palpate.arm import b\n", "arm/b.py": "def f():\n    import palpate.arm.a\n"}, "arm.a"),
        ({"scene/a.py": "from palpate.arm import b\n", "arm/b.py": "", "arm/c.py": "from palpate.scene import d\n",
          "scene/d.py": ""}, "scene"),
        ({"scene/a.py": "from palpate.arm import b", "arm/b.py": "", "arm/c.py": "from palpate.arm import b"}, None),
    ],
)  # fmt: skip
def test_import_cycle_is_found(tmp_path, monkeypatch, files, circle):
    name = f"made_up_{abs(hash(str(files)))}"
    sample_package(tmp_path, name, files, monkeypatch)
    found = circles(name)
    assert bool(found) == (circle is not None)
    assert circle is None or all(f"{name}.{circle}" in one for one in found)


def test_import_of_a_root_name_is_found():
    assert from_the_root("import palpate\ndef f():\n    return palpate.Session\n") == {"Session"}
    assert from_the_root("from palpate import Scene, _core\n") == {"Scene", "_core"}


def test_test_modules_have_names_of_their_own():
    """Pytest imports test modules by their names alone: of two with one name, only one can be collected."""
    names = Counter(path.name for path in (ROOT / "tests").rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []
