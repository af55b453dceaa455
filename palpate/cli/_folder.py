"""Finds the commands by listing folders: a new command is a new file.

`palpate NAME` is `NAME.py`, or `NAME/command.py` when the command has several parts: a dataclass ``Command`` whose
fields are the options and whose ``__call__`` does the work. A module without ``Command`` is a group: its docstring is
the help text, its members are the commands in its folder (or in the packages of ``MEMBERS``), ``FIRST`` names the
members that the help shows first, ``OTHERWISE`` the one that takes arguments that begin with no member's name, and
``prepare()`` runs before one of them is imported.

Listing reads the files as text; a command and its imports are loaded only when the command runs.

Other installed distributions add commands and studies by entry points (docs/extending.md), which are looked up only for
the help, and for a name that is no command of our own.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import dataclass, make_dataclass
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType, UnionType
from typing import Annotated, Any, Union, get_args, get_origin, get_type_hints

from palpate.base import plugins
from palpate.base.errors import PalpateError
from palpate.cli._overview import overview

_OF_OTHERS: dict[str, plugins.Group] = {
    "palpate.cli.commands": "palpate.commands",
    "palpate_lab.studies": "palpate.studies",
}
"""Groups of the entry points that add to the commands of a package."""


@dataclass(frozen=True)
class Entry:
    """A command or a group of commands."""

    module: str
    """Module name for the import."""
    file: Path
    """Source file of the module."""

    @property
    def summary(self) -> str:
        """The first line of the help text."""
        try:
            tree = ast.parse(self.file.read_text(encoding="utf-8"))
        except (OSError, SyntaxError, ValueError):  # of another distribution
            return ""
        command = next((n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "Command"), tree)
        return (ast.get_docstring(command) or "").partition("\n")[0]


def entries(packages: Sequence[str], first: Sequence[str] = ()) -> dict[str, Entry]:
    """The commands and groups in the folders of packages, by name; the names in ``first`` come first."""
    found: dict[str, Entry] = {}
    for package, path in ((one, path) for one in packages for path in _files(one)):
        name = path.stem.rstrip("_").replace("_", "-")  # import_.py is `import`, stand_in.py is `stand-in`
        if path.name.startswith("_"):
            continue
        if path.suffix == ".py":
            found[name] = Entry(f"{package}.{path.stem}", path)
        elif (path / "command.py").is_file():
            found[name] = Entry(f"{package}.{path.name}.command", path / "command.py")
        elif (path / "__init__.py").is_file():
            found[name] = Entry(f"{package}.{path.name}", path / "__init__.py")
    order = {name: i for i, name in enumerate(first)}
    return dict(sorted(found.items(), key=lambda item: (order.get(item[0], len(order)), item[0])))


def _files(package: str) -> list[Path]:
    spec = find_spec(package)
    folders = map(Path, (spec and spec.submodule_search_locations) or ())
    return [path for folder in folders if folder.is_dir() for path in folder.iterdir()]


def all_entries(group: ModuleType) -> dict[str, Entry]:
    """The commands of a group, and those that other distributions add; ours come first, and keep their names."""
    own = _own_entries(group)
    others = _others(group)
    added = plugins.files(others) if others else {}
    return own | {name: Entry(module, file) for name, (module, file) in added.items() if name not in own}


def _own_entries(group: ModuleType) -> dict[str, Entry]:
    return entries(_packages(group), getattr(group, "FIRST", ()))


def _packages(group: ModuleType) -> tuple[str, ...]:
    return tuple(getattr(group, "MEMBERS", (group.__name__,)))


def _others(group: ModuleType) -> plugins.Group | None:
    return _OF_OTHERS.get(_packages(group)[0])


def _added(group: ModuleType, name: str) -> Any:
    """The module of a command that another distribution adds, imported; None if there is none of this name.

    Raises:
        PalpateError: it cannot be imported, or two distributions add it.
    """
    others = _others(group)
    return plugins.load(others, name) if others else None


def dispatch(group: ModuleType, prog: str, description: str, args: Sequence[str]) -> int:
    """Run the command that the arguments name; returns its exit code.

    Wrong arguments exit with 2 and list the possible ones.
    """
    members, added = _own_entries(group), None
    if not args or args[0] not in members:  # to look for those of others takes 30 ms
        members, added = all_entries(group), _added(group, args[0] if args else "")
    if not args or args[0] in ("-h", "--help"):
        print(overview(prog, description, {name: entry.summary for name, entry in members.items()}))
        return 0
    import tyro
    from tyro.conf import FlagCreatePairsOff

    config = (FlagCreatePairsOff,)
    otherwise = getattr(group, "OTHERWISE", "")
    if args[0] not in members and added is None and otherwise:
        args = [otherwise, *args]
    if args[0] not in members and added is None:
        if not args[0].startswith("-"):
            raise PalpateError(f"there is no command {prog} {args[0]}", mend=_nearest(prog, args[0], list(members)))
        tyro.cli(_choice(members), prog=prog, description=description, args=args[:1], config=config)
        return 2  # not reached: tyro lists the commands and exits
    module = import_module(members[args[0]].module) if added is None else added
    prog = f"{prog} {args[0]}"
    if hasattr(module, "Command"):
        from palpate.cli._numbers import check_numbers

        made = _with_typing_unions(module.Command)
        command = tyro.cli(made, prog=prog, args=_joined(args[1:], _of_many(made)), config=config)
        check_numbers(command)
        return int(command())
    if hasattr(module, "prepare"):
        module.prepare()
    return dispatch(module, prog, module.__doc__ or "", args[1:])


def _nearest(prog: str, given: str, names: Sequence[str]) -> str:
    """Advice for a mistyped command: the nearest names, also those of parts of a command, or all names."""
    import difflib

    near = difflib.get_close_matches(given.lower(), names, n=3, cutoff=0.5)
    near += [name for name in names if len(given) > 1 and name.startswith(given.lower()) and name not in near]
    if near:
        return f"did you mean {' or '.join(f'{prog} {name}' for name in near)}? All commands: {prog} --help"
    return f"write one of {', '.join(names)}; {prog} --help describes them"


def _with_typing_unions(command: type[Any]) -> type[Any]:
    """The command, its annotations `A | B` as `Union[A, B]`.

    Tyro checks defaults of `Union` itself. For others it imports typeguard, which takes nearly as long as numpy.
    """
    hints = get_type_hints(command, include_extras=True)
    command.__annotations__ = {name: _typing_union(hint) for name, hint in hints.items()}
    return command


def _of_many(command: type[Any]) -> set[str]:
    """The options of a command that take any number of words: `--signals A B`; not those that are appended."""
    from tyro.conf import UseAppendAction

    (append,) = get_args(UseAppendAction[int])[1:]
    found = set()
    for name, hint in command.__annotations__.items():
        plain: Any = hint.__origin__ if hasattr(hint, "__metadata__") else hint  # without Annotated
        if get_origin(plain) is tuple and Ellipsis in get_args(plain) and append not in get_args(hint):
            found.add(f"--{name.replace('_', '-')}")
    return found


def _joined(args: Sequence[str], of_many: set[str]) -> list[str]:
    """The arguments, an option of many words once: `--signals A --signals B` is `--signals A B`, not only B."""
    out: list[str] = []
    words: dict[str, list[str]] = {}
    into = out
    for arg in args:
        name, equals, value = arg.partition("=")
        if name in of_many:
            into = words.setdefault(name, [])
            into += [value] if equals else []
        else:
            into = out if arg.startswith("--") else into
            into.append(arg)
    return out + [word for name, given in words.items() for word in (name, *given)]


def _typing_union(hint: Any) -> Any:
    if get_origin(hint) is Annotated:
        return hint.copy_with((_typing_union(hint.__origin__),))  # Annotated[...] caches A | B in 3.11.2
    return Union[get_args(hint)] if isinstance(hint, UnionType) else hint  # noqa: UP007 - made at run time


def _choice(members: dict[str, Entry]) -> Any:
    """A union type of the members, each described by the first line of its help text."""
    from tyro.conf import subcommand

    kinds = (
        Annotated[make_dataclass(name.capitalize(), ()), subcommand(name, description=entry.summary)]
        for name, entry in members.items()
    )
    return Union[tuple(kinds)]  # noqa: UP007 - made at run time
