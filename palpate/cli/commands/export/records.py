"""`palpate export RECORD...`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json


@dataclass
class Command:
    """Write records as a data set: LeRobot with forces, as Open-H-Embodiment or the dVRK name it, or as tables.

    examples:
      palpate export runs/*/record.mcap --to lerobot --out dataset
      palpate export record.mcap --to parquet --out tables

    Also takes folders of runs and ROS 2 bags of a dVRK. The folder appears whole, at the end.
    """

    records: Positional[tuple[Path, ...]]
    """Records (MCAP), folders of runs, or ROS 2 bags of a CRTK session; each becomes an episode or a table."""
    out: Annotated[Path, arg(metavar="DIR")]
    """Folder of the data set; new, or empty."""
    to: Annotated[str, arg(metavar="FORMAT")] = "lerobot"
    """lerobot, minari, parquet, csv, mat, hdf5, rerun, or one of an installed package."""
    names: Literal["openh", "dvrk"] = "openh"
    """lerobot: names of Open-H-Embodiment, or of the dVRK's data collection."""
    version: Literal["3.0", "2.1"] = "3.0"
    """lerobot: version of the format."""
    fps: Annotated[int, arg(metavar="HZ")] = 30
    """lerobot, minari: frames per second."""
    task: Annotated[str, arg(metavar="TEXT")] = ""
    """lerobot, minari: instruction of all episodes; named after the scene when left out."""
    video: bool = False
    """lerobot: also render what both eyes of the endoscope see, 1280 x 720 as H.264 (docs/demonstrations.md)."""
    mixed: bool = False
    """lerobot, minari: allow records of different scenes in one data set."""
    keep_records: bool = False
    """lerobot: also copy the records, which hold every tick, into the data set."""
    forces: Annotated[Path | None, arg(metavar="RECORD")] = None
    """bags: a record of the haptic node that ran meanwhile; its forces are exported with them, by the wall clock."""
    signals: Annotated[tuple[str, ...], arg(metavar="NAME")] = ()
    """tables: names of signals; all that were recorded when left out."""
    every: Annotated[int, arg(metavar="N")] = 1
    """tables: keep each n-th tick."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write facts of the data set as JSON (docs/json/export.md); - for the standard output."""

    def __call__(self) -> int:
        """Export the records and say what was written."""
        from palpate.export import Options, export

        console = console_for(self.json)
        require_writable(self.json)
        options = Options(
            self.names,
            self.version,
            self.fps,
            self.task,
            self.video,
            self.keep_records,
            self.mixed,
            self.forces,
            self.signals,
            self.every,
        )
        facts = export(self.records, self.out, self.to, options)
        if "splits" in facts:
            shares = ", ".join(f"{name} {span}" for name, span in facts["splits"].items())
            say(console, f"{facts['episodes']} episodes, {facts['frames']} frames at {facts['fps']} frames/s; {shares}")
        for file, rows in zip(facts.get("files", ()), facts.get("rows", ()), strict=True):
            say(console, f"{file}: {rows} rows")
        say(console, str(self.out), "wrote")
        write_json(self.json, facts)
        return 0
