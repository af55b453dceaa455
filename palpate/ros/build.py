"""Compiles the ROS 2 part of Palpate once, against the installed ROS 2, and loads it.

Message packages that ROS 2 lacks are installed next to the `ros-*` wheels, where every Python of this environment
imports them, so that a client of the real robot runs unchanged. Everything else, including the messages for a sourced
ROS 2, is kept in `~/.cache/palpate/ros` (`XDG_CACHE_HOME`) under a hash of its inputs: the sources, the headers of the
core, ROS 2, Python. Processes that start at the same time wait for the one that compiles.
"""

from __future__ import annotations

import ctypes
import fcntl
import hashlib
import importlib.machinery
import importlib.util
import os
import shutil
import subprocess
import sys
import sysconfig
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from palpate.base import dds_security
from palpate.base.errors import RosMissingError
from palpate.ros import where

HERE = Path(__file__).parent
PACKAGES = ("crtk_msgs", "cisst_msgs", "tf2_msgs")
"""Message packages that Palpate adds if ROS 2 lacks them; their definitions are in `messages/`."""
Progress = Callable[[str], None]
_PYTHON = ("lib/python3*/site-packages", "local/lib/python3*/dist-packages")  # the second on Debian's Python
_KEPT = 4  # number of compiled modules to keep, as working copies switch between versions
_OURS = "palpate"
"""File in a message package's share folder that marks it as made by Palpate, with the hash of its sources."""
_SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")
PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""Variables that name a profile of Fast DDS; the second counts before release 3."""


@dataclass(frozen=True)
class Built:
    """The installation and the compiled parts."""

    ros: where.Ros
    messages: dict[str, Path]
    """Prefix of each message package: Palpate's, or that of ROS 2."""
    extension: Path
    """The compiled module `_ros`."""
    seconds: float
    """Time of the compilation [s]; 0 if nothing was compiled."""

    def ours(self, name: str) -> bool:
        """True if Palpate made this message package."""
        return (self.messages[name] / "share" / name / _OURS).is_file()


def build(progress: Progress = lambda _: None) -> Built:
    """Compile all missing parts.

    Raises:
        RosMissingError: no ROS 2, no compiler, or a compiler error; the message has the remedy and the log.
    """
    from palpate import _core  # first: in a working copy this import updates the installed headers

    ros, package = where.find(), Path(_core.__file__).parent
    place = ":".join([*map(str, ros.prefixes), ros.version(), sys.version, str(package)])
    folder = _cache() / hashlib.sha256(place.encode()).hexdigest()[:16]
    start = time.monotonic()
    with ThreadPoolExecutor() as pool:  # configuring and generating use one core each
        made = pool.map(lambda name: _messages(ros, folder, name, progress), PACKAGES)
        messages = dict(zip(PACKAGES, made, strict=True))
    extension = _extension(ros, folder, package, messages, progress)
    fresh = extension.stat().st_mtime > time.time() - (time.monotonic() - start)
    return Built(ros, messages, extension, time.monotonic() - start if fresh else 0.0)


def messages(progress: Progress = lambda _: None) -> Built:
    """Make the packages of `PACKAGES` importable next to `rclpy`; compiles missing parts.

    Raises:
        RosMissingError: as for `build`; or DDS security is asked for, and cannot be on.
    """
    dds_security.enforce(prefix / "lib" for prefix in where.find().prefixes)
    built = build(progress)
    for name, prefix in built.messages.items():
        if prefix in built.ros.prefixes:  # importable already
            continue
        _prepend("AMENT_PREFIX_PATH", prefix)
        for library in sorted((prefix / "lib").glob("lib*__rosidl_typesupport_*.so")):
            ctypes.CDLL(str(library))  # ROS loads these by file name, outside LD_LIBRARY_PATH
        python = next((p for place in _PYTHON for p in prefix.glob(place)), None)
        if python and importlib.util.find_spec(name) is None:
            sys.path.append(str(python))
    return built


def load(progress: Progress = lambda _: None) -> ModuleType:
    """The module `palpate.ros._ros`; compiles missing parts."""
    name = "palpate.ros._ros"
    if name in sys.modules:
        return sys.modules[name]
    built = messages(progress)
    speed_up_discovery(built.ros)
    for prefix in reversed(built.ros.prefixes):
        _prepend("LD_LIBRARY_PATH", prefix / "lib")
    loader = importlib.machinery.ExtensionFileLoader(name, str(built.extension))
    spec = importlib.util.spec_from_file_location(name, built.extension, loader=loader)
    assert spec
    try:
        module = importlib.util.module_from_spec(spec)
        loader.exec_module(module)
    except ImportError as error:
        mend = f"source ROS 2 completely, or delete {built.extension.parent} and run `palpate ros setup`"
        raise RosMissingError("the nodes cannot be loaded", where=built.ros.words, why=str(error), mend=mend) from None
    sys.modules[name] = module
    return module


def speed_up_discovery(ros: where.Ros) -> None:
    """Let participants of this process be discovered soon; call it before ROS starts.

    discovery.xml says what is changed and why. A profile that the user has set stays.
    """
    if not any(os.environ.get(name) for name in PROFILES):
        os.environ[PROFILES[ros.release in ("Humble", "Iron", "Jazzy")]] = str(HERE / "discovery.xml")


def _messages(ros: where.Ros, folder: Path, name: str, progress: Progress) -> Path:
    """The prefix of a message package; compiles the package if it is missing or made from older sources."""
    source = HERE / "messages"
    digest = _digest([source / "CMakeLists.txt", *(p for p in (source / name).rglob("*") if p.is_file())])
    target = ros.prefixes[0] if ros.may_grow() else folder / f"{name}-{digest}"

    def found() -> Path | None:
        for prefix in (*ros.prefixes, target):
            share = prefix / "share" / name
            ours = share / _OURS
            if (share / "package.xml").is_file() and (not ours.is_file() or ours.read_text() == digest):
                return prefix
        return None

    if not found():
        with _lock(folder, name, progress):
            if not found():
                progress(f"compiling {name} for ROS 2 {ros.release}, once")
                _install(_compiled(ros, folder / name, source, name), target, name, digest)
                shutil.rmtree(folder / name)
    return found() or target


def _compiled(ros: where.Ros, work: Path, source: Path, name: str) -> Path:
    """Compile a message package and install it, relocatable, below `work`."""
    shutil.rmtree(work, ignore_errors=True)
    shutil.copytree(source / name, work / "source")
    shutil.copy(source / "CMakeLists.txt", work / "source")
    libraries = ["$ORIGIN", "$ORIGIN/../../..", *(str(p / "lib") for p in ros.prefixes)]
    options = {
        "PACKAGE": name,
        "BUILD_TESTING": "OFF",
        "CMAKE_INSTALL_PREFIX": str(work / "install"),
        "CMAKE_INSTALL_RPATH": ";".join(libraries),
        "CMAKE_PREFIX_PATH": ";".join(map(str, ros.prefixes)),
        "Python3_EXECUTABLE": ros.python(),
    }
    for joined in ("ON", "OFF"):  # the generated files of another release of ROS 2 may clash if they are joined
        try:
            _cmake(ros, work / "source", work / "build", options | {"JOINED": joined}, name, "--target", "install")
            break
        except RosMissingError:
            if joined == "OFF":
                raise
    return work / "install"


def _install(compiled: Path, target: Path, name: str, digest: str) -> None:
    """Copy a compiled package to its final place; the file that makes it visible, package.xml, comes last."""
    manifest = Path("share") / name / "package.xml"
    (target / manifest).unlink(missing_ok=True)
    (compiled / manifest.with_name(_OURS)).write_text(digest)
    leave = shutil.ignore_patterns("*.egg-info", manifest.name)  # uv takes an .egg-info for a package
    shutil.copytree(compiled, target, ignore=leave, dirs_exist_ok=True)
    shutil.copy(compiled / manifest, target / manifest)


def _extension(ros: where.Ros, folder: Path, package: Path, messages: dict[str, Path], progress: Progress) -> Path:
    import nanobind

    sources = (p for p in (HERE / "cpp").rglob("*") if p.suffix in (".cpp", ".hpp", ".txt"))
    headers = (p for p in (package / "include").rglob("*") if p.suffix in (".hpp", ".inl"))
    digest = _digest([*sources, *headers], nanobind.__version__, *map(str, messages.values()))
    target = folder / f"_ros-{digest}" / f"_ros{_SUFFIX}"
    if target.is_file():
        return target
    with _lock(folder, "nodes", progress):
        if not target.is_file():
            progress(f"compiling the nodes for ROS 2 {ros.release}, once (a minute or two)")
            options = {
                "PALPATE": str(package),
                "EIGEN": str(_eigen()),
                "PREFIXES": ";".join(dict.fromkeys(map(str, (*messages.values(), *ros.prefixes)))),
                "CMAKE_PREFIX_PATH": nanobind.cmake_dir(),
                "Python_EXECUTABLE": sys.executable,
            }
            _cmake(ros, HERE / "cpp", folder / "build", options, "the ROS 2 nodes")
            target.parent.mkdir(exist_ok=True)
            ready = target.with_suffix(".part")
            shutil.copy(folder / "build" / target.name, ready)
            ready.rename(target)
            for old in sorted(folder.glob("_ros-*"), key=lambda p: p.stat().st_mtime)[:-_KEPT]:
                shutil.rmtree(old, ignore_errors=True)
    return target


def _cmake(ros: where.Ros, source: Path, build: Path, options: dict[str, str], what: str, *more: str) -> None:
    """Configure and build; the output of the tools goes to a log file."""
    environment = ros.environment()
    for tool, package in (("cmake", "cmake"), ("ninja", "ninja-build"), ("g++", "g++")):
        if not shutil.which(os.environ.get("CXX", tool) if tool == "g++" else tool, path=environment["PATH"]):
            raise RosMissingError(
                f"{what} cannot be compiled", why=f"{tool} is not installed", mend=f"sudo apt install {package}"
            )
    build.mkdir(parents=True, exist_ok=True)
    log = build.parent / f"{build.parent.name}-{what.replace(' ', '-')}.log"
    defined = [f"-D{name}={value}" for name, value in (options | {"CMAKE_BUILD_TYPE": "Release"}).items()]
    with log.open("w") as output:
        for command in (
            ["cmake", "-G", "Ninja", "-S", str(source), "-B", str(build), *defined],
            ["cmake", "--build", str(build), *more],
        ):
            if subprocess.run(command, env=environment, stdout=output, stderr=output, check=False).returncode:
                lines = log.read_text(errors="replace").splitlines()
                first = next((i for i, line in enumerate(lines) if "rror" in line), max(0, len(lines) - 12))
                raise RosMissingError(
                    f"{what} cannot be compiled",
                    where=ros.words,
                    why="\n    ".join(lines[first : first + 12]),
                    mend=f"correct the cause, then run `palpate ros setup`; the whole log is {log}",
                )


def _eigen() -> Path:
    from palpate import _core

    packages = Path(_core.__file__).parents[1]
    for place in (*(Path(p) / "cmeel.prefix" for p in (str(packages), *sys.path)), Path("/usr")):
        if (place / "include" / "eigen3" / "Eigen" / "Core").is_file():
            return place / "include" / "eigen3"
    raise RosMissingError(
        "Eigen's headers are not installed", mend="run make setup in your clone, or pip install cmeel-eigen"
    )


def _digest(files: Iterable[Path], *words: str) -> str:
    digest = hashlib.sha256("\0".join(words).encode())
    for file in sorted(files):
        digest.update(file.name.encode() + b"\0" + file.read_bytes())
    return digest.hexdigest()[:16]


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "palpate" / "ros"


def _prepend(variable: str, place: Path) -> None:
    """Prepend a folder to a search path of this process; rcl searches it for plug-ins."""
    places = [p for p in os.environ.get(variable, "").split(os.pathsep) if p and p != str(place)]
    os.environ[variable] = os.pathsep.join([str(place), *places])


@contextmanager
def _lock(folder: Path, what: str, progress: Progress) -> Iterator[None]:
    """Let one process compile this part at a time; the system releases the lock even if the process dies."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{what}.lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            progress("waiting for another process that compiles")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield
