"""Removes from a failing loop all that it does not need to fail, and writes what is left as a scene file."""

from __future__ import annotations

import copy
import json
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from shutil import copyfile
from typing import Any

import numpy as np
import yaml

from palpate.base.arrays.plain import Content
from palpate.base.errors import OutputError, PalpateError
from palpate_lab.verify.fuzz import Fault
from palpate_lab.verify.fuzz.loops import files
from palpate_lab.verify.fuzz.loops.kinds import Loop, loops
from palpate_lab.verify.fuzz.loops.verdict import Verdict, judge
from palpate_lab.verify.fuzz.loops.ways import Way

_KEPT = 0.3  # share of the excess that a reduced loop must still show
_MARK = "# loop: "

_PLAIN: tuple[tuple[tuple[str, ...], Any], ...] = (
    (("mapping", "scale"), 1.0),
    (("mapping", "force_scale"), 1.0),
    (("arms", "leader", "base", "rpy_deg"), [0.0, 0.0, 0.0]),
    (("stability", "force_cap"), 1000.0),
    (("stability", "rate_cap"), 1e6),
    (("stability", "passivity"), "observer"),
)
"""Values of scenes that matter the least."""
_OF_OBJECT = ("static_friction", "friction", "motion")
_OF_FIXTURE = ("ramps", "authority", "priority", "hard", "engage", "release")


def reduced(loop: Loop) -> tuple[Loop, Verdict]:
    """The smallest failing loop that removals lead to, and its verdict; the loop itself if it does not fail."""
    verdict = judge(loop)
    changed = verdict.fails
    while changed:
        changed = False
        for smaller in _smaller(loop):
            try:
                found = judge(smaller)
            except (PalpateError, ValueError):
                continue
            if found.fails and found.excess > _KEPT * verdict.excess:
                loop, verdict, changed = smaller, found, True
                break
    return loop, verdict


def _smaller(loop: Loop) -> Iterator[Loop]:
    """The loop without one of its parts, for each part."""
    for scene in _smaller_scenes(loop.scene, loop.run):
        yield replace(loop, scene=scene)
    if loop.way.theta.any():
        yield replace(loop, way=Way(loop.way.p, np.zeros_like(loop.way.theta)))
    for k in range(1, len(loop.way.p) - 1):
        if len(loop.way.p) > 3:
            yield replace(loop, way=loop.way.without(k))
    if loop.cycles > 1:
        yield replace(loop, cycles=loop.cycles // 2)
    if loop.clock:
        yield replace(loop, clock="")


def _parts(scene: Content) -> Iterator[tuple[Any, ...]]:
    """Places of the parts that a scene may lose, the largest first."""
    contact = scene.get("contact", {})
    objects, fixtures, spheres = scene["objects"], scene.get("guidance", ()), contact.get("spheres", ())
    yield from (("objects", k) for k in range(1, len(objects)))
    yield from (("guidance", k) for k in range(len(fixtures)))
    yield from (("contact", "spheres", k) for k in range(len(spheres)))
    yield from (
        ("objects", k, "regions", j) for k, one in enumerate(objects) for j in range(len(one.get("regions", ())))
    )
    yield from (("objects", k, key) for k, one in enumerate(objects) for key in _OF_OBJECT if key in one)
    yield from (("guidance", k, key) for k, one in enumerate(fixtures) for key in _OF_FIXTURE if key in one)
    if "whole_tool" in contact:
        yield ("contact", "whole_tool")


def _smaller_scenes(scene: Content, run: str) -> Iterator[Content]:
    for place in _parts(scene):
        yield _without(scene, place)
    for place, value in _PLAIN:
        smaller = copy.deepcopy(scene)
        inner = smaller
        for key in place[:-1]:
            inner = inner.setdefault(key, {})
        if inner.get(place[-1]) != value and not (run == "still" and place[-1] == "passivity"):
            inner[place[-1]] = value
            yield smaller


def _without(scene: Content, place: tuple[Any, ...]) -> Content:
    smaller = copy.deepcopy(scene)
    inner: Any = smaller
    for key in place[:-1]:
        inner = inner[key]
    del inner[place[-1]]
    return smaller


def write(loop: Loop, verdict: Verdict, path: Path, seed: int) -> None:
    """Write a loop as a scene file; comments state the energy and the way, and `again` reads them."""
    values = {key: value for key, value in asdict(loop).items() if key != "scene"}
    values["way"] = {"p": loop.way.p.tolist(), "theta": loop.way.theta.tolist()}
    lines = [f"# Seed {seed}, {loop.kind}: {verdict.words()}", "#",
             f'# python -c "from palpate_lab.verify.fuzz.loops.reduce import again; print(again({path.name!r}))"', "#",
             "# corners of the way of the tool, in W [mm], and its rotation [deg]:"]  # fmt: skip
    lines += [f"#   {np.round(1e3 * p, 3).tolist()} {np.round(np.degrees(a), 2).tolist()}"
              for p, a in zip(loop.way.p, loop.way.theta, strict=True)]  # fmt: skip
    text = yaml.safe_dump(loop.scene, sort_keys=False, default_flow_style=None, width=120)
    path.write_text("\n".join([*lines, _MARK + json.dumps(values), text]))
    for obj in loop.scene["objects"]:
        cloud = obj.get("cloud") or {}
        for name in filter(None, (obj.get("mesh"), obj.get("sdf"), cloud.get("file"))):
            copyfile(files.folder() / name, path.parent / name)


def read(path: Path) -> Loop:
    """The loop of a file of `write`."""
    text = path.read_text()
    values = json.loads(next(line for line in text.splitlines() if line.startswith(_MARK))[len(_MARK) :])
    way = Way(np.array(values["way"]["p"]), np.array(values["way"]["theta"]))
    return Loop(**(values | {"way": way, "scene": yaml.safe_load(text)}))


def again(path: str | Path) -> str:
    """Judge the loop of a file once more; its verdict in words."""
    from palpate_lab.verify.fuzz.loops.device import Device

    loop = read(Path(path))
    verdict = judge(loop, Device(loop.scene, Path(path).resolve().parent))
    return ("fails: " if verdict.fails else "holds: ") + verdict.words()


def write_worst(faults: list[Fault], folder: Path) -> list[Path]:
    """Write the worst loop of each kind and run, reduced; the files.

    Raises:
        OutputError: the folder cannot be written.
    """
    worst: dict[tuple[str, str], Fault] = {}
    for fault in faults:
        found = fault["details"]
        if found:
            key = (found["kind"], found["run"])
            if key not in worst or _share(fault) > _share(worst[key]):
                worst[key] = fault
    written = []
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for (kind, run), fault in sorted(worst.items()):
            loop, verdict = reduced(loops(fault["seed"], fault["details"]["drawn"])[fault["details"]["loop"]])
            written.append(folder / f"{kind.replace(' ', '-')}-{run}-{fault['seed']}.yaml")
            write(loop, verdict, written[-1], fault["seed"])
    except OSError as error:
        raise OutputError(f"{folder} cannot be written", why=str(error), mend="name another folder") from None
    return written


def _share(fault: Fault) -> float:
    found = fault["details"]
    return float((found["bound_J"] - found["work_J"]) / found["stored_J"])
