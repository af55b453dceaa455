"""What is told while nothing is touched: the nearest object, its distance, and the direction of the hand."""

import re

import numpy as np
import pytest

import palpate
from palpate.console.device import DeviceLine
from palpate.scene import Scene
from palpate.session import nearest

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
        found = nearest.nearest(haptics._loop.rig, haptics.session.latest())
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
        found = nearest.nearest(haptics._loop.rig, haptics.session.latest())
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
    from rich.console import Console

    from palpate.session import State

    with palpate.Haptics(scene([0.0, 0.0, 0.044])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        console = Console(force_terminal=True, width=160, record=True)
        with DeviceLine(console, haptics.session.rig) as line:
            line(State(haptics.session.latest(), ""))
            console.print(line._live.renderable)
        assert "'ball' is 40.0 mm away: move the hand 80 mm along -z" in console.export_text()


def test_the_viewer_says_it_too():
    from palpate.viewer.staging import stage_of
    from palpate.viewer.words import in_words

    with palpate.Haptics(scene([0.0, 0.0, 0.044])) as haptics:
        moved(haptics, [0.0, 0.0, 0.0])
        stage = stage_of(haptics.session.rig)
        said = in_words(haptics.session.latest(), 3.0, near=stage.near)
    assert said == ["free: 'ball' is 40.0 mm away: move the hand 80 mm along -z"]
