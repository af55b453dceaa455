import numpy as np
import pytest
from json_contract import keys, keys_of

from palpate.scene import Scene
from palpate.scene.rig import build
from palpate.studies.certificate import arms, figures
from palpate.studies.certificate import work as study
from palpate.studies.certificate.arms import table as arms_table


@pytest.fixture(scope="module")
def rows():
    return [{"device": i, **study.judged({"device": i}, seed)} for i, seed in enumerate((3, 4, 7, 11))]


def test_predicted_limits_agree_with_simulated_ones_and_certified_loops_settle(rows):
    assert all(abs(row["error"]) < study.WITHIN for row in rows)
    assert all(row["certified_broken"] == 0 for row in rows)


def test_simulated_limit_agrees_with_a_closed_form():
    """The simulation finds the limit of a loop with a closed form from random disturbances."""
    device, _ = study.drawn(12)
    smooth = study.DeviceModel(device.mass, device.damping, 900.0, 0.004, hand=device.hand)
    exact = smooth.loop(smooth.hands[0]).K_max(1.0)[0]
    assert study.simulated_limit(smooth, 1.0, exact, np.random.default_rng(0)) == pytest.approx(exact, rel=0.01)


def test_devices_depend_on_the_seed():
    assert study.drawn(5) == study.drawn(5) != study.drawn(6)


def test_keys_table_and_figure(rows, tmp_path):
    summary = study.summary(rows)
    assert set(summary) | {"simulated", "seed", "devices", "arms"} == keys("study certificate")
    assert set(rows[0]) == keys_of("study certificate", "A row of `devices`:")
    assert study.table(summary).row_count == 6
    wall = {"scene": "paper", "normal": 0, "B": 5.0, "delay": 0.0, "predicted_N_per_m": 2.0, "simulated_N_per_m": 2.0,
            "error": 0.0, "frequency_Hz": 8.0, "certified_broken": 0.0}  # fmt: skip
    assert set(wall) == keys_of("study certificate", "A row of `arms`:")
    assert arms_table([wall]).row_count == 1
    assert figures.draw(rows, tmp_path).stat().st_size > 10_000


@pytest.mark.parametrize("n", [(0.0, 0.0, 1.0), (0.6, 0.0, 0.8), (0.0, -0.6, 0.8), (-0.48, 0.6, 0.64)])
def test_the_wall_faces_the_tool_and_the_hand_presses_it_along_its_normal(n):
    """The hand's goal lies beyond the wall by the force over the stiffness of wall and hand, on the tool's side."""
    rig, n = build(Scene.parse("objects: [{shape: organ}]\nmapping: {scale: 0.5}")), np.array(n)
    walled = arms._walled(rig, n, 800.0, 5.0, True)
    tip = (rig.arms.X_WB @ rig.arms.follower.fk(rig.arms.q_follower0))[:3, 3]
    X_WO = walled.objects[0].pose.matrix()
    np.testing.assert_allclose(X_WO[:3, 2], n, atol=1e-12)
    np.testing.assert_allclose(tip - X_WO[:3, 3], (rig.scene.contact.radius + arms._GAP) * n, atol=1e-12)
    assert (walled.objects[0].stiffness, walled.objects[0].damping) == ((800.0,) * 3, (5.0,) * 3)
    pressed = arms._PRESS / 800.0 + arms._PRESS * 0.5 / rig.scene.operator.stiffness
    goal = np.array(walled.operator.path[-1].xyz)
    np.testing.assert_allclose(tip - goal, (arms._GAP + pressed) * n, atol=1e-12)
    np.testing.assert_allclose(walled.operator.path[0].xyz, tip, atol=1e-12)
    assert walled.stability.passivity == "off"


@pytest.mark.parametrize(("breaks_above", "broken"), [(0.95, 1.0), (0.99, 0.0)])
def test_prediction_simulated_limit_and_certified_arm_of_a_case(monkeypatch, breaks_above, broken):
    """An arm that swings above 1250 N/m where 1000 are predicted; the complete one above a share of the prediction."""
    monkeypatch.setattr(arms, "limit", lambda rig, n, B: (1000.0, 20.0))

    def swings(rig, n_W, K, B, ideal=True):
        first = 1250.0 if ideal else 1000.0 * breaks_above
        return first < K

    monkeypatch.setattr(arms, "swings", swings)
    found = arms.judged({"scene": "paper", "normal": 0, "B": 5.0, "delay": 0.0}, 1)
    assert found["predicted_N_per_m"] == 1000.0
    assert found["simulated_N_per_m"] == pytest.approx(1250.0, rel=arms._FINE - 1.0)
    assert found["error"] == pytest.approx(1000.0 / found["simulated_N_per_m"] - 1.0)
    assert found["frequency_Hz"] == pytest.approx(20.0 / (2.0 * np.pi))
    assert found["certified_broken"] == broken, "at 0.97 of the prediction"
