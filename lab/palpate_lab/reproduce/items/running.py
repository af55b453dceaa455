"""Figs 1, 2 and 4: the arms, the sensed scene and the teleoperation, photographed from the running system."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from rich.console import Console

from palpate.arm import Arm
from palpate.base.arrays import Array
from palpate.base.arrays.rigid import transform
from palpate.base.errors import PalpateError
from palpate.base.plotting.style import Canvas
from palpate.record.ticks import Ticks, as_ticks
from palpate.scene import Scene, shipped
from palpate.scene.rig import Rig
from palpate.session import PairsSession, Session
from palpate_lab.reproduce.item import Drawing, Item, Outcome, Work
from palpate_lab.reproduce.items.painting import Moment, painted
from palpate_lab.reproduce.items.palpation import palpation
from palpate_lab.verify.bench.browser import open_browser
from palpate_lab.verify.bench.viewer import READY

_SIZE = (1720, 900)  # of the browser's window [pixels]
_SETTLE = 3.0  # time for the last texture after the picture is there [s]
_SETUPS = 6  # simulated set-ups of the chain of registrations [-]
_POSES = 200  # joint positions of the round trips [-]
_AT_ONCE = (
    "document.head.insertAdjacentHTML('beforeend', '<style>canvas { opacity: 1 !important } "
    ".mantine-Notifications-root { display: none !important }</style>')"
)
"""Ends the fading in of the picture, and hides messages over it."""
_SPAN = (330, 1435)  # columns of the picture between the panels [pixels]


def photograph(url: str, file: Path, scale: float = 1.0) -> Path:
    """Photograph a page of the viewer when it has drawn some frames; scale: drawn pixels per pixel of the page.

    Raises:
        PalpateError: no Chromium is installed, or it fails. MissingExtraError: the extra `viewer` is missing.
    """
    with open_browser() as page:
        page.open(f"{url}?scale={scale:g}", _SIZE)
        page.wait_for(READY)
        page.evaluate(_AT_ONCE)
        time.sleep(_SETTLE)
        page.photograph(file)
    return file


def picture(file: Path, columns: tuple[int, int] | None = _SPAN) -> Any:
    """The pixels of a photograph, (h, w, 3); columns: first and last one to keep."""
    from matplotlib.image import imread

    pixels = imread(file)[..., :3]
    return pixels if columns is None else pixels[:, columns[0] : columns[1]]


def _plate(pixels: Any, canvas: Canvas) -> Figure:
    """The photograph as a figure, without frame."""
    h, w = pixels.shape[:2]
    width = min(canvas.width, 8.2)
    figure = Figure(figsize=(width, width * h / w))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.imshow(pixels)
    axes.axis("off")
    return figure


@contextmanager
def _stopped(viewer: Any, at: float) -> Iterator[str]:
    """Address of a replay viewer, of one pair or several, that shows the instant `at` [s]."""
    try:
        viewer.picture.choose("full")
        viewer.show_at(at)
        yield viewer.url
    finally:
        viewer.close()


@contextmanager
def replay(rig: Rig, ticks: Ticks, title: str, at: float) -> Iterator[str]:
    """Address of a viewer that shows the instant `at` [s] of a run of one pair."""
    from palpate.viewer import ReplayViewer, stage_of

    with _stopped(ReplayViewer(ticks, stage_of(rig, title), port=0), at) as url:
        yield url


@contextmanager
def replay_pairs(run: Path, title: str, at: float) -> Iterator[str]:
    """Address of a viewer that shows the instant `at` [s] of the run of several pairs in a folder."""
    from palpate.record.reader import Record
    from palpate.report.pairs import pair_records
    from palpate.viewer.pairs_replay import PairsReplayViewer

    records = {name: Record.open(path) for name, path in pair_records(run).items()}
    with _stopped(PairsReplayViewer(records, title, port=0), at) as url:
        yield url


@contextmanager
def sensed(session: Session) -> Iterator[str]:
    """Address of a viewer that shows the present moment of a session, with the newest cloud of its camera."""
    from palpate.viewer import LiveViewer, stage_of

    viewer = LiveViewer(session, stage_of(session.rig, session.scene.title), port=0)
    try:
        viewer.picture.choose("full")
        yield viewer.url
    finally:
        viewer.close()


def _shown(
    page: AbstractContextManager[str], file: Path, caption: str, moments: Sequence[Moment],
    cloud_W: Array | None = None, scale: float = 1.0,
) -> tuple[Drawing, str]:  # fmt: skip
    """The picture of a running system, and what was absent for it (empty if nothing was).

    Args:
        page: address of the viewer.
        file: file for the photograph.
        caption: what the picture shows.
        moments: the pairs, to be painted where browser or viewer are absent.
        cloud_W: points (n, 3) of a camera in that picture [m].
        scale: drawn pixels per pixel of the page.
    """
    try:
        with page as url:
            pixels = picture(photograph(url, file, scale))
    except ModuleNotFoundError as absent:
        lacks = f"the package {absent.name} is not installed: it comes with palpate[viewer]"
    except PalpateError as error:
        lacks = ": ".join(part for part in (error.what, error.mend) if part)
    else:
        return Drawing("", caption, partial(_plate, pixels)), ""
    return Drawing("", f"{caption} Painted by software.", partial(painted, moments, cloud_W)), lacks


def _said(lacks: str) -> str:
    return f" The picture is painted by software instead of taken from the viewer ({lacks})." if lacks else ""


def _scene(name: str) -> Scene:
    return Scene.load(shipped.file(name))


def fig1(work: Work) -> Outcome:
    """Two masters and two instruments with the endoscope, and the kinematics behind them."""
    rng = np.random.default_rng(work.seed)
    rows: list[dict[str, Any]] = []
    for name, arm in (("MTM", Arm.mtm("right")), ("PSM", Arm.psm())):
        errors = []
        for _ in range(_POSES):
            X = arm.fk(rng.uniform(arm.q_min, arm.q_max))
            errors.append(float(np.linalg.norm(arm.fk(arm.ik(X))[:3, 3] - X[:3, 3])))
        rows.append({"arm": name, "joints": arm.n, "round_trip_largest_m": max(errors)})
    psm, moved = Arm.psm(), []
    for _ in range(_POSES):
        q = rng.uniform(psm.q_min, psm.q_max)
        tip, axis = psm.link_poses(q)["shaft"][:3, 3], psm.link_poses(q)["shaft"][:3, 2]
        moved.append(float(np.linalg.norm(np.cross(axis, tip))))  # distance of the shaft's axis from the base's origin
    good = (
        max(r["round_trip_largest_m"] for r in rows) < 1e-6
        and max(moved) < 1e-6
        and [r["joints"] for r in rows] == [7, 6]
    )
    session = PairsSession(_scene("two_hands"), out=work.folder)
    kept = session.run(4.0).record
    assert kept is not None
    moments = [(session.rigs[name], state.tick) for name, state in session.states.items()]
    drawing, lacks = _shown(
        replay_pairs(Path(kept), session.scene.title, 3.8), work.folder / "fig1.png",
        "Two masters (front), two instruments and the endoscope arm of the scene two_hands (simulated).", moments,
    )  # fmt: skip
    whole = Drawing("whole", "The same arms as a whole, painted by software.", partial(painted, moments, None))
    return Outcome(
        "agrees" if good else "differs",
        {"arms": rows, "shaft_misses_the_remote_centre_by_m": max(moved)},
        "a photograph of one MTM and two PSMs; MTM 7 joints, PSM 6 joints and a jaw, with a fixed remote centre",
        "The photograph of the robot is replaced by a picture of the simulated one: two MTMs, two PSMs and the "
        "endoscope "
        "arm. Joints and remote centre are as stated; forward and inverse kinematics return to within a micrometre."
        + _said(lacks),
        rows,
        [drawing, whole],
        lacks=lacks,
    )  # fmt: skip


def fig2(work: Work) -> Outcome:
    """A simulated depth camera's cloud is touched, and a whole chain of registrations is simulated."""
    from palpate.base.sweep import Axis, sweep
    from palpate.world.registration.surfaces import require
    from palpate_lab.studies.registration.chain import judged

    require()
    grid = {"setup": Axis(range(_SETUPS), "", "number of a set-up")}
    rows = sweep(judged, grid, work.seed, workers=work.workers, console=Console(quiet=True), title="chain").rows()
    errors = {
        f"{name}_mm": 1e3 * float(np.median([row[f"{name}_median_m"] for row in rows])) for name in ("tip", "felt")
    }
    session = Session(_scene("camera"))
    try:
        session.step(round(4.0 * session.rate))
        assert session.sensing is not None
        frame = next(iter(session.sensing.frames.values()))  # of its only camera
        points = np.asarray(frame.points).reshape(-1, 3)
        drawing, lacks = _shown(
            sensed(session), work.folder / "fig2.png",
            "The scene camera: a simulated depth camera sees a breathing liver, and the tool touches the surface of "
            "its newest frame (simulated).",
            [(session.rig, session.latest())],
            transform(frame.X_WC, points[np.isfinite(points).all(axis=1)]),
            0.6,  # clouds are slow by software
        )  # fmt: skip
    finally:
        session.close()
    return Outcome(
        "not testable without the robot",
        {"set_ups": _SETUPS, "median_errors": errors},
        "overview of tracker, markers on PSMs, camera and world, and a Kinect that sees the organ; “under development”",
        "The components of the figure run here with a simulated tracker and camera: the cloud is touched, and the "
        "chain of "
        f"registrations puts the tip within {errors['tip_mm']:.2f} mm and the felt surface within "
        f"{errors['felt_mm']:.2f} mm of "
        f"the truth (median of {_SETUPS} random set-ups). The accuracy of a real tracker and camera needs the robot."
        + _said(lacks),
        rows,
        [drawing],
        lacks=lacks,
    )  # fmt: skip


def fig4(work: Work) -> Outcome:
    """The simulated instrument follows the simulated master."""
    p = palpation(work.seed)
    scene, X_WL = p.setup.scene, p.setup.arms.X_WL
    hand = (p["p_LH"] - p["p_LH"][0]) @ X_WL[:3, :3].T
    goal = p["p_WT_goal"] - p["p_WT_goal"][0]
    away = np.linalg.norm(goal - scene.mapping.scale * hand, axis=1)
    lag = np.linalg.norm(p["p_WT"] - p["p_WT_goal"], axis=1)
    moved = float(np.linalg.norm(goal, axis=1).max())
    good = float(away.max()) < 1e-3 and moved > 5e-3
    session = Session(_scene("palpation"))
    ticks = as_ticks(session.rig.simulation(session.seed).run(round(6.0 * session.rate) + 1))
    at = 4.6
    drawing, lacks = _shown(
        replay(session.rig, ticks, session.scene.title, at), work.folder / "fig4.png",
        "Master, instrument and organ of the scene palpation (simulated).",
        [(session.rig, ticks[round(at * session.rate)])],
    )  # fmt: skip
    loops = {
        "haptic_Hz": scene.rates.haptic,
        "torque_Hz": scene.rates.plant,
        "collision_Hz": scene.contact.collision_rate,
    }
    return Outcome(
        "agrees" if good else "differs",
        {"scale": scene.mapping.scale, "goal_less_scaled_motion_mm": 1e3 * float(away.max()),
         "tip_less_goal_mm": 1e3 * float(lag.max()), "tool_moved_mm": 1e3 * moved, "loops": loops},
        "the packages by which an actual MTM moves a simulated PSM (no numbers)",
        "A simulated MTM moves the simulated PSM: the goal of the tip is the scaled motion of the handle to "
        f"{1e3 * float(away.max()):.2g} mm over {1e3 * moved:.0f} mm. With an actual MTM the same loop runs as nodes "
        "on ROS 2 "
        "(palpate ros haptics), which is tested against a simulated dVRK and not on the robot."
        + _said(lacks),
        [{"t_s": t, "goal_less_scaled_motion_mm": 1e3 * a, "tip_less_goal_mm": 1e3 * b}
         for t, a, b in zip(p.t[::10].tolist(), away[::10].tolist(), lag[::10].tolist(), strict=True)],
        [drawing],
        lacks=lacks,
    )  # fmt: skip


_VIEWER = ("palpate/viewer",)

ITEMS = (
    Item("fig1", "The robot", "Section 1, Fig 1",
         "The research kit of the authors' laboratory: a master arm on the left and two patient-side arms on the "
         "right.",
         fig1, ("R1", "R3", "R61"), "The gripper is left out of the MTM's kinematics and dynamics.",
         (*_VIEWER, "models/generate.py")),
    Item("fig2", "The framework for a sensed scene", "Section 2.1, Fig 2",
         "An optical tracker sees markers on the PSMs, the camera and the world frame; the camera sees the organ. The "
         "authors say that it is under development, and register by hand.",
         fig2, ("R6", "R7", "R56"), "",
         ("lab/palpate_lab/studies/registration/chain.py", "palpate/sensing", "scenes/camera.yaml")),
    Item("fig4", "Teleoperation of the simulated PSM", "Section 3.1, Fig 4",
         "The packages through which an actual MTM teleoperates a simulated PSM.", fig4, ("R2", "R4", "R5"), "",
         (*_VIEWER, "core/palpate/mapping/mapping.cpp", "palpate/ros"),
         "The authors' later code starts and stops teleoperation with the foot pedals, as does `palpate ros haptics`."),
)  # fmt: skip
