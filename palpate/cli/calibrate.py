"""`palpate calibrate NAME`: the commands and their options; the work is in `palpate/identify`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg


@dataclass
class Gravity:
    """What holds an arm still, from poses it was held at: masses, springs, cables, and the friction that hides them.

    examples:
      palpate calibrate gravity poses.csv --arm mtmr --out my_mtmr.yaml
      palpate calibrate gravity up.csv down.csv --arm mtml --out mtml.yaml --test others.csv --json fit.json

    A recording is a CSV of q1_rad .. q7_rad, tau1_Nm .. tau7_Nm, joint side, one row per pose in the order of visits.
    Beside MODEL.yaml a figure MODEL.png is written. In a scene: arms: {leader: {gravity_model: MODEL.yaml}}.
    """

    train: Positional[tuple[Path, ...]]
    """Recordings to learn from (CSV); two files of the same poses reached both ways are averaged."""
    arm: Literal["mtml", "mtmr"]
    """Which arm was recorded."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    model: Literal["potential", "dvrk", "gravity+springs", "paper"] = "potential"
    """Form of the model: ours, the dVRK's, or the paper's with or without springs."""
    test: Annotated[Path | None, arg(metavar="TEST.csv")] = None
    """Other poses to judge on."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.gravity import gravity

        return gravity(self)


@dataclass
class Hand:
    """Mass, damping and stiffness of a hand, from a recorded grip that was pushed (load cell needed).

    examples:
      palpate run scenes/grip.yaml --out grip
      palpate calibrate hand grip/grip-*/record.mcap --out my_hand.yaml
      palpate calibrate hand grip.csv --json hand.json

    A recording is a record of Palpate (scenes/grip.yaml pushes as it should), or a CSV of one direction: t_s, x_m, F_N
    (force of the arm on the hand), and u where it is known (what shakes, any unit). Beside HAND.yaml a figure HAND.png
    is written. In a scene: operator: {hand: HAND.yaml}.
    """

    recording: Positional[Path]
    """Record (MCAP) or CSV of a held grip, 16 s or longer."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    out: Annotated[Path | None, arg(metavar="HAND.yaml")] = None
    """The hand to write."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.hand import hand

        return hand(self)


@dataclass
class Import:
    """A dVRK's own gravity compensation (gc-MTMR-xxxxx.json) as a model file of Palpate.

    examples:
      palpate calibrate import gc-MTMR-28247.json --out mtmr.yaml
    """

    file: Positional[Path]
    """The dVRK's JSON."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.gravity import import_dvrk

        return import_dvrk(self)


@dataclass
class Export:
    """A model file as the dVRK's own gravity compensation.

    examples:
      palpate calibrate export mtmr.yaml --out gc-MTMR-28247.json --serial 28247

    A model of the dVRK's form goes over exactly; another is fitted by it over the poses it was trained on, and what
    that loses is told.
    """

    file: Positional[Path]
    """Model file (MODEL.yaml)."""
    out: Annotated[Path, arg(metavar="GC.json")]
    """The dVRK's JSON to write."""
    serial: str = ""
    """Of the arm; the dVRK compares it."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.gravity import export_dvrk

        return export_dvrk(self)


@dataclass
class Dynamics:
    """An arm's full dynamics from moving recordings: links, friction, rotors, springs; every link could exist.

    examples:
      palpate calibrate dynamics one.csv --arm mtm --out mtm.yaml --test two.csv
      palpate calibrate dynamics one.csv two.csv --arm psm --out psm.yaml --json fit.json

    A recording is a CSV of q, dq, tau of all drives, or all joints (rad, rad/s, N m), evenly sampled; docs/dynamics.md
    tells which drives. What the model file is for: a load (palpate.identify.payload), and the force that a session
    estimates (force.dynamics in a scene).
    """

    train: Positional[tuple[Path, ...]]
    """Moving recordings to learn from (CSV)."""
    arm: str
    """Which arm was recorded: mtm, mtml, mtmr, psm, or a model file."""
    out: Annotated[Path, arg(metavar="MODEL.yaml")]
    """The model file to write."""
    test: Annotated[Path | None, arg(metavar="OTHER.csv")] = None
    """Another motion to judge on."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the figures as JSON (docs/json.md); - for the standard output."""
    at: Literal["drives", "joints"] = "drives"
    """Where the columns were measured: at the motors, as the published recordings, or at the joints (ROS)."""
    rate: float = 200.0
    """Samples a second of the recordings [Hz]."""
    cutoff: float = 2.0
    """Of the filter that both sides of the comparison go through [Hz]."""
    force: bool = False
    """Overwrite what is there."""

    def __call__(self) -> int:
        """Do it."""
        from palpate.cli.dynamics import dynamics

        return dynamics(self)


#: A calibration is a dataclass here and its name in this table.
COMMANDS: dict[str, type] = {"gravity": Gravity, "dynamics": Dynamics, "hand": Hand, "import": Import, "export": Export}
