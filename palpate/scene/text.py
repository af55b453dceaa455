"""Parses YAML text to plain values, and records the line of every key."""

from __future__ import annotations

import difflib
from pathlib import Path

import yaml

from palpate import limits
from palpate.arrays.plain import Content
from palpate.arrays.yaml_loader import Loader, TooLargeError
from palpate.errors import SceneError
from palpate.guidance import one_line
from palpate.scene import shipped
from palpate.wording import Place


def read(path: Path) -> str:
    """The text of a scene file.

    Raises:
        SceneError: the file is missing, cannot be read, or is not text.
    """
    try:
        return limits.read_text(path)
    except FileNotFoundError:
        near = sorted(p.name for p in path.parent.glob("*.yaml")) if path.parent.is_dir() else []
        mend = f"scenes in {path.parent}: {', '.join(near)}" if near else "check the path"
        close = difflib.get_close_matches(path.name, shipped.names(), n=1)
        if close and path.name == str(path):
            mend = f"did you mean {close[0]}? palpate scenes lists the shipped scenes"
        raise SceneError("scene file not found", where=str(path), mend=mend) from None
    except UnicodeDecodeError as error:
        raise SceneError("not a text file", where=str(path), why=str(error), mend="save it as UTF-8") from None
    except (OSError, ValueError) as error:
        raise SceneError(
            "scene file cannot be read", where=str(path), why=str(error), mend="name a scene file"
        ) from None


def parse(text: str, name: str) -> tuple[Content, dict[Place, int]]:
    """Values of a scene file, and the line number (from 1) of every value.

    Raises:
        SceneError: the text is not YAML, repeats a key, has no mapping at the top, or is too large.
    """
    try:
        loader = Loader(one_line.readable(text))
        node = loader.get_single_node()
        if node is None:
            raise SceneError(
                "the scene is empty", where=name, mend="name at least one object: objects: [{mesh: my.stl}]"
            )
        lines: dict[Place, int] = {}
        _walk(node, (), lines, name, ())
        data = loader.construct_document(node)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        where = f"{name}:{min(mark.line + 1, len(text.splitlines()))}" if mark else name
        why = ", ".join(part for part in (error.context, error.problem) if part)
        mend = "check indentation, colons and brackets"
        if mark and "\t" in _line(text, mark.line):
            why, mend = "there is a tab in this line, which YAML does not allow as indentation", "use spaces"
        raise SceneError("not valid YAML", where=where, why=why, mend=mend) from None
    except TooLargeError as error:
        raise SceneError(str(error), where=name, mend="put meshes and curves into files of their own") from None
    except RecursionError:
        why = "brackets or sections are nested too deeply"
        raise SceneError("not valid YAML", where=name, why=why, mend="close the brackets") from None
    except (yaml.YAMLError, ValueError, OverflowError, TypeError, AttributeError) as error:
        why = " ".join(str(error).split()) or type(error).__name__
        raise SceneError("not valid YAML", where=name, why=why, mend="check the file; it must be plain text") from None
    if not isinstance(data, dict):
        why = f"the file holds a {type(data).__name__}"
        raise SceneError("a scene is a mapping of sections", where=f"{name}:1", why=why, mend="begin with: objects:")
    return data, lines


def _walk(node: yaml.Node, place: Place, lines: dict[Place, int], name: str, above: tuple[yaml.Node, ...]) -> None:
    line = node.start_mark.line + 1
    lines.setdefault(place, line)
    if node in above:
        raise SceneError("a value contains itself", where=f"{name}:{line}", mend="remove the anchor (&) or alias (*)")
    if isinstance(node, yaml.MappingNode):
        seen: dict[str, int] = {}
        for key, value in node.value:
            text, at = str(key.value), key.start_mark.line + 1
            if text in seen and text != "<<":
                why = f"first given in line {seen[text]}"
                raise SceneError(f"key {text!r} given twice", where=f"{name}:{at}", why=why, mend="remove one of them")
            seen[text] = at
            lines[(*place, text)] = at
            _walk(value, (*place, text), lines, name, (*above, node))
    elif isinstance(node, yaml.SequenceNode):
        for i, value in enumerate(node.value):
            _walk(value, (*place, i), lines, name, (*above, node))


def _line(text: str, index: int) -> str:
    return next(iter(text.splitlines()[index : index + 1]), "")
