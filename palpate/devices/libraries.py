"""The vendors' libraries that drivers load: what they are called, and where this machine was searched for them."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

FOLDERS = ("/usr/lib", "/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/local/lib", "/opt/*/lib")
"""Folders that are searched after those of LD_LIBRARY_PATH; a star is any folder."""
_WANTED = (
    ("force-dimension", "libdhd.so", "SDK of Force Dimension", "FORCEDIM_SDK"),
    ("openhaptics.so", "libHD.so", "OpenHaptics of 3D Systems", "OH_SDK_BASE"),
    ("novint.so", "libhdl.so", "HDAL of Novint", "NOVINT_DEVICE_SUPPORT"),
)


@dataclass(frozen=True)
class Library:
    """A vendor's library."""

    driver: str  # the driver that loads it
    file: str
    product: str  # what the user installs
    found: str | None  # path of the library; None: it is in none of the places
    places: list[str]  # folders that were searched


def libraries() -> list[Library]:
    """The libraries of the drivers that need one."""
    return [_search(*wanted) for wanted in _WANTED]


def _search(driver: str, file: str, product: str, variable: str) -> Library:
    given = [Path(folder) for folder in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if folder]
    paths = [path for path in given if "site-packages" not in path.parts]  # wheels carry no SDK of a vendor
    sdk = os.environ.get(variable)
    if sdk:
        paths += [Path(sdk), Path(sdk) / "lib"]
    for folder in FOLDERS:
        head, star, tail = folder.partition("*")
        paths += sorted(Path(head).glob(f"*{tail}")) if star else [Path(folder)]
    places = list(dict.fromkeys(path for path in paths if path.is_dir()))
    found = next((hit for place in places for hit in sorted(place.glob(f"{file}*"))), None)
    return Library(driver, file, product, None if found is None else str(found), [str(place) for place in places])
