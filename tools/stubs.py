"""Writes the type stubs of the compiled extensions, in palpate (_core and its parts): `make stubs`.

The text comes from nanobind's stub generator. The array types are shortened and long signatures are wrapped, so that
people can read the stubs as well. With --check the script writes nothing; it prints the difference and exits with
status 1 if a committed stub is out of date.
"""

from __future__ import annotations

import argparse
import difflib
import re
import sys
import textwrap
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path

from nanobind.stubgen import StubGen

import palpate

PACKAGE = Path(__file__).resolve().parents[1] / "palpate"
EXTENSIONS = ("_collision", "_core", "_dvrk", "_guidance", "_haply", "_network", "_reference", "_tissue", "_verify")
WIDTH = 120
BRACKETS = (r" *(def \w+\()(.*)(\) -> .*)", r" *(\) -> tuple\[)(.*)(\]:.*)")
"""Arguments, and the members of a result that is still too long: the text before, inside and after the brackets."""
HEAD = """\
# Generated from the bindings by `make stubs`; do not edit. An array type states its shape; ":" is any length.
"""


def array_type(match: re.Match[str]) -> str:
    """`Annotated[NDArray[T], dict(shape=(None, 3), order='C')]` as `Annotated[NDArray[T], "(:, 3)"]`."""
    shape = re.search(r"shape=\(([^)]*)\)", match["notes"])
    if shape is None:
        return f'Annotated[{match["array"]}, "read-only"]'
    lengths = shape[1].replace("None", ":").rstrip(",")
    return f'Annotated[{match["array"]}, "({lengths}{"" if "," in lengths else ","})"]'


def arguments(text: str) -> Iterator[str]:
    """The arguments of a signature, split at the commas outside brackets."""
    depth, start = 0, 0
    for i, c in enumerate(text):
        depth += (c in "([{") - (c in ")]}")
        if c == "," and depth == 0:
            yield text[start:i].strip()
            start = i + 1
    yield text[start:].strip()


def wrapped(line: str) -> str:
    """A line of at most WIDTH characters; a longer signature gets one argument per line, a docstring is filled."""
    if len(line) <= WIDTH:
        return line
    indent = line[: len(line) - len(line.lstrip())]
    for pattern in BRACKETS:
        if match := re.fullmatch(pattern, line):
            head, inside, rest = match.groups()
            items = (f"{indent}    {item}," for item in arguments(inside))
            return "\n".join((f"{indent}{head}", *items, wrapped(indent + rest)))
    return textwrap.fill(line.strip(), WIDTH, initial_indent=indent, subsequent_indent=indent, break_on_hyphens=False)


def generated(name: str) -> str:
    """The stub of an extension of palpate, such as "_core"."""
    _ = palpate._core  # compiles the extensions first if a source has changed
    module = import_module(f"palpate.{name}")
    generator = StubGen(module)
    generator.put(module)
    text = re.sub(r"Annotated\[(?P<array>NDArray\[[\w.]+\]), dict\((?P<notes>.*?)\)\]", array_type, generator.get())
    return HEAD + "\n".join(wrapped(line) for line in text.splitlines()) + "\n"


def main() -> int:
    """Exit status: 0 when the stubs are written or up to date, 1 when --check finds a difference."""
    parser = argparse.ArgumentParser(description="Writes the type stubs of palpate's compiled extensions.")
    parser.add_argument("--check", action="store_true", help="compare with the committed stubs and write nothing")
    check, stale = parser.parse_args().check, False
    for name in EXTENSIONS:
        path, text = PACKAGE / f"{name}.pyi", generated(name)
        if not check:
            path.write_text(text)
        elif path.read_text() != text:
            stale = True
            old, new = path.read_text().splitlines(), text.splitlines()
            diff = difflib.unified_diff(old, new, f"committed {path.name}", "generated", lineterm="")
            print("\n".join(list(diff)[:40]))
    if stale:
        print("The stubs differ from the bindings. Run `make stubs` and commit the result.")
    return int(stale)


if __name__ == "__main__":
    sys.exit(main())
