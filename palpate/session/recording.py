"""A loop with its record: ticks, totals, problems and the files of a run."""

from __future__ import annotations

import os
import threading
import time
import weakref
from collections.abc import Callable, Mapping
from datetime import datetime, timedelta
from pathlib import Path
from typing import TYPE_CHECKING

from palpate.base.arrays import Array
from palpate.record.snapshots import Snapshot
from palpate.record.ticks import Ticks, Timing, as_tick
from palpate.record.writer import CHUNKS_PER_SECOND, Recorder
from palpate.scene.rig import Rig
from palpate.session.backlog import Backlog
from palpate.session.recorded_frames import RecordedFrames
from palpate.session.run_folder import keep_scene, new_folder, require_writable
from palpate.session.snapshots import Snapshots
from palpate.session.summary import Summary, Totals

if TYPE_CHECKING:
    from palpate import _network
    from palpate.sensing.source import CloudFrame
    from palpate.session.loop import Loop


class RecordedLoop:
    """A loop whose ticks are counted and recorded; arguments and errors as those of `Session`."""

    paired = False
    """True if the record holds the signals of contact with other pairs."""
    linked = False
    """True if the record holds the signals of a remote site."""
    video: Callable[[], tuple[bytes, float] | None] | None = None
    """The newest JPEG picture of a remote camera and its delay [s], while a link has one."""

    plane: Callable[[], _network.ModelEstimate | None] | None = None
    """The plane that is felt where the scene has no object, while a link has one; None before the first."""

    def __init__(self, rig: Rig, loop: Loop, rate: float, seed: int, out: str | os.PathLike[str] | None) -> None:
        self.scene, self.rig, self.seed = rig.scene, rig, seed
        self.rate = rate  #: ticks per second [Hz]
        self._out = Path(out) if out is not None else None
        if self._out is not None:
            require_writable(self._out)
        self._loop = loop
        weakref.finalize(self, loop.stop)  # ramps the force to zero when the session is collected or Python ends
        self._recorder: Recorder | None = None
        self._closed = True
        self._totals = Totals(self.rate)
        self._live = False
        self._began = 0.0
        self._dropped = 0
        self._taken = 0  # ticks of all records
        self._lock = threading.RLock()  # only one thread at a time writes to the recorder
        self._limit = float("inf")  # size at which a record ends [bytes]
        self.recording = self._out is not None  #: False: no new record is begun after the present one
        self.record: Path | None = None  #: file of the newest record
        me = weakref.proxy(self)  # what the session holds must not hold the session: it ends when it is collected
        self._snapshots = Snapshots(
            rig, lambda index: me.soft_vertices(index), lambda: me._camera_joints(), lambda: me._body_places()
        )
        self._backlog = Backlog(round(rate / CHUNKS_PER_SECOND), lambda *block: me._keep(*block))
        self.notes: list[str] = []  #: problems outside of the loop, e.g. a full disk

    def latest(self) -> Ticks:
        """The newest tick as one row of `TICK`; never waits for the loop."""
        return as_tick(self._loop.latest())

    def soft_vertices(self, index: int) -> Array:
        """Deformed surface of a soft object, at most 16 ms old; never waits for the loop.

        Args:
            index: number of the object in the scene.

        Returns:
            Vertices (n, 3) in the object's frame O [m], in the order of ``_tissue.TissueSurface.vertices``.

        Raises:
            ValueError: the object does not exist or is not soft.
        """
        return self._loop.soft_vertices(index)

    @property
    def timing(self) -> Timing:
        """Compute time, lateness, slack and missed ticks of the loop (`Simulation.timing`)."""
        return self._loop.timing()

    def limit_record(self, size: float) -> None:
        """End each further record at a size, and begin no other one then [bytes]."""
        self._limit = size

    def set_recording(self, on: bool) -> None:
        """End the present record, also while the session runs; True begins a new one with the next tick."""
        self._backlog.finish()
        with self._lock:
            self._end_record(again=on)

    def _end_record(self, again: bool) -> None:
        if self._recorder is not None and not self._closed:
            self._recorder.close(self._faults(), self.timing)
        self.recording, self._closed = again, True

    @property
    def takes_snapshots(self) -> bool:
        """True if the record needs snapshots of soft objects, rigid bodies or the camera."""
        return self._out is not None and self.recording and self.scene.record.frames and self._snapshots.needed

    def take_snapshot(self) -> None:
        """Take a snapshot of the newest tick, if one is due."""
        if self.takes_snapshots:
            self._take_snapshot(float(self.latest()["t"]))

    def take_cloud(self, name: str, frame: CloudFrame, now: float) -> None:
        """Keep a frame of the sensor that an object is the cloud of for the record; now: session's time [s]."""
        if self._out is not None and self.recording:
            self._snapshots.take_cloud(name, frame, now)

    def _take_snapshot(self, t: float) -> None:
        self._snapshots.take(t)

    def _camera_joints(self) -> Array | None:
        """Joints of the endoscope arm, for snapshots; None if there is none."""
        return None

    def _body_places(self) -> Mapping[str, Array]:
        """Places of the rigid bodies that move, for snapshots (`World.drawn`)."""
        return {}

    def _take(self, ticks: Ticks, realtime: bool = False) -> None:
        """Count and record the next ticks (n,)."""
        with self._lock:  # no other thread ends the record in between
            self._keep(ticks, self._counted(ticks, realtime))

    def _take_behind(self, ticks: Ticks) -> None:
        """Count and record the next ticks (n,) of a lockstep run, in a thread behind the loop."""
        if self._limit < float("inf"):  # the record ends with the ticks that reach the limit
            self._take(ticks)
        else:
            self._backlog.add(ticks, self._counted(ticks, realtime=False))

    def _counted(self, ticks: Ticks, realtime: bool) -> list[Snapshot]:
        """Count the next ticks (n,) as taken, in a new record if the last one is closed; returns their snapshots."""
        self._begin(realtime)
        self._taken += len(ticks)
        return [] if self._recorder is None else self._snapshots.collect()

    def _keep(self, ticks: Ticks, snapshots: list[Snapshot]) -> None:
        """Count and record ticks (n,), in order of time."""
        with self._lock:
            self._totals.add(ticks)
            if self._recorder is not None:
                self._recorder.append(ticks, snapshots)
                if self._recorder.failure and self._recorder.failure not in self.notes:
                    self.notes.append(self._recorder.failure)
                if self._recorder.size > self._limit:
                    self._end_record(again=False)

    def _begin(self, realtime: bool) -> None:
        if not self._closed:  # without the lock, which the thread behind the loop may hold for milliseconds
            return
        with self._lock:
            self._closed = False
            self._totals = Totals(self.rate)
            self._live = realtime
            self._began = time.perf_counter()
            self._dropped = self._loop.dropped
            self.notes = []
            self._recorder, self.record = None, None
            if self._out is not None and self.recording:
                folder = self._new_folder()
                self.record = folder / "record.mcap"
                self.notes += keep_scene(folder, self.rig.resolved_yaml(absolute=True))
                now = datetime.now().astimezone()
                self._recorder = Recorder(
                    self.record,
                    self.rig.resolved_yaml(),
                    self.seed,
                    self.rate,
                    not realtime,
                    bag=True,
                    started=now - timedelta(seconds=float(self.latest()["t"])),
                    every=self.scene.record.step(self.rate),
                    signals=self.scene.record.signals,
                    tracked=bool(self.scene.trackers),
                    paired=self.paired or bool(self.scene.bodies),  # bodies are held, too
                    linked=self.linked,
                    extra=RecordedFrames(self.rig) if self.scene.record.frames else None,
                )

    def _finish(self, interrupted: bool) -> Summary:
        """Close the record and return the summary."""
        try:
            self._backlog.finish()
        except BaseException:
            with self._lock:
                self._end_record(again=self.recording)  # it is complete up to the ticks that failed
            raise
        with self._lock:
            faults = self._faults()
            timing = self.timing
            sha256 = None
            if self._recorder is not None and not self._closed:
                self._recorder.close(faults, timing)
                if self._recorder.failure and self._recorder.failure not in self.notes:
                    self.notes.append(self._recorder.failure)
                sha256 = self._recorder.sha256
            took = time.perf_counter() - self._began if not self._closed else 0.0
            summary = self._totals.summary(
                timing,
                instrument=Path(self.scene.arms.follower.model).stem,
                realtime=self._live,
                realtime_factor=round(self._totals.ticks / self.rate / took, 3) if took > 0 else 0.0,
                interrupted=interrupted,
                faults=(*faults, *self.notes),
                record=str(self.record) if self.record else None,
                record_sha256=sha256,
            )
            self._closed = True
            return summary

    def _new_folder(self) -> Path:
        """Make the folder of a run."""
        assert self._out is not None
        return new_folder(self._out, self.scene.title)

    def _faults(self) -> list[str]:
        fault = self._loop.fault()
        lost = self._loop.dropped - self._dropped
        faults = [fault] if fault else []
        recorded = self._recorder is not None
        where = (
            "the record: the disk was too slow" if recorded else "the summary: the computer was too busy to count them"
        )
        return [*faults, f"{lost} ticks are missing in {where}"] if lost > 0 else faults
