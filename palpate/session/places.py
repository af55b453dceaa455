"""Places of the follower recorded by a pedal, as starts and goals of plans (`palpate plan --through places.yaml`).

recorder = PlaceRecorder(session, Path("places.yaml"))     # each press of the pedal `coag` stores the joints
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from palpate.base.errors import OutputError

if TYPE_CHECKING:
    from palpate.session.console import Console
    from palpate.session.session import Session

KIND = "palpate places 1"
PEDAL = "coag"
"""The pedal that records; it has no other effect."""


class PlaceRecorder:
    """Stores the measured joints of the follower at each press of a pedal: start, way points, goal.

    Args:
        session: the session, whose console has the pedal.
        file: YAML file, written anew at each press.
        pedal: name of the pedal.
        console: the console with the pedal, of several pairs; that of the session when left out.

    Raises:
        OutputError: the file cannot be written.
    """

    def __init__(self, session: Session, file: Path, pedal: str = PEDAL, console: Console | None = None) -> None:
        self._session, self._file, self._pedal = session, file, pedal
        self.places: list[list[float]] = []  #: joints (n,) [rad, m] of each press
        self._write()
        (console or session.console).on_change(self._changed)

    def _changed(self, pedal: str, down: bool) -> None:
        if pedal != self._pedal or not down:
            return
        n = self._session.rig.arms.follower.n
        q = np.asarray(self._session.latest()["q_follower"])[:n]
        self.places.append([round(float(x), 9) for x in q])
        try:
            self._write()
        except OutputError as error:  # the run goes on
            self._session.notes.append(error.what)

    def _write(self) -> None:
        data: dict[str, Any] = {
            "kind": KIND, "joint_names": list(self._session.rig.arms.follower.joint_names),
            "places": [{"joints": joints} for joints in self.places],
        }  # fmt: skip
        try:
            self._file.write_text(yaml.safe_dump(data, sort_keys=False, default_flow_style=None), encoding="utf-8")
        except OSError as error:
            raise OutputError("the places cannot be written", where=str(self._file), why=str(error)) from None
