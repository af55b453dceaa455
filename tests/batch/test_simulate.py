"""Batch simulation: each run equals that of a session, independent of order and number of workers."""

from dataclasses import asdict

import numpy as np
import pytest

import palpate
from palpate import Scene, Session, Variation
from palpate.arm.hands import PRESETS
from palpate.base.errors import PalpateError, SceneError
from palpate.record import as_ticks
from palpate.session.batch import MEASURED

TEXT = """\
objects:
  - name: liver
    shape: organ
    triangles: 3000
    stiffness: 400
    friction: 0.1
operator:
  palpate: {approach: 0.4, press: 0.2, slide: 0.4, leave: 0.2}
  tremor: 0.0002
duration: 0.6
"""
RUNS = [({"objects.0.stiffness": 300.0}, 1), ({}, 2), ({"mapping.scale": 0.4, "operator.hand": "firm"}, None),
        ({"objects.0.stiffness": 300.0}, 3), ({"arms.follower.bandwidth": 20.0}, None), ({}, 1)]  # fmt: skip


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> Scene:
    path = tmp_path_factory.mktemp("batch") / "soft.yaml"
    path.write_text(TEXT)
    return Scene.load(path)


@pytest.fixture(scope="module")
def runs(scene):
    return [Variation(scene, overrides, seed) for overrides, seed in RUNS]


@pytest.fixture(scope="module")
def found(runs):
    return palpate.simulate(runs, signals=["F_T_W", "depth"], signal_rate=50.0, workers=2)


def equal(a, b, order=slice(None)):
    for key, values in a.summary.items():
        assert key in MEASURED or values.tobytes() == b.summary[key][order].tobytes(), key
    assert a.t.tobytes() == b.t.tobytes()
    for name, values in a.signals.items():
        assert values.tobytes() == b.signals[name][order].tobytes(), name


def test_each_run_is_the_run_of_a_session(runs, found):
    assert len(found) == len(runs)
    for i, run in enumerate(runs):
        session = Session(run.resolved(), seed=run.seed)
        ticks = as_ticks(session.rig.simulation(session.seed).run(600))
        summary = asdict(session.run(0.6))
        for key, values in found.summary.items():
            assert key in MEASURED or values[i] == summary[key], (i, key)
        assert found.faults[i] == summary["faults"]
        rows = np.arange(30) * 20
        assert found.signals["F_T_W"][i].tobytes() == ticks["F_T_W"][rows].tobytes()
        assert found.signals["depth"][i].tobytes() == ticks["depth"][rows].tobytes()
    np.testing.assert_array_equal(found.t, np.arange(30) / 50.0)
    assert found.signals["F_T_W"].shape == (6, 30, 3)
    assert found.signals["depth"].shape == (6, 30)


def test_different_variations_differ_and_equal_ones_agree(found):
    peaks = found.summary["max_penetration_m"]
    assert len(set(peaks[:5])) == 5  # two of them differ only in the seed of the tremor
    assert (found.summary["contact_s"] > 0.0).all()


def test_order_and_number_of_workers_do_not_matter(runs, found):
    options = {"signals": ["F_T_W", "depth"], "signal_rate": 50.0}
    equal(palpate.simulate(runs, workers=1, **options), found)
    equal(palpate.simulate(runs, workers=5, **options), found)
    order = [3, 0, 5, 1, 4, 2]
    equal(palpate.simulate([runs[i] for i in order], workers=2, **options), found, order)


def test_processes_give_the_same_numbers(runs, found):
    swept = palpate.simulate(runs[:3], signals=["F_T_W", "depth"], signal_rate=50.0, executor="local", workers=2)
    equal(swept, found, slice(3))


def test_single_scene_or_file_is_one_run(scene):
    one = palpate.simulate(scene, 0.1)
    assert one.summary["ticks"].tolist() == [100]
    assert one.signals == {}
    equal(palpate.simulate(scene.file, 0.1), one)
    counted = []
    palpate.simulate([scene, scene.file], 0.05, on_progress=counted.append)
    assert counted == [1, 2]


@pytest.mark.parametrize(
    ("overrides", "message"),
    [
        ({"objects.0.stifness": 1.0}, "did you mean 'stiffness'"),
        ({"objects.1.stiffness": 1.0}, "there is no objects[1]"),
        ({"objects.0.stiffness": "soft"}, "stiffness"),
        ({"objects.0.stiffness": 1e9}, "more than the caps allow"),
        ({"preset": "paper"}, "preset cannot be overridden"),
    ],
)
def test_error_for_a_wrong_override_names_the_run(scene, overrides, message):
    with pytest.raises(SceneError) as caught:
        palpate.simulate([Variation(scene), Variation(scene, overrides, 7)], 0.05)
    assert "run 1 (" in str(caught.value)
    assert "seed 7" in str(caught.value)
    assert message in str(caught.value)


def test_invalid_arguments_are_rejected(scene):
    with pytest.raises(PalpateError, match="nothing to simulate"):
        palpate.simulate([])
    with pytest.raises(PalpateError, match="there is no signal 'F_T_V'"):
        palpate.simulate(scene, 0.1, signals=["F_T_V"])
    with pytest.raises(PalpateError, match="workers = 0"):
        palpate.simulate(scene, 0.1, workers=0)
    with pytest.raises(PalpateError, match="do not fit into one array"):
        palpate.simulate([scene, Variation(scene, {"duration": 0.3})], signals=["depth"])


def test_overrides_set_sections_that_the_file_leaves_out(scene):
    made = Variation(scene, {"objects.0.pose.xyz": [0.0, 0.0, 0.01], "stability.force_cap": np.float64(2.5),
                             "operator.hand": "firm"}).resolved()  # fmt: skip
    assert made.objects[0].pose.xyz == (0.0, 0.0, 0.01)
    assert made.stability.force_cap == 2.5
    assert made.operator.stiffness == PRESETS["firm"].stiffness
    assert made.objects[0].friction == 0.1
    assert made.file == scene.file
    assert Variation(scene).resolved() is scene
