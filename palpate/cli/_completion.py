"""Scripts by which shells complete commands and options: tables of the words that may follow each command."""

from __future__ import annotations

import dataclasses
import shlex
from collections.abc import Iterator
from importlib import import_module
from typing import Any, get_type_hints

_BASH = """\
# Completion of palpate for bash{more}. Made by: palpate completion {shell}
{before}_palpate() {{
  local command="palpate" word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    [[ $word == -* ]] && break
    case "$command $word" in
{commands}
        command+=" $word" ;;
      *) # an argument of a command, or no command
        [[ $command == palpate ]] && command="unknown"
        break ;;
    esac
  done
  local words=""
  case "$command" in
{words}
  esac
  COMPREPLY=($(compgen -W "$words" -- "${{COMP_WORDS[COMP_CWORD]}}"))
  [[ ${{COMP_WORDS[COMP_CWORD]}} == -* ]] || COMPREPLY+=($(compgen -f -- "${{COMP_WORDS[COMP_CWORD]}}"))
}}
complete -o filenames -F _palpate palpate
"""


def words_after() -> dict[str, list[tuple[str, str]]]:
    """Names of commands, or options, that may follow a command, each with its description.

    The keys are commands as they are typed, such as ``palpate register points``; the first is ``palpate``.
    """
    import palpate.cli

    return dict(_walk(palpate.cli, "palpate"))


def script(shell: str) -> str:
    """The script for bash, zsh or fish."""
    table = words_after()
    if shell == "fish":
        return _fish(table)
    commands = "|\\\n".join(f"      {shlex.quote(key)}" for key in table if key != "palpate") + ")"
    words = "\n".join(
        f"    {shlex.quote(key)}) words={shlex.quote(' '.join(word for word, _ in row))} ;;"
        for key, row in table.items()
    )
    zsh = shell == "zsh"
    return _BASH.format(
        shell=shell,
        more=" by zsh's bashcompinit" if zsh else "",
        before="autoload -U +X bashcompinit && bashcompinit\n" if zsh else "",
        commands=commands,
        words=words,
    )


def _walk(module: Any, prog: str) -> Iterator[tuple[str, list[tuple[str, str]]]]:
    from palpate.cli._folder import all_entries

    if hasattr(module, "Command"):
        yield prog, _options(module.Command)
        return
    members = all_entries(module)
    yield prog, [(name, entry.summary) for name, entry in members.items()]
    for name, entry in members.items():
        yield from _walk(import_module(entry.module), f"{prog} {name}")


def _options(command: type[Any]) -> list[tuple[str, str]]:
    """The options of a command as they are typed. Arguments without a name are not among them."""
    hints = get_type_hints(command, include_extras=True)
    typed = [("--help", "describe the command")]
    for field in dataclasses.fields(command):
        marks = getattr(hints[field.name], "__metadata__", ())
        if any("positional" in str(mark).lower() for mark in marks):
            continue
        given = next((mark.name for mark in marks if getattr(mark, "name", None)), None)
        switched_off = "no-" if field.default is True else ""
        typed.append((f"--{switched_off}{(given or field.name).replace('_', '-')}", ""))
    return typed


def _fish(table: dict[str, list[tuple[str, str]]]) -> str:
    lines = ["# Completion of palpate for fish. Made by: palpate completion fish"]
    for key, row in table.items():
        before = key.split()[1:]
        seen = [f"__fish_seen_subcommand_from {word}" for word in before]
        names = [word for word, _ in row if not word.startswith("-")]
        if names:
            seen.append(f"not __fish_seen_subcommand_from {' '.join(names)}")
        condition = shlex.quote("; and ".join(seen) or "true")
        for word, words in row:
            what = f"-l {word[2:]}" if word.startswith("--") else f"-f -a {word}"
            lines.append(f"complete -c palpate -n {condition} {what} -d {shlex.quote(words)}")
    return "\n".join(lines) + "\n"
