"""Fixtures written in one line: `margin: 3 mm around: vessel.stl`, `follow`, `stay-in`, `keep-rcm`."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml

from palpate.base.arrays.plain import Content
from palpate.base.arrays.yaml_loader import load
from palpate.scene.guidance.geometry import GRIDS, MESHES

_TABLES = (".csv", ".txt", ".tsv")
_CALL = re.compile(r"\s*([\w-]+)\s*\((.*)\)\s*")
_ARGUMENT = re.compile(r"\s*(\[[^\]]*\]|[^,]+)")
_DEGREES = re.compile(r"([-+.\deE]+)\s*(?:deg|°)")
_AROUND = re.compile(r"^(?P<before>[^#\n]*\bmargin:[^#:,\n]*\saround):(?P<after>\s)", re.MULTILINE)

#: Stiffness of the spring to the path of a plan, and additional stiffness of the wall of its tube [N/m].
LEAD, WALL = 1000.0, 400.0
#: Shapes that can be written as calls, with the keys of their arguments in order.
CALLS = {
    "cone": ("entry", "target", "half_angle_deg"),
    "tube": ("file", "radius"),
    "sphere": ("at", "radius"),
    "line": ("start", "end"),
    "point": ("at",),
    "plane": ("at", "normal"),
    "box": ("size",),
}


def readable(text: str) -> str:
    """Remove the colon after `around`: YAML forbids a second colon in `margin: 3 mm around: vessel.stl`."""
    return _AROUND.sub(r"\g<before>\g<after>", text)


def expand(value: Any) -> Any:
    """Expand a line, or a mapping with a one-line key, to the keys of a fixture; return other values unchanged.

    Raises:
        ValueError: the line is not a fixture; the message lists the possible forms.
    """
    if isinstance(value, str):
        value = _split(value)
    if not isinstance(value, dict):
        return value
    key = next((key for key in _LINES if key in value), None)
    if key is None:
        _refuse_mistyped(value)
        return value
    rest = {k: v for k, v in value.items() if k not in (key, "around", "unit")}
    made = _LINES[key](value)
    if "unit" in value:
        for shape in made["geometry"].values():
            shape["unit"] = value["unit"]
    if _plan_of(value):
        rest.pop("hard", None)  # it is the tube's
    return {**made, **rest}


def _refuse_mistyped(value: Content) -> None:
    """Refuse a mapping without geometry and role, one of whose keys is nearly the first word of a line."""
    if "geometry" in value or "role" in value:
        return
    for key in value:
        near = difflib.get_close_matches(str(key).replace("_", "-"), KEYS, n=1, cutoff=0.7)
        if near:
            example = next(line for line in EXAMPLES if line.startswith(near[0]))
            raise ValueError(f"unknown key {key!r} | did you mean {near[0]!r}? Write e.g. {example}")


def expand_list(values: Any) -> Any:
    """The items of a scene's list of fixtures, with a tube after the last item for every plan that is followed.

    Raises:
        ValueError: a line is not a fixture.
    """
    if not isinstance(values, list | tuple):
        return values
    return [*values, *(_tube_of_plan(value) for value in values if isinstance(value, dict) and _plan_of(value))]


def _plan_of(value: Content) -> str:
    """The plan file that a fixture follows in one line; empty if it follows no plan."""
    followed = value.get("follow")
    return str(followed["plan"]) if isinstance(followed, dict) and set(followed) == {"plan"} else ""


def _tube_of_plan(value: Content) -> Content:
    """The tube around a followed plan, whose radius is the plan's clearance."""
    file = _plan_of(value)
    shared: Content = {key: value[key] for key in ("hard", "enabled", "authority", "priority", "frame") if key in value}
    return {
        "name": f"{value.get('name', Path(file).stem)}-tube",
        "geometry": {"tube": {"file": file, "crossing": 0.0}},
        "role": {"name": "keep-in"},
        "law": {"stiffness": WALL},
        **shared,
    }


def _split(text: str) -> Content:
    key, _, rest = readable(text.strip()).partition(":")
    if key.strip() not in _LINES:
        _refuse_mistyped({key.strip(): rest})
        raise ValueError(f"{text!r:.60} is not a fixture | write one of {', '.join(EXAMPLES)}")
    return {key.strip(): rest.strip() or None}


def _margin(value: Content) -> Content:
    margin, around = value["margin"], value.get("around")
    if around is None and isinstance(margin, str):
        margin, _, around = margin.partition(" around ")
    if not around:
        raise ValueError(f"margin: {margin} does not name what it is around | write {EXAMPLES[0]!r}")
    return {**target(around), "role": {"name": "forbid", "margin": margin}, "hard": True}


def _follow(value: Content) -> Content:
    file = _plan_of(value)
    if file:
        path = {"path": {"file": file, "crossing": 0.0}}
        return {"name": Path(file).stem, "geometry": path, "role": {"name": "guide"},
                "law": {"stiffness": LEAD}, "hard": False}  # fmt: skip
    return {**target(value["follow"]), "role": {"name": "guide"}}


def _stay_in(value: Content) -> Content:
    return {**target(value["stay-in"]), "role": {"name": "keep-in"}, "hard": True}


def _keep_rcm(value: Content) -> Content:
    at = value["keep-rcm"]
    return {"name": "keep-rcm", "geometry": {"point": {"at": "rcm" if at in (None, True) else at}},
            "role": {"name": "rcm"}}  # fmt: skip


_LINES: dict[str, Callable[[Content], Content]] = {
    "margin": _margin,
    "follow": _follow,
    "stay-in": _stay_in,
    "keep-rcm": _keep_rcm,
}
KEYS = tuple(_LINES)
WORDS = {
    "margin": "in one line: a hard forbidden region with this margin: a length, or `3 mm around vessel.stl`",
    "around": "geometry inside the margin: a file, an object of the scene, or a shape such as sphere(target, 1 cm)",
    "follow": "in one line: a path that guides the tool: a file, an object, or {plan: FILE} of `palpate plan`",
    "stay-in": "in one line: a hard region to stay in: cone(entry, target), tube(path.csv, 2 mm), a closed mesh",
    "keep-rcm": "in one line: the shaft passes through this place; the follower's remote centre when left empty",
    "unit": "unit of the numbers in the file that the line names: mm, cm, m, in",
}
EXAMPLES = ("margin: 3 mm around: vessel.stl", "follow: suture-path.csv", "stay-in: cone(entry, target)", "keep-rcm")


def target(value: Any) -> Content:
    """The keys `geometry`, `name` and `frame` for the target of a line: a file, a call, or an object of the scene.

    Raises:
        ValueError: the file type or the shape is unknown.
    """
    if not isinstance(value, str):
        return {"geometry": value}
    call = _CALL.fullmatch(value)
    if call:
        return {"name": call[1], "geometry": {call[1]: _arguments(call[1], call[2])}}
    ending, name = Path(value).suffix.lower(), Path(value).stem
    for kind, endings in (("mesh", MESHES), ("grid", GRIDS), ("path", _TABLES)):
        if ending in endings:
            return {"name": name, "geometry": {kind: {"file": value}}}
    if ending:
        known = ", ".join((*MESHES[:3], *GRIDS, *_TABLES))
        raise ValueError(f"{value!r} has an unknown file type | use {known}, an object's name, or e.g. cone(a, b)")
    return {"name": value, "geometry": {"object": {"name": value}}, "frame": value}


def _arguments(shape: str, text: str) -> Content:
    if shape not in CALLS:
        raise ValueError(f"there is no shape {shape!r} | shapes: {', '.join(CALLS)}")
    given = [_argument(part.strip()) for part in _ARGUMENT.findall(text) if part.strip()]
    keys = CALLS[shape]
    if len(given) > len(keys):
        raise ValueError(f"{shape}({text}) has {len(given)} arguments | write {shape}({', '.join(keys)})")
    return dict(zip(keys, given, strict=False))


def _argument(text: str) -> Any:
    degrees = _DEGREES.fullmatch(text)
    try:
        return float(degrees[1]) if degrees else load(text)
    except (ValueError, yaml.YAMLError):
        raise ValueError(f"{text!r} is not an argument | write a number with its unit, [x, y, z], or a name") from None
