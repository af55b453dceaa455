"""Shells complete what the commands take: the words equal those of the help texts, and bash itself completes them."""

import re
import shutil
import subprocess
from importlib import import_module

import pytest

import palpate.cli
from palpate.cli import _completion, main
from palpate.cli._folder import entries


@pytest.fixture(scope="module")
def table():
    return _completion.words_after()


def is_command(words):
    """True for a command, False for a group of commands."""
    packages, module = palpate.cli.MEMBERS, None
    for word in words.split()[1:]:
        module = import_module(entries(packages)[word].module)
        packages = getattr(module, "MEMBERS", (module.__name__,))
    return hasattr(module, "Command")


def described_options(words, capsys):
    """The options at the beginning of the lines of a command's help text."""
    with pytest.raises(SystemExit):
        main([*words.split()[1:], "--help"])
    return set(re.findall(r"^[│ ] (?:-h, )?(--[\w-]+)", capsys.readouterr().out, re.M))


def test_every_command_has_the_options_of_its_help(table, capsys):
    commands = {key for key in table if key != "palpate" and is_command(key)}
    assert len(commands) > 60
    for key, row in table.items():
        words = {word for word, _ in row}
        assert words == (described_options(key, capsys) if key in commands else words), key


def complete(script, tmp_path, *words):
    """What bash offers after these words, the last of which is being typed."""
    file = tmp_path / "script"
    file.write_text(script)
    typed = " ".join(f"'{word}'" for word in words)
    code = f'source {file}; COMP_WORDS=({typed}); COMP_CWORD={len(words) - 1}; _palpate; echo "${{COMPREPLY[@]}}"'
    run = subprocess.run(["bash", "-c", code], capture_output=True, text=True, check=True, cwd=tmp_path)
    assert run.stderr == ""
    return set(run.stdout.split())


def test_bash_completes_commands_options_and_files(capsys, tmp_path):
    assert main(["completion", "bash"]) == 0
    script = capsys.readouterr().out
    (tmp_path / "mine.yaml").touch()
    assert complete(script, tmp_path, "palpate", "rep") == {"replay", "report", "reproduce"}
    assert complete(script, tmp_path, "palpate", "register", "po") == {"points"}
    assert "--duration" in complete(script, tmp_path, "palpate", "run", "palpation", "--du")
    assert complete(script, tmp_path, "palpate", "run", "mi") == {"mine.yaml"}
    assert complete(script, tmp_path, "palpate", "nonsense", "po") == set()


def test_fish_and_zsh_get_a_line_for_each_word(capsys, table):
    assert main(["completion", "fish"]) == 0
    lines = capsys.readouterr().out.splitlines()[1:]
    assert len(lines) == sum(map(len, table.values()))
    assert all(re.match(r"complete -c palpate -n ", line) for line in lines)
    assert main(["completion", "zsh"]) == 0
    assert "bashcompinit" in capsys.readouterr().out


@pytest.mark.parametrize("shell", ["zsh", "fish"])
def test_the_shell_itself_reads_the_script(shell, tmp_path, table):
    if shutil.which(shell) is None:
        pytest.skip(f"{shell} is not installed")
    file = tmp_path / "script"
    file.write_text(_completion.script(shell))
    assert subprocess.run([shell, "-n", str(file)], capture_output=True, check=False).returncode == 0
