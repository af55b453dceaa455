"""Tasks from start to end, by simulated operators, as `palpate run` does them."""

from __future__ import annotations

import numpy as np
import pytest

from palpate.scene import Scene
from palpate.session import PairsSession, Session
from palpate.session.tasks import TaskRun, drawn

SHORT = ["needle_passing"]
LONG = ["palpation_search", "tray_cubes", "ring_on_wire", "peg_transfer"]


def done(name, seed):
    scene = drawn(Scene.load(name), seed)
    if scene.bodies:
        pytest.importorskip("mujoco")
    session = (PairsSession if scene.pairs else Session)(scene, seed=seed)
    task = TaskRun(session)
    session.run()
    return task.result


@pytest.mark.parametrize("name", SHORT)
def test_a_simulated_operator_does_the_task(name):
    result = done(name, 1)
    assert result.success
    assert result.done
    assert 0.0 < result.score < 300.0
    assert result.time_s > 1.0


@pytest.mark.long
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("name", SHORT + LONG)
def test_operators_do_nine_of_ten(name):
    results = [done(name, seed) for seed in range(10)]
    assert sum(result.success for result in results) >= 9


def test_the_seed_hides_the_lump():
    scene = Scene.load("palpation_search")
    places = [drawn(scene, seed).objects[0].regions[0].at for seed in range(3)]
    assert len(set(places)) == 3
    low, high = np.array(scene.task.find.area)
    assert all((low <= p).all() and (p <= high).all() for p in np.array(places))
    assert drawn(scene, 1).objects[0].regions[0].at == places[1]
