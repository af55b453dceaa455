"""The safe YAML loader of all files that people write, and the fastest safe loader and dumper for our own texts."""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import yaml
from yaml.composer import Composer

from palpate.base import limits

if TYPE_CHECKING or not yaml.__with_libyaml__:
    _SafeLoader = yaml.SafeLoader
else:

    class _SafeLoader(Composer, yaml.CSafeLoader):
        """Parses text in C, ten times faster, and composes nodes in Python, whose recursion ends with an exception."""

        def __init__(self, stream: str) -> None:
            yaml.CSafeLoader.__init__(self, stream)
            Composer.__init__(self)


MOST_VALUES = 50_000
"""Largest number of values in a file, with what its aliases unfold to."""
MOST_OF_PLAN = 200_000
"""As MOST_VALUES, for the files of motion plans and trajectories."""
OwnLoader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""Loader of texts that this process or the package itself wrote, in C where PyYAML has it, ten times faster."""
Dumper = getattr(yaml, "CSafeDumper", yaml.SafeDumper)
"""Dumper of `yaml.safe_dump`, in C where PyYAML has it, ten times faster."""


class TooLargeError(yaml.YAMLError):
    """The text holds, or its aliases unfold to, too many values."""


class Loader(_SafeLoader):
    """Safe YAML loader that reads 1e-3 as a number (YAML 1.1 requires 1.0e-3) and does not parse dates.

    It ends at once, with TooLargeError, when the text holds or unfolds to more than `most` values.
    """

    most = MOST_VALUES
    circles = True
    """False refuses a value that contains itself; the reader of scenes names its line."""
    _count, _aliased = 0, False

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """The next node."""
        self._count += 1
        if self._count > self.most:
            raise TooLargeError(f"more than {self.most:,} values")
        self._aliased = self._aliased or bool(self.check_event(yaml.AliasEvent))
        return super().compose_node(parent, index)

    def compose_document(self) -> yaml.Node | None:
        """The next document."""
        node = super().compose_document()
        if node is not None and self._aliased and _unfolded(node, {}, self.circles) > self.most:
            raise TooLargeError(f"aliases unfold to more than {self.most:,} values")
        return node


def load(text: str, most: int = MOST_VALUES) -> Any:
    """Values of a YAML text that people or strangers wrote.

    Raises:
        yaml.YAMLError: it is not YAML, holds or unfolds to more than `most` values, or is nested too deeply.
    """
    documents = load_all(text, most)
    if len(documents) > 1:
        raise yaml.YAMLError(f"{len(documents)} documents; one is read")
    return documents[0] if documents else None


def load_all(text: str, most: int = MOST_VALUES) -> list[Any]:
    """Values of all documents in a YAML text. Errors as in `load`."""
    loader, documents = Loader(text), []
    loader.most, loader.circles = most, False
    try:
        while loader.check_data():  # type: ignore[no-untyped-call]
            documents.append(loader.get_data())
    except RecursionError:
        raise yaml.YAMLError("brackets or sections are nested too deeply, or a value contains itself") from None
    except (ValueError, OverflowError, TypeError, AttributeError) as error:  # a number of a million digits, a tag
        raise yaml.YAMLError(" ".join(str(error).split()) or type(error).__name__) from None
    return documents


def read_yaml(path: Path, most: int = MOST_VALUES) -> Any:
    """Values of a YAML or JSON file that people or strangers wrote.

    Raises:
        OSError: it cannot be read, or is no file (`palpate.base.limits`). UnicodeDecodeError: it is not text.
        yaml.YAMLError: as for `load`.
    """
    return load(limits.read_text(path), most)


def _unfolded(node: yaml.Node, known: dict[int, int], circles: bool) -> int:
    """Number of values below a node, those of aliases each time, long texts by their length.

    Raises:
        yaml.YAMLError: a value contains itself, and `circles` is False.
    """
    found = known.get(id(node))
    if found == 0 and not circles:
        raise yaml.YAMLError("a value contains itself")
    if found is not None:
        return found
    known[id(node)], count = 0, 1
    if isinstance(node, yaml.MappingNode):
        count += sum(_unfolded(key, known, circles) + _unfolded(value, known, circles) for key, value in node.value)
    elif isinstance(node, yaml.SequenceNode):
        count += sum(_unfolded(value, known, circles) for value in node.value)
    else:
        count += len(node.value) // 256
    known[id(node)] = count
    return count


Loader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in resolvers if tag != "tag:yaml.org,2002:timestamp"]
    for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
}
Loader.add_implicit_resolver(
    "tag:yaml.org,2002:float", re.compile(r"^[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+$"), list("-+.0123456789")
)
