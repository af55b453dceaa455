"""`palpate replay`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from tyro.conf import Positional, arg

from palpate.base import stop_signals
from palpate.cli.terminal import HOST, PORT
from palpate.cli.terminal.output import console_for, say

if TYPE_CHECKING:
    from rich.console import Console

    from palpate.record.bags import Bag
    from palpate.record.reader import Record


@dataclass
class Command:
    """Summarise a record, or the ROS 2 bag of a CRTK session, and show it in the 3-D viewer until Ctrl-C.

    examples:
      palpate replay runs/palpation-20260101-120000/record.mcap
      palpate replay rosbag2_2026_01_01-12_00_00 --scene my.yaml
      palpate replay record.mcap --to rerun --out run.rrd
    """

    record: Positional[Path]
    """Record (MCAP), or its folder; the folder of a run of several pairs; or a rosbag2 (folder, .mcap, .db3)."""
    scene: Annotated[Path | None, arg(metavar="FILE")] = None
    """Scene of a bag, with the arms' models and bases and the objects; the scene in the bag when left out.
    With --to rerun, also the scene that is shown instead of a record's own."""
    port: int = PORT
    """Port of the viewer; the next free one when it is taken."""
    host: str = HOST
    """Address on which the viewer listens: 127.0.0.1 for this machine only; others ask for the printed token."""

    to: Literal["viewer", "rerun"] = "viewer"
    """viewer: our own; rerun: write a file for Rerun (rerun-sdk), with every signal and the scene."""
    out: Annotated[Path | None, arg(metavar="FILE")] = None
    """File for rerun; the name of the run with .rrd when left out."""

    def __call__(self) -> int:
        """Print the summary of the record and show it until Ctrl-C."""
        if self.to == "rerun":
            return self._to_rerun()
        from palpate.cli.terminal.view import require_viewer
        from palpate.record.bags.open import open_any
        from palpate.record.reader import Record

        require_viewer()
        from palpate.report.pairs import pair_records

        console = console_for(None)
        if pair_records(self.record):
            self._show_pairs(console)
            return 0
        found = open_any(self.record)
        if isinstance(found, Record):
            self._show_record(found, console)
        else:
            self._show_bag(found, console)
        return 0

    def _to_rerun(self) -> int:
        """Write the record for Rerun."""
        from palpate.base.errors import OutputError
        from palpate.export.demonstration import demonstrations
        from palpate.export.folder import whole_folder
        from palpate.export.formats.rerun import write
        from palpate.export.options import Options
        from palpate.scene import Scene

        console = console_for(None)
        scene = None if self.scene is None else Scene.load(self.scene)
        runs = demonstrations([self.record])
        out = self.out or Path(f"{runs[0].name}.rrd")
        if len(runs[0].arms) > 1:
            mend = f"palpate export {self.record} --to rerun --out DIR writes one for each"
            raise OutputError("a run of several pairs gives several files", where=str(self.record), mend=mend)
        with whole_folder(out.with_name(f".{out.name}.parts")) as draft:
            (file,) = write(runs, draft, Options(), scene)["files"]
            (draft / str(file)).replace(out)
        out.with_name(f".{out.name}.parts").rmdir()
        say(console, f"{out}   (rerun {out} shows it)", "wrote")
        return 0

    def _show_record(self, record: Record, console: Console) -> None:
        from palpate.cli.terminal.view import serve
        from palpate.report.summary import summary_of, summary_table

        if record.note:
            say(console, record.note)
        console.print(summary_table(summary_of(record)))
        for fault in record.faults:
            say(console, fault, "fault:", "red")
        serve(record, self.port, console, self.host)

    def _show_pairs(self, console: Console) -> None:
        """Show all pairs of a run until Ctrl-C."""
        import threading

        from palpate.cli.terminal.view import free_port
        from palpate.record.reader import Record
        from palpate.report.pairs import pair_records
        from palpate.report.summary import summary_of, summary_table
        from palpate.viewer.pairs_replay import PairsReplayViewer

        records = {name: Record.open(path) for name, path in pair_records(self.record).items()}
        for name, record in records.items():
            say(console, name, "pair", "bold")
            console.print(summary_table(summary_of(record)))
        shown = PairsReplayViewer(records, self.record.resolve().name, self.host, free_port(self.port, self.host))
        try:
            say(console, f"viewer: {shown.url}   (Ctrl-C ends it)")
            stop_signals.wait(threading.Event())
        except KeyboardInterrupt:
            say(console, "viewer closed")
        finally:
            shown.close()

    def _show_bag(self, bag: Bag, console: Console) -> None:
        from palpate.cli.terminal.view import serve
        from palpate.record.bags.summary import table
        from palpate.viewer.bag import stage_and_ticks

        shown = stage_and_ticks(bag, self.scene)
        console.print(table(bag))
        for note in bag.notes:
            say(console, note)
        serve(shown, self.port, console, self.host)
