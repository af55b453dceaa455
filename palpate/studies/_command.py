"""What the commands of all studies have in common: their options, and the way from the work to tables and files.

A study is a folder: ``command.py`` holds its options (a `Study`, or a `SweepStudy` when it calls one function over a
grid), ``work.py`` what it computes, ``words.py`` and ``figures.py`` how the result is shown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any, Literal, Protocol

from rich.console import Console, RenderableType
from tyro.conf import arg

from palpate.console.output import console_for, make_folder, require_writable, say, write_json
from palpate.errors import JournalError, MissingExtraError
from palpate.sweep import Axis, Label, Swept, sweep
from palpate.sweep.grid import Point
from palpate.sweep.work import Function


@dataclass(frozen=True)
class Findings:
    """What a study found."""

    json: Any
    """the documented contract of its ``--json``."""
    draw: Callable[[Path], Iterable[Path]]
    """makes the pictures in a folder; their files."""
    told: Sequence[RenderableType] = ()
    """tables, and lines of text, for people."""


@dataclass
class Study:
    """A study: work, tables, pictures, JSON, in this order. ``study`` is what each one adds."""

    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the numbers as JSON (docs/json.md); - for the standard output."""
    figures: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for the pictures; runs/study-NAME when left out."""

    def study(self, console: Console) -> Findings:
        """The work."""
        raise NotImplementedError

    def __call__(self) -> int:
        """Do the work, print the tables, draw the pictures, write the JSON."""
        console, folder = console_for(self.json), self.figures or self.folder
        require_writable(self.json)
        make_folder(folder)
        if find_spec("matplotlib") is None:  # told before the work, not after it
            raise MissingExtraError("what draws the pictures of a study", "report")
        findings = self.study(console)
        for thing in findings.told:
            if isinstance(thing, str):
                say(console, thing)
            else:
                console.print(thing)
        for file in findings.draw(folder):
            say(console, str(file), "picture")
        write_json(self.json, findings.json)
        return 0

    @property
    def name(self) -> str:
        """Name of the study: that of its folder."""
        return type(self).__module__.removesuffix(".command").rpartition(".")[2]

    @property
    def folder(self) -> Path:
        """Where its files go."""
        return Path("runs") / f"study-{self.name}"


class Sweeper(Protocol):
    """``palpate.sweep.sweep`` with the choices of the command line already made."""

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
        """One sweep of a study; a second one has a title of its own, which its files bear."""
        ...


@dataclass
class SweepStudy(Study):
    """A study that is a sweep: on every core, on a Dask cluster, taken up again after a stop."""

    executor: Literal["local", "dask"] = "local"
    """local: processes of this machine; dask: a Dask cluster. The numbers are the same."""
    address: Annotated[str | None, arg(metavar="TCP://HOST:PORT")] = None
    """Of an existing Dask scheduler; without it --executor dask makes a cluster on this machine."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Processes on this machine; one per core when left out."""
    resume: Annotated[Path | None, arg(metavar="FILE")] = None
    """Journal to go on with, begun when it is not there. Without it a stopped study goes on by itself in its folder."""
    out: Annotated[Path | None, arg(metavar="FILE.nc")] = None
    """Labelled results as NetCDF; runs/study-NAME/NAME.nc when left out."""

    def sweeper(self, console: Console) -> Sweeper:
        """The sweep for this command; each one that is done is written as NetCDF."""

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
                say(console, f"kept in {journal}: the same command goes on from there")
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
            journal.unlink()  # of another version, or of other options
            return sweep(*args, **more)


def _titled(file: Path, title: str) -> Path:
    return file.with_stem(f"{file.stem}-{title}") if title else file
