"""Commands are found by listing folders, without importing them."""

import subprocess
import sys
from importlib import import_module
from typing import Annotated, Union, get_args, get_origin

import pytest

import palpate.cli
from palpate.cli._folder import _joined, _of_many, _typing_union, _with_typing_unions, entries


def test_files_are_commands_and_folders_are_groups_or_commands_in_parts(tmp_path, monkeypatch):
    root = tmp_path / "listed_commands"
    for path, text in {
        "__init__.py": "",
        "_hidden.py": "",
        "plain.py": 'class Command:\n    """Does one thing.\n\n    More.\n    """\n',
        "import_.py": 'raise RuntimeError("is never imported")\nclass Command:\n    """Imports."""\n',
        "parts/command.py": 'class Command:\n    """Has parts."""\n',
        "group/__init__.py": '"""A group.\n\nMore."""\n',
        "data/table.txt": "",
    }.items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(text)
    monkeypatch.syspath_prepend(tmp_path)
    found = entries(["listed_commands"], first=("plain", "import"))
    assert {name: entry.summary for name, entry in found.items()} == {
        "plain": "Does one thing.", "import": "Imports.", "group": "A group.", "parts": "Has parts.",
    }  # fmt: skip
    assert list(found) == ["plain", "import", "group", "parts"]
    assert found["parts"].module == "listed_commands.parts.command"


@pytest.mark.parametrize(
    "package",
    ["palpate.cli", "palpate_lab.commands.bench", "palpate.cli.commands.calibrate", "palpate.cli.commands.ros"],
)
def test_every_command_has_a_summary_and_can_be_called(package):
    group = import_module(package)
    first = group.FIRST
    found = entries(getattr(group, "MEMBERS", (package,)), first)
    assert set(first) <= set(found)
    for name, entry in found.items():
        assert entry.summary, name
        module = import_module(entry.module)
        if hasattr(module, "Command"):
            assert callable(module.Command)
            assert module.Command.__call__.__doc__
        else:
            assert entries(getattr(module, "MEMBERS", (module.__name__,)))


def test_annotated_unions_become_those_of_typing_although_typing_caches_them():
    hint = Annotated[float | None, "a description"]
    made = _typing_union(hint)
    assert get_origin(get_args(made)[0]) is Union
    assert get_args(made)[1] == "a description"


def test_an_option_of_many_words_that_is_repeated_keeps_all_of_them():
    from palpate.cli.commands.export.records import Command

    args = ["run.mcap", "--signals", "A", "B", "--to", "csv", "--signals", "C", "--signals=D"]
    assert "--signals" in _of_many(_with_typing_unions(Command))
    assert _joined(args, {"--signals"}) == ["run.mcap", "--to", "csv", "--signals", "A", "B", "C", "D"]


def test_a_leader_or_a_fault_that_is_repeated_is_not_the_last_one_alone(capsys):
    drivers = ["--leader", "right=simulated", "--leader", "left=simulated:free"]
    assert palpate.cli.main(["run", *drivers, "wall"]) == 2
    assert "--leader is given 2 times, and the scene has one hand" in capsys.readouterr().err
    assert palpate.cli.main(["device", "stand-in", "haply", "--fault", "sleap", "--fault", "hang"]) == 2
    assert "there is no fault 'sleap'" in capsys.readouterr().err


def test_listing_imports_no_command():
    code = (
        "import sys\nimport palpate.cli\nfrom palpate.cli._folder import entries\n"
        "found = entries((*palpate.cli.MEMBERS, 'palpate_lab.studies'))\n"
        "assert all(e.summary for e in found.values())\n"
        "print(*(m for m in sys.modules if m.startswith(('palpate.cli.', 'palpate_lab.', 'numpy', 'scipy'))))"
    )
    output = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout
    ours = {"palpate.cli._folder", "palpate.cli._overview", "palpate.cli.terminal"}
    found = {name for name in output.split() if not name.startswith("palpate.cli.terminal.")}
    assert found == ours
    assert {"run", "bench"} <= set(entries(palpate.cli.MEMBERS))
