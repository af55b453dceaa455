"""Every `palpate` command that README, docs and the help texts print is understood as printed: its options exist and
take the printed values. (`tests/ros/test_printed_commands.py` runs those of ROS 2.)"""

import re
import shlex
from pathlib import Path

import pytest
from cli_words import parse

ROOT = Path(__file__).resolve().parents[2]
#: Commands of packages that a block would install are not known here.
BLOCK = re.compile(r"^( *)```bash(?! not run: it installs)[^\n]*\n(.*?)^\1```", re.MULTILINE | re.DOTALL)
EXAMPLE = re.compile(r"^ +(?:[A-Z_]+=\S+ +)*(palpate .*)$", re.MULTILINE)
END = re.compile(r"\s(?:#|&&|\||>|2>|&)(?:\s|$).*")


def commands():
    """(place, words) of each printed command."""
    found = {}
    for page in [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        for _, block in BLOCK.findall(page.read_text(encoding="utf-8")):
            for line in block.replace("\\\n", " ").splitlines():
                if match := re.match(r"\s*(?:[A-Z_]+=\S+ +)*(palpate .*)", line):
                    found.setdefault(" ".join(END.sub("", match[1]).split()), page.name)
    for file in sorted([*(ROOT / "palpate").rglob("*.py"), *(ROOT / "lab").rglob("*.py")]):
        text = file.read_text(encoding="utf-8")
        for part in re.findall(r"^ *examples:\n(.*?)(?:\n\s*\n|\"\"\")", text, re.MULTILINE | re.DOTALL):
            for line in EXAMPLE.findall(part.replace("\\\n", " ")):
                found.setdefault(" ".join(END.sub("", line).split()), file.relative_to(ROOT).as_posix())
    return sorted(found.items())


def variants(line):
    """The command without and with its optional part, and with each of alternatives a|b."""
    lines = [re.sub(r"\[[^\]]*\]", "", line), re.sub(r"[\[\]]", "", line)] if " [--" in line else [line]
    for one in lines:
        words = shlex.split(one)
        k = next((k for k, word in enumerate(words) if re.fullmatch(r"[a-z]+(\|[a-z]+)+", word)), None)
        for choice in words[k].split("|") if k is not None else [None]:
            yield words if k is None else [*words[:k], choice, *words[k + 1 :]]


@pytest.mark.parametrize(
    "words", ["palpate run wall --nope", "palpate ros sim --rate fast", "palpate runn", "palpate fuzz x"]
)
def test_a_wrong_command_is_not_understood(words):
    with pytest.raises((SystemExit, AssertionError)):
        parse(words.split())


def test_commands_are_found():
    assert len(commands()) > 100


@pytest.mark.parametrize(("line", "place"), commands())
def test_printed_command_is_understood(line, place, capsys):
    for words in variants(line):
        if "..." in words:  # stands for arguments of the reader's own
            continue
        try:
            parse(words)
        except SystemExit as end:
            pytest.fail(f"{place}: {line}\n{capsys.readouterr().err or end}")
