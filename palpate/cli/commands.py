"""The commands and their options. tyro turns these dataclasses into the command line and its help."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal, Union

import tyro
from tyro.conf import FlagCreatePairsOff, Positional, arg, subcommand

PORT = 8080


@dataclass
class Run:
    """Run a scene: the simulated hand palpates, the run is recorded and summed up.

    examples:
      palpate run scenes/palpation.yaml
      palpate run scenes/liver.yaml --headless --duration 5 --json run.json
      palpate run my.yaml --realtime --seed 7 --out /data/runs

    With a terminal it runs in real time and then serves the 3-D viewer until Ctrl-C; without one, or with
    --headless, it runs as fast as the machine can and ends by itself. Ctrl-C stops at any moment: the record is
    closed, the summary is printed, the exit code is 130.
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    headless: bool = False
    """No viewer, even with a terminal; lockstep unless --realtime is given."""
    duration: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Simulated time [s]; the scene's when left out."""
    realtime: bool = False
    """At the pace of the clock, in a real-time thread."""
    fast: bool = False
    """Lockstep, as fast as the machine can: the same scene and seed give the same record, byte for byte."""
    seed: int | None = None
    """Instead of the scene's seed [-]."""
    out: Annotated[Path | None, arg(metavar="DIR")] = None
    """Folder for records and reports; the scene's record.folder when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - writes it to the standard output, everything else to stderr."""
    serve: bool = False
    """Serve the viewer after the run even without a terminal."""
    port: int = PORT
    """Of the viewer, on 127.0.0.1; the next free one when it is taken."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.run import run

        return run(self)


@dataclass
class Replay:
    """Sum up a record, or the ROS 2 bag of a CRTK session, and show it in the 3-D viewer until Ctrl-C.

    examples:
      palpate replay runs/palpation-20260101-120000/record.mcap
      palpate replay rosbag2_2026_01_01-12_00_00 --scene my.yaml
    """

    record: Positional[Path]
    """Record (MCAP), or the folder it is in; or a rosbag2 (folder, .mcap, .db3)."""
    scene: Annotated[Path | None, arg(metavar="FILE")] = None
    """Of a bag: the arms' models and bases and what stood before them; the scene in the bag when left out."""
    port: int = PORT
    """Of the viewer, on 127.0.0.1; the next free one when it is taken."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.records import replay

        return replay(self.record, self.port, self.scene)


@dataclass
class Report:
    """Sum up a record, or the ROS 2 bag of a CRTK session, and write its HTML report with figures.

    examples:
      palpate report runs/palpation-20260101-120000/record.mcap
      palpate report run.mcap --out liver.html
      palpate report rosbag2_2026_01_01-12_00_00
    """

    record: Positional[Path]
    """Record (MCAP), or the folder it is in; or a rosbag2 (folder, .mcap, .db3)."""
    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """Where to write it; report.html beside the record when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the summary as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.records import report

        return report(self.record, self.out, self.json)


@dataclass
class Check:
    """Look at a scene, a mesh or a distance grid without running it: what is wrong, what was mended, what is in reach.

    examples:
      palpate check scenes/palpation.yaml
      palpate check organ.stl --unit mm
      palpate check scan.ply --unit m --feature 4 --noise 0.3
      palpate check organ.stl --repair mended.stl

    A repaired copy has its cracks sewn, slivers collapsed and small holes filled; the file itself is never changed.
    """

    file: Positional[Path]
    """Scene (YAML), mesh (STL, OBJ, PLY, ...) or distance grid (.npz, .nrrd)."""
    unit: Literal["mm", "cm", "m", "in"] = "mm"
    """Of a mesh file's numbers."""
    radius: Annotated[float | None, arg(metavar="MM")] = None
    """Of the sphere that will touch the mesh; the default radius when left out."""
    stiffness: Annotated[float | None, arg(metavar="N/M")] = None
    """That the mesh will have; the default stiffness when left out."""
    feature: Annotated[float | None, arg(metavar="MM")] = None
    """Width of the narrowest thing to be felt; from the mesh's hollows when left out."""
    noise: Annotated[float | None, arg(metavar="MM")] = None
    """Standard deviation of the sensor that measured the mesh; from its roughness when left out."""
    repair: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write a repaired copy of the mesh, in the same unit."""
    hole: Annotated[float | None, arg(metavar="MM")] = None
    """Widest hole that --repair fills; a tenth of the mesh when left out."""
    force: bool = False
    """--repair may overwrite a file."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the findings as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.check import check
        from palpate.cli.check_mesh import Touch

        touch = Touch.of(self.radius, self.stiffness, self.feature, self.noise, self.repair, self.hole, self.force)
        return check(self.file, self.unit, touch, self.json)


@dataclass
class Certify:
    """Say before a run which stiffness is stable with a scene's arms, loop and hand, and why.

    examples:
      palpate certify scenes/palpation.yaml
      palpate certify my.yaml --json certificate.json --figure certificate.png

    The stability boundary is exact for small motions: sampling, delay, the follower's servo and every filter are in it
    (docs/certificate.md).
    """

    scene: Positional[Path]
    """Scene file (YAML)."""
    figure: Annotated[Path | None, arg(metavar="FILE.png")] = None
    """Draw the boundary in the plane of damping and stiffness."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the certificate as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.certify import certify

        return certify(self)


@dataclass
class Bench:
    """Measure this machine: the haptic loop, contact queries, virtual fixtures, studies on several cores, ROS 2.

    examples:
      palpate bench loop
      palpate bench sweep
      palpate bench guidance
      palpate bench ros --duration 600 --json ros.json
      palpate bench contact --json contact.json
      palpate bench contact --quick
      palpate bench contact --huge
    """

    what: Positional[Literal["loop", "contact", "sweep", "guidance", "ros"]]
    """loop: compute time, real-time factor, lateness; contact: the table of shapes and methods; sweep: many wall
    runs on one core and on all; guidance: a fixture on a million triangles, a hundred constraints; ros: a leader's
    state to its wrench over ROS 2, beside a bare echo."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    huge: bool = False
    """contact: ten million triangles instead (2.5 GB of memory, minutes)."""
    quick: bool = False
    """contact: ten thousand triangles alone (half a minute)."""
    duration: float = 20.0
    """ros: time that is measured [s]."""
    rate: float = 1000.0
    """ros: of the leader's states [Hz]."""
    sim: bool = False
    """ros: what `palpate ros sim` takes and reaches with four arms, too."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.bench import bench

        return bench(self)


@dataclass
class Fuzz:
    """Random meshes, tool paths or mesh files against what must hold whatever comes in.

    examples:
      palpate fuzz contact --runs 100000
      palpate fuzz files --seed 4711 --runs 1
    """

    target: Positional[Literal["contact", "files"]]
    """contact: triangle soups and tool paths through every method; files: spoilt mesh files through the readers."""
    runs: int = 2000
    """Cases; each has the next seed [-]."""
    seed: int = 0
    """Of the first case: a fault is repeated by its seed [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the outcome as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.fuzz import fuzz

        return fuzz(self.target, self.runs, self.seed, self.json)


@dataclass
class Soak:
    """Millions of short random pokes at random meshes: no tool may pop through a surface.

    examples:
      palpate soak contact
      palpate soak contact --passes 100000 --seed 7
      palpate soak contact --passes 2000 --method penalty
    """

    what: Positional[Literal["contact"]]
    """contact: the proxy's way judged triangle by triangle."""
    passes: int = 10_000_000
    """Pokes of about 60 ticks each [-]."""
    method: str = "proxy"
    """Contact method; `penalty` shows what a method without memory does."""
    seed: int = 1
    """The same seed gives the same meshes and passes [-]."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the count as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.soak import soak

        return soak(self.passes, self.method, self.seed, self.json)


@dataclass
class PathOf:
    """Write the way of the tool in a record as a path that a fixture follows.

    examples:
      palpate path runs/demonstration/record.mcap --out suture.csv
      palpate path record.mcap --out cut.csv --start 2 --end 9.5 --smooth 0.5

    The way is sampled evenly along its length (pauses count nothing), smoothed there by a Gaussian, and thinned; what
    is left of the demonstration is told. In a scene: guidance: [follow: suture.csv].
    """

    record: Positional[Path]
    """Record (MCAP), or the folder it is in."""
    out: Annotated[Path, arg(metavar="FILE.csv")] = Path("path.csv")
    """Places and attitudes, with a header that says the unit."""
    spacing: Annotated[float, arg(metavar="MM")] = 2.0
    """Of the places that are kept."""
    smooth: Annotated[float, arg(metavar="MM")] = 1.0
    """Standard deviation of the Gaussian along the way; 0: none."""
    start: Annotated[float | None, arg(metavar="SECONDS")] = None
    """Where the demonstration begins in the record."""
    end: Annotated[float | None, arg(metavar="SECONDS")] = None
    """And where it ends."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write what was found as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.guidance import record_path

        begin, end = self.start or 0.0, float("inf") if self.end is None else self.end
        return record_path(self.record, self.out, 1e-3 * self.spacing, 1e-3 * self.smooth, (begin, end), self.json)


@dataclass
class GridOf:
    """Make a signed distance grid of a closed mesh, and say how far it is from the exact distance.

    examples:
      palpate grid vessel.stl --spacing 0.5
      palpate grid organ.stl --unit m --out organ.npz

    A grid answers in the same time whatever the mesh is made of; at most 512 x 512 x 512 nodes.
    """

    mesh: Positional[Path]
    """Mesh file (STL, OBJ, PLY, ...), closed."""
    spacing: Annotated[float | None, arg(metavar="MM")] = None
    """Of the nodes; a hundredth of the mesh when left out. Walls thinner than two of them are lost."""
    unit: Literal["mm", "cm", "m", "in"] = "mm"
    """Of the mesh file's numbers."""
    out: Annotated[Path | None, arg(metavar="FILE.npz")] = None
    """The grid; beside the mesh when left out."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.guidance import grid

        return grid(self.mesh, None if self.spacing is None else 1e-3 * self.spacing, self.unit, self.out, self.json)


@dataclass
class Schema:
    """Print the JSON Schema of scene files, for editors that complete them.

    examples:
      palpate schema > scene.schema.json
    """

    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write it to a file instead."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.output import write_text
        from palpate.scene.schema import schema_text

        if self.out is None:
            print(schema_text(), end="")
        else:
            write_text(self.out, schema_text())
        return 0


@dataclass
class Study:
    """Studies: many runs, one table and one picture. `palpate study` lists them."""


@dataclass
class Calibrate:
    """From recordings of an arm to a model of it. `palpate calibrate` lists what can be identified."""


@dataclass
class Ros:
    """On ROS 2: a simulated dVRK, and the node that makes a CRTK master feel. `palpate ros` lists the commands."""


_COMMANDS = {
    "run": Run,
    "replay": Replay,
    "report": Report,
    "check": Check,
    "certify": Certify,
    "study": Study,
    "calibrate": Calibrate,
    "bench": Bench,
    "fuzz": Fuzz,
    "soak": Soak,
    "ros": Ros,
    "path": PathOf,
    "grid": GridOf,
    "schema": Schema,
}


def _studies() -> dict[str, type]:
    from palpate.studies import commands

    return commands()


def _calibrations() -> dict[str, type]:
    from palpate.cli.calibrate import COMMANDS

    return COMMANDS


def _ros() -> dict[str, type]:
    from palpate.cli.ros import COMMANDS
    from palpate.ros import where

    where.settle()
    return COMMANDS


_GROUPS = {"study": (Study, _studies), "calibrate": (Calibrate, _calibrations), "ros": (Ros, _ros)}


def dispatch(args: Sequence[str]) -> int:
    """Parse the arguments and run the command; wrong arguments exit with 2 and say what is possible."""
    if args and args[0] in _GROUPS:
        group, members = _GROUPS[args[0]]
        return _parse(f"palpate {args[0]}", group.__doc__ or "", members(), args[1:])
    told = (
        "Feel virtual and scanned anatomy through a surgical robot's master arm.\n\n"
        "examples:\n  palpate run scenes/palpation.yaml\n  palpate check my_organ.stl\n  palpate run --help"
    )
    return _parse("palpate", told, _COMMANDS, args)


def _parse(prog: str, description: str, commands: dict[str, type], args: Sequence[str]) -> int:
    config = (FlagCreatePairsOff,)
    if args and args[0] in commands:
        command: Any = tyro.cli(commands[args[0]], prog=f"{prog} {args[0]}", args=args[1:], config=config)
        return int(command())
    tyro.cli(_choice(commands), prog=prog, description=description, args=args[:1] or ["--help"], config=config)
    return 0  # tyro has listed the commands and left, with 2 where there is no such command


def _choice(commands: dict[str, type]) -> Any:
    """The commands as one type, each told by the first line of its help."""
    told = (
        Annotated[command, subcommand(name, description=(command.__doc__ or "").partition("\n")[0])]
        for name, command in commands.items()
    )
    return Union[tuple(told)]  # noqa: UP007 - made at run time
