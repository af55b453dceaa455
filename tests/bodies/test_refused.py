"""What a scene with bodies cannot be, and where it cannot run: refused by name."""

from __future__ import annotations

import sys

import pytest

from palpate.base.errors import MissingExtraError, PalpateError
from palpate.scene import Scene, held
from palpate.scene.rig import build
from palpate.session import Session
from palpate.session.remote.link import RemoteLink
from palpate.session.remote.site import FollowerServer

BOX = {"box": [0.006, 0.006, 0.006]}


def scene(*bodies, **sections):
    given = [{"name": f"body {k}", "parts": [BOX]} | body for k, body in enumerate(bodies)]
    return Scene.model_validate({"objects": [{"name": "table", "plane": {"size": 0.2}}], "bodies": given} | sections)


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ({"mass": 0.0}, "mass must be at least 0.0001"),
        ({"mass": float("nan")}, "mass must be a finite number"),
        ({"parts": [{"box": [0.0, 0.006, 0.006]}]}, "must be greater than 0"),
        ({"parts": [{"box": [float("inf"), 0.006, 0.006]}]}, "finite number"),
        ({"name": ""}, "name"),
        ({"name": "table"}, "another object is named 'table' too"),
        ({"pose": {"xyz": [1e9, 0, 0]}}, "'body 0' starts outside of the engine's field"),
        ({"parts": [{"wire": {"points": [[0, 0, 0], [0, 0, 0]], "radius": 0.001}}]}, "points 0 and 1 of a wire"),
        ({"parts": [{"wire": {"points": [[0, 0, 0], [0, 0, 1e12]], "radius": 0.001}}]}, "points 0 and 1 of a wire"),
        ({"parts": [{"ring": {"radius": 0.01, "thickness": 0.001, "arc_deg": 1e-300}}]}, "at least 1"),
        ({"joint": {"to": "body 0"}}, "a joint to 'body 0', which is not listed before it"),
    ],
)
def test_bodies_that_cannot_be_are_refused(body, words):
    with pytest.raises(PalpateError, match=words):
        scene(body)


def test_the_49th_body_and_a_second_of_one_name_are_refused():
    with pytest.raises(PalpateError, match="49 bodies move, and at most 48 can"):
        scene(*({} for _ in range(49)))
    with pytest.raises(PalpateError, match="another object is named 'body 0' too"):
        scene({}, {"name": "body 0"})
    with pytest.raises(PalpateError, match="swap their coordinates"):
        scene({}, engine={"field": [[1, 1, 1], [-1, -1, -1]]})


@pytest.mark.parametrize(
    ("task", "words"),
    [
        ({"place": {"bodies": ["body 0"], "targets": [[0, 0, 0]], "grasp": []}}, "grasp"),
        ({"place": {"bodies": ["body 0", "body 0"], "targets": [[0, 0, 0], [0, 0, 1]]}}, "named twice"),
        ({"find": {"object": "table", "region": "r", "area": [[0, 0, 0], [0, 0, 0]]}}, "'table' has no region 'r'"),
        ({"gates": {"body": "body 0", "tip": [0, 0, 0], "gates": [[0, 0, 0]], "along": [0, 0, 0]}}, "no direction"),
    ],
)
def test_tasks_without_what_they_need_are_refused(task, words):
    with pytest.raises(PalpateError, match=words):
        scene({}, task=task)


def test_what_the_engine_refuses_names_the_body_and_a_missing_mesh_its_file():
    pytest.importorskip("mujoco")
    with pytest.raises(PalpateError, match=r"the engine refuses the bodies.*\n.*'body 0'"):
        Session(scene({"parts": [{"box": [1e-12, 0.006, 0.006]}]}))
    with pytest.raises(PalpateError, match=r"no\.stl: mesh file not found"):
        Session(scene({"parts": [{"mesh": "no.stl"}]}))


def test_bodies_are_refused_across_a_network():
    rig = build(scene({}))
    with pytest.raises(PalpateError, match="bodies are not moved across a network"):
        FollowerServer(rig, b"0" * 32, "127.0.0.1", 0, 1000.0, print)


def test_a_link_of_a_session_with_bodies_is_refused():
    pytest.importorskip("mujoco")
    with pytest.raises(PalpateError, match="bodies are not moved across a network"):
        RemoteLink(Session(scene({})), ("127.0.0.1", 1), b"0" * 32)


def test_without_the_extra_bodies_ask_for_it(monkeypatch):
    rig = build(scene({}))
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match=r"palpate\[bodies\]"):
        held.world({"": rig})
