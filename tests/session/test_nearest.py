"""What is told while nothing is touched: the nearest object, its distance, and the direction of the hand."""

import re
from types import SimpleNamespace

import numpy as np
import pytest
from rich.console import Console

import palpate
from palpate.cli.commands.ros.haptics import HapticLine
from palpate.cli.terminal.device import DeviceLine
from palpate.cli.terminal.pairs import PairsProgress
from palpate.cli.terminal.progress import Progress
from palpate.scene import Scene
from palpate.sensing import CloudFrame
from palpate.session import PairsSession, State, nearest
from palpate.viewer import LiveViewer, stage_of

BALL = {"name": "ball", "sphere": {"radius": 0.03}, "pose": {"xyz": [0.0, 0.0, -0.03]}}  # its top is the origin
FAR = {"name": "wall", "plane": {}, "pose": {"xyz": [0.0, 0.0, -0.5]}}


def scene(start, scale=0.5, leader=None, objects=(BALL, FAR)):
    """A scene whose tool starts at a position in W [m], with the axes of the device turned by rpy [deg]."""
    above = [start[0], start[1], start[2] + 0.12]
    arms = {"follower": {"start": {"xyz": start, "rpy_deg": [180, 0, 0]}, "base": {"xyz": above}}}
    if leader is not None:
        arms["leader"] = {"base": {"rpy_deg": leader}}
    return Scene.model_validate(
        {"objects": list(objects), "arms": arms, "mapping": {"scale": scale}, "contact": {"radius": 0.004}}
    )


def moved(haptics, p_L, seconds=0.05):
    """Moves the handle from the origin to a position in its own axes, within a time."""
    for i in range(int(1000 * seconds) + 1):
        X = np.eye(4)
        X[:3, 3] = np.array(p_L) * i / max(1, int(1000 * seconds))
        haptics.step(0.001 * (i + 1), X)


@pytest.mark.parametrize("scale", [0.5, 0.25, 1.0])
@pytest.mark.parametrize("height", [0.024, 0.044])
def test_a_loop_that_feels_nothing_is_told_where_the_object_is(scale, height):
    with palpate.Haptics(scene([0.0, 0.0, height], scale)) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        gap = height - 0.004
        assert haptics.status == "ok"
        assert haptics.why() == (
            f"no force: the tool touches nothing; 'ball' is {1e3 * gap:.1f} mm away: "
            f"move the hand {1e3 * gap / scale:.0f} mm along -z"
        )


@pytest.mark.parametrize("rpy", [[0, 0, 0], [90, 0, 0], [0, 90, 0], [0, 0, 90], [20, -40, 70]])
def test_the_told_motion_of_the_hand_touches_the_object(rpy):
    """Judge: the hand goes where it is told, and a force comes within 2 mm of the told distance."""
    with palpate.Haptics(scene([0.01, 0.0, 0.03], 0.5, rpy)) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        words = haptics.why()
        found = nearest.nearest(haptics.session.rig, haptics.session.latest())
        assert f"move the hand {1e3 * found.hand:.0f} mm" in words
        t, felt = 0.06, []
        for i in range(2000):
            s = (found.hand + 0.004) * min(1.0, i / 1500)
            X = np.eye(4)
            X[:3, 3] = s * found.towards_L
            t += 0.001
            felt.append((s, np.linalg.norm(haptics.step(t, X)[:3])))
        first = next(s for s, F in felt if F > 0.0)
        assert first == pytest.approx(found.hand, abs=0.002)
        assert haptics.why() == "ok"


def test_the_distance_is_that_of_the_closed_form():
    with palpate.Haptics(scene([0.02, -0.01, 0.05])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        p = haptics.session.latest()["p_WT"]
        found = nearest.nearest(haptics.session.rig, haptics.session.latest())
        away = np.array([0.0, 0.0, -0.03]) - p
        assert found.distance == pytest.approx(np.linalg.norm(away) - 0.03 - 0.004, abs=1e-9)
        np.testing.assert_allclose(found.towards_L, away / np.linalg.norm(away), atol=1e-9)


def test_the_nearest_of_several_is_named():
    other = {"name": "near", "box": {"size": [0.02, 0.02, 0.02]}, "pose": {"xyz": [0.0, 0.03, 0.04]}}
    with palpate.Haptics(scene([0.0, 0.0, 0.04], objects=(BALL, other))) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        assert re.search(r"'near' is 16\.0 mm away: move the hand 32 mm along \+y", haptics.why())


def test_before_the_first_step_nothing_is_told():
    with palpate.Haptics(scene([0.0, 0.0, 0.05])) as haptics:
        assert haptics.why() == "ok"


def test_the_terminal_says_it_too():
    with palpate.Haptics(scene([0.0, 0.0, 0.044])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        console = Console(force_terminal=True, width=160, record=True)
        with DeviceLine(console, haptics.session.nearest) as line:
            line(State(haptics.session.latest(), ""))
            console.print(line._live.renderable)
        assert "'ball' is 40.0 mm away: move the hand 80 mm along -z" in console.export_text()


def test_the_viewer_says_it_too():
    from palpate.viewer.words import in_words

    with palpate.Haptics(scene([0.0, 0.0, 0.044])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        stage = stage_of(haptics.session.rig)
        said = in_words(haptics.session.latest(), 3.0, near=stage.near)
    assert said == ["free: 'ball' is 40.0 mm away: move the hand 80 mm along -z"]


class Patch:
    """A camera beside the tool that sees a level patch of 80 mm around a place in W."""

    def __init__(self, xyz):
        self.xyz, self.frames, self.X_WC = np.array(xyz), 0, np.eye(4)
        self.X_WC[:3, 3] = [0.3, 0.0, 0.044]

    def latest(self, now):
        if now < self.frames / 30.0:
            return None
        self.frames += 1
        xy = np.random.default_rng(self.frames).uniform(-0.04, 0.04, (6000, 2))
        return CloudFrame(np.c_[xy, 0.0 * xy[:, :1]] + self.xyz - self.X_WC[:3, 3], now, self.X_WC)

    def close(self):
        pass


def seen(name="organ"):
    return {"name": name, "cloud": {"sensor": "camera", "region": 0.08}}


@pytest.mark.parametrize(("place", "away", "along"), [([0.0, 0.0, 0.0], 40.0, "-z"), ([0.0, 0.0, 0.088], 40.0, r"\+z")])
def test_a_cloud_of_a_sensor_is_told(place, away, along):
    """Judge: the height of the patch over the tool, less the radius of its sphere."""
    with palpate.Haptics(scene([0.0, 0.0, 0.044], objects=(seen(), FAR)), clouds={"camera": Patch(place)}) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        assert "'wall'" in haptics.why()  # no frame yet
        haptics.session.sensing.step(0.06)
        haptics.step(0.06, np.eye(4))
        haptics.step(0.061, np.eye(4))
        found = re.search(rf"'organ' is (\d+\.\d) mm away: move the hand (\d+) mm along {along}$", haptics.why())
        assert found is not None, haptics.why()
        assert float(found[1]) == pytest.approx(away, abs=0.3)
        assert float(found[2]) == pytest.approx(2.0 * away, abs=1.0)


@pytest.mark.parametrize("rim", [False, True])
def test_a_cloud_of_a_file_is_told(tmp_path, rim):
    """Judge: the distance to the nearest point of a plane with spacing 0.5 mm, over it and beside its rim."""
    grid = np.arange(-0.03, 0.03001, 0.0005)
    points = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    palpate.PointCloud(np.c_[points, np.zeros(len(points))], viewpoint=[0.0, 0.0, 1.0]).save(tmp_path / "plane.npz")
    start = [0.07, 0.0, 0.0] if rim else [0.0, 0.0, 0.044]
    one = {"name": "scan", "cloud": str(tmp_path / "plane.npz")}
    with palpate.Haptics(scene(start, objects=(one,))) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        found = re.search(r"'scan' is (\d+\.\d) mm away: move the hand (\d+) mm along (\S+)$", haptics.why())
        assert found is not None, haptics.why()
        away = 1e3 * (np.linalg.norm(np.array(start) - np.clip(start, -0.03, 0.03) * [1, 1, 0]) - 0.004)
        assert float(found[1]) == pytest.approx(away, abs=3.1 if rim else 0.1)  # the surface bridges 3 mm over its rim
        assert found[3] == ("-x" if rim else "-z")


def shown(line, state):
    """What a terminal shows of a line."""
    with line:
        line(state)
        line._console.print(line._live.renderable, soft_wrap=True)
    return line._console.export_text()


def terminal():
    return Console(force_terminal=True, width=300, record=True)


def test_the_line_of_the_simulated_hand_says_it():
    start = scene([0.0, 0.0, 0.044]).model_dump(mode="json", exclude_unset=True)
    start["operator"] = {"path": [{"t": 0.0, "xyz": [0.0, 0.0, 0.044]}, {"t": 1.0, "xyz": [0.0, 0.0, 0.044]}]}
    session = palpate.Session(Scene.model_validate(start))
    session.step(20)
    assert "'ball' is 40.0 mm away: move the hand 80 mm along -z" in shown(
        Progress(terminal(), 1.0, "lockstep", session.nearest), session.state
    )


def test_the_line_of_pairs_says_it_for_each():
    session = PairsSession("two_hands")
    session.run(0.01)
    states = {name: pair.state for name, pair in session.pairs.items()}
    near = {name: pair.nearest for name, pair in session.pairs.items()}
    console = terminal()
    text = shown(PairsProgress(console, 1.0, "lockstep", near), states)
    for name, state in states.items():
        found = nearest.nearest(session.rigs[name], state.tick)
        assert not state.contacts
        assert f"{state.force:5.2f} N  {found.words()}" in text
    said = {nearest.nearest(session.rigs[name], state.tick).words() for name, state in states.items()}
    assert len(said) == len(states)


def test_the_line_of_a_node_on_ros_says_it():
    """The line of `palpate ros haptics`, on the ticks of a loop without ROS."""
    timing = {"leader_rate": 1000.0, "answer_us": {"p50": 30.0, "p99": 120.0}}
    with palpate.Haptics(scene([0.0, 0.0, 0.044])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        node = SimpleNamespace(nearest=haptics.session.nearest, timing=timing, plant=None, notes=[])
        text = shown(HapticLine(terminal(), node), State(haptics.session.latest(), ""))
    assert text.rstrip().endswith("'ball' is 40.0 mm away: move the hand 80 mm along -z")


def test_the_live_viewer_knows_the_clouds_of_sensors():
    felt, camera = scene([0.0, 0.0, 0.044], objects=(seen(), FAR)), Patch([0.0, 0.0, 0.0])
    with palpate.Haptics(felt, clouds={"camera": camera}) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        haptics.session.sensing.step(0.06)
        haptics.step(0.06, np.eye(4))
        viewer = LiveViewer(haptics.session, stage_of(haptics.session.rig), port=0)
        try:
            assert "'organ'" in viewer._stage.near(haptics.session.latest())
        finally:
            viewer.close()
