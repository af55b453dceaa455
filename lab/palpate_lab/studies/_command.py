"""Common base of all study commands: options, execution, and output of tables and files.

A study is a folder. ``command.py`` contains its options (a `Study`, or a `SweepStudy` if it evaluates a function over a
grid), ``work.py`` its computation, and ``words.py`` and ``figures.py`` the presentation of the result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

from rich.console import Console, RenderableType
from tyro.conf import arg

from palpate.base.arrays.plain import finite, plain
from palpate.base.errors import JournalError, MissingExtraError
from palpate.base.sweep import Axis, Label, Swept, sweep
from palpate.base.sweep.grid import Point
from palpate.base.sweep.work import Function
from palpate.cli.terminal.output import console_for, make_folder, require_writable, say, write_json


@dataclass(frozen=True)
class Findings:
    """Result of a study."""

    json: Any
    """Content of ``--json``, a documented contract."""
    draw: Callable[[Path], Iterable[Path]]
    """Draws the pictures into a folder and returns their files."""
    report: Sequence[RenderableType] = ()
    """Tables and lines of text for the terminal."""


@dataclass
class Study:
    """Base class of a study command: computation, tables, pictures and JSON, in this order."""

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the numbers as JSON to this file (docs/json.md); - for the standard output."""
    figures: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for the pictures; default: runs/study-NAME."""

    def study(self, console: Console) -> Findings:
        """Compute the result of the study; every study implements this method."""
        raise NotImplementedError

    def __call__(self) -> int:
        """Compute the result, print its tables, draw its pictures, and write the JSON."""
        console, folder = console_for(self.json), self.figures or self.folder
        require_writable(self.json)
        make_folder(folder)
        if find_spec("matplotlib") is None:  # reported before the computation starts
            raise MissingExtraError("what draws the pictures of a study", "report")
        findings = self.study(console)
        for part in findings.report:
            if isinstance(part, str):
                say(console, part)
            else:
                console.print(part)
        for file in findings.draw(folder):
            say(console, str(file), "picture")
        write_json(self.json, finite(plain(findings.json)))  # an interval of too few units has no ends
        return 0

    @property
    def name(self) -> str:
        """Name of the study, which is the name of its folder."""
        return type(self).__module__.removesuffix(".command").rpartition(".")[2]

    @property
    def folder(self) -> Path:
        """Default folder of the study's files."""
        return Path("runs") / f"study-{self.name}"


class Sweeper(Protocol):
    """``palpate.base.sweep.sweep`` with the options of the command line already bound."""

    def __call__(
        self,
        fn: Function,
        grid: Mapping[str, Axis | Iterable[Any]],
        seed: int = 0,
        *,
        title: str = "",
        where: Callable[[Point], bool] | None = None,
        labels: Mapping[str, Label] | None = None,
    ) -> Swept:
        """Run one sweep of a study; further sweeps need a title, which becomes part of their file names."""
        ...


@dataclass
class SweepStudy(Study):
    """Base class of a study that runs a sweep on all cores or on a Dask cluster and can be resumed."""

    executor: Literal["local", "dask"] = "local"
    """local: processes of this machine; dask: a Dask cluster. Both compute identical numbers."""
    address: Annotated[str | None, arg(metavar="TCP://HOST:PORT")] = None
    """Address of an existing Dask scheduler; without it, --executor dask starts a cluster on this machine."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Number of processes on this machine; default: one per core."""
    resume: Annotated[Path | None, arg(metavar="FILE")] = None
    """Journal to continue or to create; default: a journal in the study's folder, deleted when the study is done."""
    out: Annotated[Path | None, arg(metavar="FILE.nc")] = None
    """NetCDF file for the labelled results; default: runs/study-NAME/NAME.nc."""

    def sweeper(self, console: Console) -> Sweeper:
        """The sweep function for this command; each finished sweep is written as NetCDF."""

        def run(
            fn: Function, grid: Mapping[str, Axis | Iterable[Any]], seed: int = 0, *, title: str = "", **more: Any
        ) -> Swept:
            out = _titled(self.out or self.folder / f"{self.name}.nc", title)
            journal = _titled(self.resume, title) if self.resume else out.with_suffix(".journal")
            make_folder(out.parent)
            more |= {"executor": self.executor, "address": self.address, "workers": self.workers, "console": console}
            more |= {"resume": journal, "title": f"{self.name} {title}".rstrip()}
            try:
                swept = self._swept(journal, fn, grid, seed, **more)
            except KeyboardInterrupt:
                say(console, f"finished points are kept in {journal}: run the same command again to continue")
                raise
            swept.to_netcdf(out)
            say(console, str(out), "data")
            if not self.resume:
                journal.unlink()
            return swept

        return run

    def _swept(self, journal: Path, *args: Any, **more: Any) -> Swept:
        try:
            return sweep(*args, **more)
        except JournalError:
            if self.resume:
                raise
            journal.unlink()  # the journal belongs to another version or to other options
            return sweep(*args, **more)


def _titled(file: Path, title: str) -> Path:
    return file.with_stem(f"{file.stem}-{title}") if title else file
