"""Objects of a session follow their tracker without a force step, and faults of the tracker never move them."""

from dataclasses import replace

import numpy as np
import pytest

from palpate import Session, _core
from palpate.base.errors import PalpateError, SceneError
from palpate.record.reader import Record
from palpate.report import tracked
from palpate.scene import Scene, surface
from palpate.sensing.trackers import Sighting
from palpate.sensing.trackers.tracking import Tracking

K, B, RATE = 400.0, 4.0, 1000.0
SCENE = """\
frames:
  - {{child: tracker, pose: {{xyz: [0, 0, 1.2], rpy_deg: [180, 0, 0]}}}}
  - {{parent: tracker, child: patient, pose: {{xyz: [0, 0, 1.2], rpy_deg: [180, 0, 0]}}, tracker: t}}
trackers: {{t: {{simulated: {{{simulated}}}, fade: 0.4}}}}
objects: [{{name: block, box: {{size: [0.1, 0.1, 0.04]}}, frame: patient, stiffness: 400, damping: 4, friction: 0.0}}]
stability: {{passivity: "off"}}
operator:
  path: [{{t: 0, xyz: [0, 0, 0.04]}}, {{t: 0.3, xyz: [0, 0, 0.019]}}, {{t: 9, xyz: [0, 0, 0.019]}}]
seed: 3
"""


def scene(simulated: str = "noise_mm: 0.0") -> Scene:
    return Scene.parse(SCENE.format(simulated=simulated))


class Stream:
    """A tracker that reports what a test tells it to."""

    def __init__(self, X: np.ndarray) -> None:
        self.X, self.silent = X, False

    def poll(self, now: float) -> list[Sighting]:
        return [] if self.silent else [Sighting("patient", self.X.copy(), now)]

    def close(self) -> None: ...


def pressed(settle: int = 900, friction: float = 0.0) -> tuple[Session, Stream]:
    """A session whose tool presses the block at rest."""
    session = Session(Scene.parse(SCENE.format(simulated="").replace("friction: 0.0", f"friction: {friction}")))
    stream = Stream(session.rig.frames.edge("patient").X.copy())
    session.tracking = Tracking(session.rig, session.simulation, {"t": stream})
    session.step(settle)
    assert session.state.force > 0.5
    return session, stream


def rows(session: Session, n: int) -> np.ndarray:
    """Contact force (n, 3) on the tool at each of n ticks [N]."""
    return np.array([session.step().F_T_W for _ in range(n)])


def force_step(forces: np.ndarray) -> float:
    """Largest change of the force from one tick to the next [N]."""
    return float(np.linalg.norm(np.diff(forces, axis=0), axis=1).max())


def at_10_mm(X: np.ndarray) -> np.ndarray:
    """The patient 10 mm higher in W, which is nearer to the tracker."""
    moved = X.copy()
    moved[2, 3] -= 0.01
    return moved


def p_block(session: Session) -> np.ndarray:
    """Position (3,) of the block as rendered in the newest tick [m]."""
    return np.array(session.latest()["live_p"][:3])


def test_a_jump_of_the_goal_reaches_contact_without_a_force_step():
    """Per tick the force may change by K |v| dt and by B a dt: 0.04 N + 0.002 N here."""
    session, stream = pressed()
    stream.X = at_10_mm(stream.X)
    session.tracking.gates["patient"].accept_jump()
    forces = rows(session, 600)
    assert force_step(forces) < K * 0.1 / RATE + B * 0.5 / RATE
    assert p_block(session)[2] == pytest.approx(0.01, abs=3e-4)


def test_the_judge_finds_a_pose_that_is_set_at_once():
    """The check above, on the snapshot that would result without rate limiting."""
    session, _ = pressed()
    before = rows(session, 20)
    block, placed = session.rig.scene.objects[0], session.rig.surfaces[0]
    X = placed.X_WO.copy()
    X[2, 3] += 0.01
    moved = replace(placed, X_WO=X)
    session.tracking = None
    session.simulation.set_snapshot(_core.Snapshot([surface.core_object(block, moved, _core.Motion())]))
    assert force_step(np.concatenate([before, rows(session, 20)])) > 5 * (K * 0.1 + B * 0.5) / RATE


def test_contact_knows_the_velocity_of_a_tracked_object():
    """A block that rises under a tool: damping acts on the relative velocity, so F = K depth + B (v_block - v_tool)."""
    session, stream = pressed()
    stream.X = at_10_mm(stream.X)
    session.tracking.gates["patient"].accept_jump()
    for _ in range(120):
        before, tick = p_block(session), session.step().tick
    v_block = (p_block(session) - before) * RATE
    v_tool = session.scene.mapping.scale * session.rig.arms.X_WL[:3, :3] @ tick["v_LH"]
    assert v_block[2] > 0.04
    assert v_block[2] - v_tool[2] > 0.02
    assert tick["F_damping_W"][2] == pytest.approx(B * (v_block[2] - v_tool[2]), rel=1e-6)
    assert tick["F_T_W"][2] == pytest.approx(K * tick["delta_x"][2] + tick["F_damping_W"][2], rel=1e-6)


def test_a_tracked_object_has_friction_while_it_moves():
    """A block that moves along x under a resting tool drags it with mu N."""
    session, stream = pressed(friction=0.3)
    start = stream.X[0, 3]
    for k in range(100):
        stream.X[0, 3] = start + 0.01 * 0.01 * k
        state = session.step(10)
    F = np.abs(state.F_T_W)
    assert F[2] > 0.5
    assert F[0] == pytest.approx(0.3 * F[2], rel=1e-3)


def test_a_silent_tracker_stops_the_object_and_its_force_fades():
    session, stream = pressed()
    stream.silent = True
    X = p_block(session)
    held = rows(session, 150)
    assert np.linalg.norm(held[-1]) == pytest.approx(np.linalg.norm(held[0]), rel=0.02)
    fading = rows(session, 600)
    assert np.linalg.norm(fading[-1]) < 1e-6
    assert force_step(fading) < 0.05
    assert p_block(session) == pytest.approx(X, abs=1e-9)
    assert "lost for" in session.tracking.status(session.state.t)["patient"]
    stream.silent = False
    back = rows(session, 900)
    assert np.linalg.norm(back[-1]) == pytest.approx(np.linalg.norm(held[0]), rel=0.02)
    assert force_step(back) < 0.05


@pytest.mark.parametrize("kind", ["occluded", "swapped-spheres", "stopped"])
def test_faults_of_the_simulated_tracker_do_not_move_the_object(kind):
    session = Session(scene(f"noise_mm: 0.25, faults: [{{kind: {kind}, start: 0.5, end: 1.2}}]"))
    session.step(500)
    X = session.rig.frames.pose("patient").X
    session.step(600)
    assert "lost" in session.tracking.status(session.state.t)["patient"]
    assert np.linalg.norm(session.rig.frames.pose("patient").X[:3, 3] - X[:3, 3]) < 1.5e-3
    session.step(300)
    assert session.tracking.status(session.state.t)["patient"] == "tracked"


def test_a_lockstep_run_with_a_simulated_tracker_is_repeatable():
    def run(chunk):
        session = Session(scene("noise_mm: 0.25, motion: {patient: {amplitude: [0, 0, 0.004], period: 1}}"))
        for n in (chunk, 850 - chunk):
            session.step(n)
        tick = session.latest()
        return [tick[name].tobytes() for name in ("F_T_W", "p_WT", "q", "tau", "delta_x")]

    assert run(600) == run(601)


def test_live_frames_and_the_object_are_known_to_fixtures():
    session, stream = pressed()
    stream.X = at_10_mm(stream.X)
    session.tracking.gates["patient"].accept_jump()
    session.step(800)
    frames = session.rig.context.frames
    assert np.asarray(frames["patient"].at(0.0)[0])[2, 3] == pytest.approx(0.01, abs=1e-6)
    assert np.asarray(frames["block"].at(0.0)[0])[2, 3] == pytest.approx(0.01, abs=3e-4)


def test_objects_follow_in_real_time():
    session = Session(scene("noise_mm: 0.1, motion: {patient: {velocity: [0, 0, 0.01]}}"))
    session.run(0.6, realtime=True)
    assert session.notes == []
    assert session.latest()["tracked_status"][0] == 1
    assert p_block(session)[2] < -1e-3  # the tracker's z axis points down


def test_a_network_tracker_needs_real_time():
    pytest.importorskip("pyigtl")
    text = SCENE.format(simulated="").replace("simulated: {}", "openigtlink: 127.0.0.1:9")
    session = Session(Scene.parse(text))
    with pytest.raises(PalpateError, match="run in real time"):
        session.step()
    session.tracking.close()


def test_an_unknown_tool_of_the_simulation_is_refused():
    with pytest.raises(SceneError, match="has no tool 'patent'"):
        Session(scene("motion: {patent: {velocity: [0, 0, 0.01]}}"))


def test_a_record_holds_the_tracked_poses_and_the_report_tells_them(tmp_path):
    """The simulated marker moves by 4 mm and is hidden for 0.4 s; the record says so in pose, age and status."""
    simulated = "noise_mm: 0.0, motion: {patient: {amplitude: [0, 0, 0.004], period: 1}}"
    text = SCENE.format(simulated=simulated + ", faults: [{kind: occluded, start: 0.6, end: 1.0}]")
    with Session(Scene.parse(text), out=tmp_path) as session:
        session.step(1500)
        last = session.latest()
    record = Record.open(session.record)
    ticks = record.ticks
    for name in ("live_p", "live_quat", "live_share", "tracked_p", "tracked_quat", "tracked_age", "tracked_status"):
        np.testing.assert_array_equal(ticks[name][-1], last[name])
    z = ticks["tracked_p"][:, 2]
    seen = 34 / 60  # time of the tracker's last frame before tick 580 [s]
    assert np.ptp(z[:590]) == pytest.approx(0.004 * (1.0 - np.sin(2 * np.pi * seen)), rel=1e-6)
    assert np.ptp(z[620:1000]) == 0.0
    age, status = ticks["tracked_age"][:, 0], ticks["tracked_status"][:, 0]
    assert age[30:590].max() < 0.04
    assert age[990] == pytest.approx(0.99 - 0.59, abs=0.02)
    assert status[30:700].max() == status[30:700].min() == 1
    assert status[990] == 2
    assert status[-1] == 1
    told = tracked.table(ticks, ["<patient>"], record.rate)
    assert "&lt;patient&gt;" in told
    lost = (status != 1).sum() / record.rate
    assert lost == pytest.approx(0.4 - 0.2, abs=0.04)
    assert f"{lost:.2f} s" in told
    assert "4.0 mm" in told


def test_a_record_without_trackers_has_no_such_signals(tmp_path):
    with Session(Scene.parse("objects: [{sphere: {radius: 0.03}}]"), out=tmp_path) as session:
        session.step(10)
    record = Record.open(session.record)
    assert not {name for name in record.signals if name.startswith(("live_", "tracked_"))}
    assert np.isnan(record.ticks["live_p"]).all()


@pytest.mark.parametrize("what", ["frames", "objects"])
def test_more_tracked_frames_and_objects_than_the_loop_holds_are_refused(what):
    n = _core.MAX_LIVE + 1
    frames = [f"{{child: f{k}, tracker: t, pose: {{xyz: [0, 0, 1]}}}}" for k in range(n if what == "frames" else 1)]
    objects = [f"{{name: o{k}, sphere: {{radius: 0.01}}, frame: f0}}" for k in range(n if what == "objects" else 1)]
    text = f"frames: [{', '.join(frames)}]\ntrackers: {{t: {{simulated: {{}}}}}}\nobjects: [{', '.join(objects)}]\n"
    with pytest.raises(SceneError, match=f"9 {what} follow trackers; at most 8"):
        Session(Scene.parse(text))


def test_a_marker_that_was_moved_on_purpose_is_accepted_by_pedals():
    """The pedal coag does it while the clutch is down, and only for a tool that is refused for its jump."""
    session, stream = pressed()
    stream.X = at_10_mm(stream.X)
    stream.X[:3, 3] += [0.05, 0.0, 0.0]
    session.step(400)
    status = session.tracking.status(session.state.t)["patient"]
    assert "jumped by" in status
    assert status.endswith("press coag while the clutch is down")
    session.console.press("coag")
    session.console.release("coag")
    session.step(100)
    assert session.tracking.gates["patient"].jumped
    session.console.press("clutch")
    session.console.press("coag")
    session.step(100)
    assert session.tracking.status(session.state.t)["patient"] == "tracked"
    assert session.tracking.accept_jumps() == []
