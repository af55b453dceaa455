"""Licences of Palpate and of all packages that it needs, and a bill of materials (CycloneDX 1.5)."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

COMPILED_IN = {
    "eigen": ("MPL-2.0", "cmeel-eigen"),
    "nanobind": ("BSD-3-Clause", "nanobind"),
    "robin-map": ("MIT", ""),
}
"""Sources of others in the compiled extensions: licence, and the package whose version was compiled."""
SILENT = {"cmeel-qhull": "Qhull"}
"""Packages whose metadata state no licence, and that of their sources (an identifier of SPDX)."""
_REQUIREMENT = re.compile(r"([A-Za-z0-9][\w.-]*)[^;]*(?:;(.*))?")
_EXTRA = re.compile(r"extra\s*==\s*['\"]([^'\"]+)['\"]")


@dataclass(frozen=True)
class Component:
    """A package, or a part of the compiled extensions."""

    name: str
    version: str
    """Empty: unknown."""
    licence: str
    """An SPDX identifier where the package gives one, otherwise its words; empty: it states none."""
    needed_by: str
    """``core``, ``compiled in``, or the extra that needs it first."""
    url: str = ""


def components() -> list[Component]:
    """Palpate, what its extensions contain, and all installed packages that it needs, sorted by name."""
    found = {"palpate": _component("palpate", "core")}
    extras = metadata.metadata("palpate").get_all("Provides-Extra") or []
    for need in ("", *extras):
        for name in _closure("palpate", need):
            found.setdefault(_key(name), _component(name, need or "core"))
    compiled = [Component(n, _version(p), licence, "compiled in") for n, (licence, p) in COMPILED_IN.items()]
    return sorted([*found.values(), *compiled], key=lambda one: one.name.lower())


def bill_of_materials(found: Iterable[Component]) -> dict[str, Any]:
    """The components as a CycloneDX 1.5 document."""
    parts = [one for one in found if one.name != "palpate"]
    own = _component("palpate", "core")
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": {**_part(own), "type": "application"}},
        "components": [_part(one) for one in parts],
    }


def _part(one: Component) -> dict[str, Any]:
    part: dict[str, Any] = {"type": "library", "name": one.name, "bom-ref": one.name}
    if one.version:
        part["version"] = one.version
    if one.needed_by != "compiled in":
        part["purl"] = f"pkg:pypi/{_key(one.name)}@{one.version}"
    if one.licence:
        spdx = re.fullmatch(r"[A-Za-z0-9.+-]+", one.licence) is not None
        compound = re.fullmatch(r"[A-Za-z0-9.+() -]+", one.licence) and re.search(r" (AND|OR|WITH) ", one.licence)
        part["licenses"] = [{"expression": one.licence}] if compound else [
            {"license": {"id" if spdx and one.licence in _KNOWN else "name": one.licence}}
        ]  # fmt: skip
    return part


_KNOWN = {
    "0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "BSL-1.0", "CC0-1.0", "EPL-2.0", "GPL-2.0-only",
    "GPL-2.0-or-later", "GPL-3.0-only", "GPL-3.0-or-later", "HPND", "ISC", "LGPL-2.1-only", "LGPL-2.1-or-later",
    "LGPL-3.0-only", "LGPL-3.0-or-later", "MIT", "MIT-0", "MIT-CMU", "MPL-2.0",
    "PSF-2.0", "Python-2.0", "Qhull", "Unlicense", "Zlib",
}  # fmt: skip
"""Identifiers of SPDX that packages of this field state; others are written as names."""


def _closure(package: str, extra: str) -> Iterator[str]:
    """Installed packages that a package needs, with those that they need; for an extra, those of this extra alone."""
    waiting, seen = [(package, extra)], set()
    while waiting:
        name, wanted = waiting.pop()
        for line in metadata.requires(name) or ():
            one = _REQUIREMENT.match(line)
            assert one is not None, line
            marker = _EXTRA.search(one[2] or "")
            if (marker[1] if marker else "") != wanted or _key(one[1]) in seen or not _version(one[1]):
                continue
            seen.add(_key(one[1]))
            yield one[1]
            waiting.append((one[1], ""))


def _component(name: str, needed_by: str) -> Component:
    about: Any = metadata.metadata(name)
    urls = [line.partition(",")[2].strip() for line in about.get_all("Project-URL") or ()]
    url = about.get("Home-page") or next(iter(urls), "")
    return Component(about["Name"], about["Version"], _licence(about), needed_by, url)


def _licence(about: Any) -> str:
    """What the metadata of a package states: its expression, a short licence field, or its classifiers."""
    if about.get("License-Expression"):
        return str(about["License-Expression"])
    words = (about.get("License") or "").strip()
    if words and "\n" not in words and len(words) < 60 and words.upper() != "UNKNOWN":
        return str(words)
    named = [line.split(" :: ")[-1] for line in about.get_all("Classifier") or () if line.startswith("License ::")]
    stated = " AND ".join(name for name in named if name != "OSI Approved") or words.partition("\n")[0].strip()
    return stated or SILENT.get(about["Name"], "") or _licence_of_ros(about["Name"])


def _licence_of_ros(name: str) -> str:
    """What the package.xml of a package of ROS 2 states, since its Python metadata state nothing."""
    file = Path(sys.prefix) / "share" / name.removeprefix("ros-").replace("-", "_") / "package.xml"
    text = file.read_text(encoding="utf-8") if name.startswith("ros-") and file.is_file() else ""
    return " AND ".join(re.findall(r"<license[^>]*>\s*([^<]+?)\s*</license>", text))


def _version(name: str) -> str:
    try:
        return metadata.version(name) if name else ""
    except metadata.PackageNotFoundError:
        return ""


def _key(name: str) -> str:
    """The name of a package as an index compares it."""
    return re.sub(r"[-_.]+", "-", name).lower()
