"""Opens a ROS 2 bag with the library rosbags, whose unpacking and metadata get the limits of `palpate.base.limits`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

from palpate.base import limits
from palpate.base.arrays.yaml_loader import MOST_OF_PLAN, read_yaml
from palpate.base.errors import MissingExtraError, RecordError
from palpate.record.bags.recover import needs_recovery, recover
from palpate.record.mcap_scan import require_unpackable

_ROS_1 = b"#ROSBAG V"
_SUFFIXES = (".mcap", ".db3", ".zstd")


@contextmanager
def open_bag(path: Path) -> Iterator[Any]:
    """The reader of a bag: its folder, an ``.mcap`` or a ``.db3``.

    It is rosbags' ``AnyReader`` with two attributes: ``undecodable``, types whose definition in the bag cannot be read,
    with the reason (where such a type is one of ROS, the definition of ROS is used), and ``notes``, files that are cut
    off or damaged, which are read up to there.

    Raises:
        RecordError: the bag is missing, damaged, or unfolds to more than any bag.
        MissingExtraError: the library rosbags is not installed.
    """
    try:
        reader = _reader_class()
    except ModuleNotFoundError as missing:
        raise MissingExtraError("rosbags, which reads ROS 2 bags,", "ros") from missing
    _bounded()
    refuse_ros_1(path)
    try:
        for file in sorted(path.rglob("*")) if path.is_dir() else [path]:
            if file.suffix in _SUFFIXES:
                limits.require_file(file)
                if file.suffix == ".mcap":
                    require_unpackable(file)
            elif file.name == "metadata.yaml":
                read_yaml(file, MOST_OF_PLAN)
        with TemporaryDirectory(prefix="palpate-bag-") as folder:
            paths, notes = _readable(path, Path(folder))
            with reader(paths) as opened:
                opened.notes = notes
                yield opened
    except (RecordError, MissingExtraError):
        raise
    except (Exception, RecursionError) as error:  # damaged files make rosbags raise many types of exception
        mend = "ros2 bag info checks it; a bag that was cut short is mended by ros2 bag reindex"
        why = " ".join(str(error).split())[:300] or type(error).__name__
        raise RecordError("the bag cannot be read", where=str(path), why=why, mend=mend) from error


def refuse_ros_1(path: Path) -> None:
    """Refuse a bag of ROS 1 by name. Raises RecordError."""
    if path.is_file() and path.stat().st_size > len(_ROS_1):
        with path.open("rb") as file:
            if file.read(len(_ROS_1)) == _ROS_1:
                mend = f"rosbags-convert --src {path.name} --dst {path.stem} converts it (pip install rosbags)"
                raise RecordError("a bag of ROS 1, not of ROS 2", where=str(path), mend=mend)


def _readable(path: Path, folder: Path) -> tuple[list[Path], list[str]]:
    """Paths that rosbags can open, and what was done to damaged files, whose whole part is copied into a folder."""
    files = sorted(path.glob("*.mcap")) if path.is_dir() else [path] if path.suffix == ".mcap" else []
    broken = [file for file in files if needs_recovery(file)]
    if not broken and (not path.is_dir() or _has_storage(path)):
        return [path], []
    paths, notes = [], []
    for k, file in enumerate(files):
        if file in broken:
            end = recover(file, folder / f"{k}.mcap")
            notes += [f"{file.name}: {end}; read up to there"] if end else []
        paths.append(folder / f"{k}.mcap" if file in broken else file)
    return paths or sorted(path.glob("*.db3")) or [path], notes


def _has_storage(folder: Path) -> bool:
    """Whether the metadata of a bag name its storage: `ros2 bag reindex` may leave it empty."""
    try:
        found = read_yaml(folder / "metadata.yaml", MOST_OF_PLAN)["rosbag2_bagfile_information"]
        return bool(found["storage_identifier"])
    except (OSError, KeyError, TypeError, ValueError):
        return False


@cache
def _reader_class() -> Any:
    from rosbags.highlevel import AnyReader
    from rosbags.interfaces import MessageDefinitionFormat
    from rosbags.typesys import Stores, get_types_from_idl, get_types_from_msg, get_typestore

    def defined(connection: Any) -> dict[str, Any]:
        text, separator = connection.msgdef.data, "=" * 80 + "\n"
        if connection.msgdef.format == MessageDefinitionFormat.MSG:
            return dict(get_types_from_msg(text, connection.msgtype))
        parts = [one.partition("\n")[2] for one in text.split(separator)[1:]] if text.startswith(separator) else [text]
        return {name: one for part in parts for name, one in get_types_from_idl(part).items()}

    class Reader(AnyReader):  # type: ignore[misc, unused-ignore]
        """A reader that goes on where the definition of one type cannot be read."""

        def _open(self) -> None:
            self.undecodable: dict[str, str] = {}
            assert self.stack is not None
            for reader in self.readers:
                self.stack.enter_context(reader)
            self.connections = [one for reader in self.readers for one in reader.connections]
            self.typestore = get_typestore(Stores.EMPTY)
            for one in self.connections:
                if one.msgdef.format != MessageDefinitionFormat.NONE:
                    try:
                        self.typestore.register(defined(one))
                    except (Exception, RecursionError) as error:
                        self.undecodable[one.msgtype] = " ".join(str(error).split())[-80:] or type(error).__name__
            known = get_typestore(Stores.LATEST).fielddefs
            self.typestore.register({n: one for n, one in known.items() if n not in self.typestore.fielddefs})

    return Reader


@cache
def _bounded() -> None:
    """Exchange the functions by which rosbags unpacks data for ones that end at a limit."""
    from rosbags.rosbag2 import reader, storage_mcap

    packed: dict[str, Callable[[bytes, int], bytes]] = {
        kind: lambda data, size, kind=kind: limits.unpack(data, kind, size)  # type: ignore[misc]
        for kind in ("", "zstd", "lz4")
    }
    storage_mcap.DECOMPRESSORS.clear()
    storage_mcap.DECOMPRESSORS.update(packed)
    reader.zstd = SimpleNamespace(  # type: ignore[attr-defined, assignment]
        decompress=limits.unzstd, open=lambda file, mode: limits.zstd_stream(file)
    )
