"""Parses YAML text to plain values, and records the line of every key."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any

import yaml

from palpate.base import limits
from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import Loader, TooLargeError
from palpate.base.errors import Place, SceneError
from palpate.scene import shipped
from palpate.scene.guidance import one_line


def read(path: Path) -> str:
    """The text of a scene file.

    Raises:
        SceneError: the file is missing, cannot be read, or is not text.
    """
    refuse_other_kind(path)
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
        what, mend = _kind_of(path, error.object)
        raise SceneError(what, where=str(path), why=str(error), mend=mend) from None
    except (OSError, ValueError) as error:
        raise SceneError(
            "scene file cannot be read", where=str(path), why=str(error), mend="name a scene file"
        ) from None


_MESHES = ".stl .obj .ply .off .vtk .vtp .vtu .msh .mesh .gltf .glb .dae .3mf"
_VOLUMES = ".nrrd .nhdr .nii .mha .mhd"
_CLOUDS = ".pcd .xyz .pts .las .e57"
_RECORDS = ".mcap .db3 .bag"
_OBJECT = "check it with palpate check {path}, and name it in a scene: objects: [{{mesh: {path}, unit: mm}}]"
_OTHER_FILES = {
    **dict.fromkeys(_MESHES.split(), ("this is a mesh, not a scene", _OBJECT)),
    **dict.fromkeys(_VOLUMES.split(), ("this is a volume, not a scene", _OBJECT)),
    **dict.fromkeys(_CLOUDS.split(), ("this is a point cloud, not a scene",
                                      "name it in a scene: objects: [{{cloud: {path}, unit: mm}}]")),
    **dict.fromkeys(_RECORDS.split(), ("this is a record or a bag, not a scene", "show it with palpate replay {path}")),
    ".npz": ("this is a grid of distances, not a scene", "name it in a scene: objects: [{{sdf: {path}}}]"),
    ".urdf": ("this is the URDF of an arm, not a scene", "name it in a model file of the arm (docs/arms.md)"),
    ".xacro": ("this is a xacro of an arm, not a scene", "convert it: xacro {path} > arm.urdf"),
}  # fmt: skip
_SIGNATURES = {
    b"\x1f\x8b": "compressed by gzip", b"PK\x03\x04": "a zip archive", b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture", b"%PDF": "a PDF", b"\x89HDF": "HDF5", b"SQLite format 3": "an SQLite database",
    b"\x89MCAP": "MCAP", b"\x7fELF": "a compiled program", b"NRRD": "a NRRD volume", b"glTF": "a glTF mesh",
}  # fmt: skip


def refuse_other_kind(path: Path) -> None:
    """Refuse a file that its name shows to be a mesh, a volume, a cloud, a record or the like.

    Raises:
        SceneError: the message says what the file is, and what takes it.
    """
    known = _OTHER_FILES.get(path.suffix.lower())
    if known is not None and path.is_file():
        raise SceneError(known[0], where=str(path), mend=known[1].format(path=path))


def _kind_of(path: Path, data: bytes) -> tuple[str, str]:
    """What a file that is not UTF-8 is, and what to do."""
    found = next((words for start, words in _SIGNATURES.items() if data.startswith(start)), None)
    if found is not None:
        return f"not a scene but {found}", "name a scene file, which is text in YAML; palpate scenes lists shipped ones"
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "not a text file in UTF-8, but in UTF-16", "save it as UTF-8"
    if b"\0" in data or sum(byte < 9 or 13 < byte < 32 for byte in data[:4096]) > 0.02 * len(data[:4096]):
        return "not a scene but a binary file", "name a scene file, which is text in YAML"
    return "not a text file in UTF-8", "save it as UTF-8"


def is_exercise(data: Any) -> bool:
    """True for the values of an exercise's file, which has the key `scene` alone."""
    inner = data.get("scene") if isinstance(data, dict) and set(data) == {"scene"} else None
    return isinstance(inner, dict) and isinstance(inner.get("objects"), list)


def parse(
    text: str, name: str, kind: str = "scene", first: str = "objects: [{mesh: my.stl}]"
) -> tuple[Content, dict[Place, int]]:
    """Values of a scene file, and the line number (from 1) of every value.

    Args:
        text: of the file.
        name: of the file.
        kind: what the file describes, for messages.
        first: how such a file may begin, for messages.

    Raises:
        SceneError: the text is not YAML, repeats a key, has no mapping at the top, or is too large.
    """
    try:
        loader = Loader(one_line.readable(text))
        node = loader.get_single_node()
        if node is None:
            raise SceneError(f"the {kind} is empty", where=name, mend=f"begin with: {first}")
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
        article = "an" if kind[0] in "aeiou" else "a"
        what = f"{article} {kind} is a mapping of sections"
        raise SceneError(what, where=f"{name}:1", why=why, mend=f"begin with: {first}")
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
