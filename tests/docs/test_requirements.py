"""The table of requirements: its page is the table, and each row's command parses, its test and its page exist."""

import importlib.util
import re
import sys
from pathlib import Path

import pytest
from cli_words import parse

ROOT = Path(__file__).resolve().parents[2]
ROWS = [*(f"R{k}" for k in range(1, 66)), *(f"B{k}" for k in range(1, 13))]


def load():
    spec = importlib.util.spec_from_file_location("requirements_tool", ROOT / "tools" / "requirements.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


tool = load()


def faults(row):
    """Messages for what a row names and does not exist."""
    if row.state == "open":
        return [] if not (row.command or row.test or row.page) else ["an open row names a command, test or page"]
    found = [] if row.state in tool.STATES else [f"unknown state {row.state}"]
    try:
        parse(["palpate", *row.command.split()])
    except (SystemExit, AssertionError) as error:
        found.append(f"palpate {row.command} is not understood: {error}")
    test = ROOT / "tests" / row.test
    if not test.is_file() or not re.search(r"^\s*def test_", test.read_text(encoding="utf-8"), re.M):
        found.append(f"tests/{row.test} has no test")
    page = ROOT / "docs" / row.page
    if not page.is_file():
        found.append(f"docs/{row.page} does not exist")
    scene = re.fullmatch(r"run (\w+)", row.command)
    if scene and not (ROOT / "scenes" / f"{scene[1]}.yaml").is_file():
        found.append(f"no scene {scene[1]}")
    item = re.fullmatch(r"reproduce (\w+)", row.command)
    if item:
        from palpate_lab.reproduce.catalogue import items

        if row.row not in items()[item[1]].rows and row.row.startswith("R"):
            found.append(f"the item {item[1]} does not name {row.row}")
    return found


def test_every_row_is_there_once():
    assert [row.row for row in tool.rows()] == ROWS


@pytest.mark.parametrize("row", tool.rows(), ids=lambda row: row.row)
def test_command_test_and_page_exist(row, capsys):
    assert faults(row) == []


def test_page_is_made_from_the_table():
    assert tool.PAGE.read_text(encoding="utf-8") == tool.page(), "run: python tools/requirements.py"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"command": "runn wall"}, "not understood"),
        ({"command": "reproduce fig11 --nope"}, "not understood"),
        ({"command": "run no_such_scene"}, "no scene"),
        ({"command": "reproduce eq1"}, "does not name R34"),
        ({"test": "arm/test_nothing.py"}, "has no test"),
        ({"page": "nowhere.md"}, "does not exist"),
        ({"state": "almost"}, "unknown state"),
        ({"state": "open"}, "an open row"),
    ],
)
def test_a_wrong_row_is_found(change, message, capsys):
    from dataclasses import replace

    good = next(row for row in tool.rows() if row.row == "R34")
    assert faults(good) == []
    assert any(message in fault for fault in faults(replace(good, **change)))
