import json
from types import SimpleNamespace

import numpy as np
import pytest
from json_contract import keys, keys_of

from palpate.cli import main
from palpate.scene import Scene
from palpate.scene.rig import build
from palpate_lab.studies.certificate import arms, figures
from palpate_lab.studies.certificate import work as study
from palpate_lab.studies.certificate.arms import table as arms_table


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


def test_devices_lie_in_the_ranges_of_the_page():
    """30 to 1500 g, 200 to 5000 Hz, up to 10 ms, 1 to 50 um, 0.02 to 0.8 N of dry friction: within, and over most."""
    drawn = [study.drawn(seed) for seed in range(150)]
    ranges = {"mass": (0.03, 1.5), "rate": (200.0, 5000.0), "delay": (0.0, 0.01), "quantum": (1e-6, 5e-5),
              "friction": (0.02, 0.8), "damping": (0.02, 5.0)}  # fmt: skip
    for name, (low, high) in ranges.items():
        values = np.array([getattr(device, name) for device, _ in drawn])
        assert low <= values.min() <= low + 0.05 * (high - low), name
        assert 0.85 * high < values.max() <= high, name
    hands = np.array([[d.hand.mass, d.hand.damping, d.hand.stiffness] for d, _ in drawn])
    assert (hands.min(axis=0) >= [0.03, 1.0, 30.0]).all()
    assert (hands.max(axis=0) <= [0.8, 25.0, 1000.0]).all()
    assert (hands.max(axis=0) > [0.7, 22.0, 880.0]).all()
    filters = np.array([d.filter for d, _ in drawn])
    assert np.mean(filters == 0.0) == pytest.approx(0.3, abs=0.1)
    assert filters[filters > 0.0].min() >= 10.0
    assert filters.max() <= 300.0
    B = np.array([b for _, b in drawn])
    most = np.array([min(d.loop(d.hand).B_max, 20.0) for d, _ in drawn])
    assert np.mean(B == 0.0) == pytest.approx(0.2, abs=0.1)
    assert (0.6 * most >= B).all()
    assert (B / most).max() > 0.55


def test_random_disturbances_have_at_most_the_energy_of_a_tap_and_press_within_their_range(monkeypatch):
    """Free ones meet a spring in any phase; presses meet a wall, and begin near its equilibrium or at full speed."""
    device, _ = study.drawn(12)
    calls = []

    class Axis:
        def __init__(self, options):
            self.bilateral = options.bilateral

        def run(self, x0, v0, push):
            calls.append((self.bilateral, x0, v0, push))
            return SimpleNamespace(oscillates=False)

    monkeypatch.setattr(study._verify, "Axis", Axis)
    K = 500.0
    assert not study.oscillates(device, K, 1.0, 300, np.random.default_rng(1))
    spring, x0, v0, push = (np.array(column) for column in zip(*calls, strict=True))
    assert len(calls) == 300
    assert (spring == (push == 0.0)).all()
    assert spring.sum() == 100
    stiff, M = K + device.hand.stiffness, device.mass + device.hand.mass
    share = (stiff * (x0 - push / stiff) ** 2 + M * v0**2) / (M * 0.5**2)
    assert share.max() <= 1.0 + 1e-9
    assert np.mean(share > 0.5) == pytest.approx(0.5 + 0.08, abs=0.08), "every second one is nearly a tap"
    assert share.min() < 2e-3
    presses = push[~spring]
    assert 0.2 <= presses.min() < 0.25
    assert 8.0 < presses.max() <= 10.0
    turned = np.abs(np.arctan2((x0 - push / stiff) * np.sqrt(stiff / M), v0))
    assert np.minimum(turned, np.pi - turned)[~spring].max() <= 0.5 + 1e-9
    assert 0.3 * np.pi < np.median(turned[spring]) < 0.7 * np.pi


@pytest.mark.parametrize(
    ("edge", "limit"), [(20.0, 0.0), (40.0, 40.0), (1000.0, 1000.0), (9000.0, 9000.0), (2e9, np.inf)]
)
def test_the_simulated_limit_is_searched_from_3_percent_of_the_expected_one_to_a_gigantic_one(monkeypatch, edge, limit):
    monkeypatch.setattr(study, "oscillates", lambda device, K, B, throws, rng: edge < K)
    assert study.simulated_limit(None, 0.0, 1000.0, None) == pytest.approx(limit, rel=0.003)


def test_the_summary_counts_devices_within_5_percent_and_broken_gains():
    rows = [{"error": e, "linear_N_per_m": 110.0, "simulated_N_per_m": 100.0, "certified_broken": b}
            for e, b in ((0.01, 0.0), (-0.03, 1.0), (0.051, 0.0), (-0.2, 2.0))]  # fmt: skip
    assert study.summary(rows) == pytest.approx({
        "count": 4, "median_error": 0.0405, "largest_error": 0.2, "share_within": 0.5, "linear_median_error": 0.1,
        "certified_gains": 16, "certified_broken": 3,
    })  # fmt: skip


def test_a_press_swings_if_its_amplitude_is_felt_and_does_not_decay(monkeypatch):
    t = np.linspace(0.0, 4.0, 4000)
    wave = np.sin(40.0 * t)
    for x, expected in (
        (1e-4 * wave, True), (1e-4 * np.exp(0.2 * t) * wave, True), (1e-2 * np.exp(-2.0 * t) * wave, False),
        (1.9e-5 * wave, False), (2.1e-5 * wave, True),
        (np.where(t < 1.5, 1e-2 * wave, 0.0) + 1e-3 * np.exp(-t) * wave, False),
    ):  # fmt: skip
        monkeypatch.setattr(arms, "_press", lambda *_, x=x: (x, None))
        assert arms.swings(None, None, 500.0, 0.0) == expected


@pytest.mark.parametrize(("ideal", "K", "cap"), [(True, 2500.0, 1e3), (False, 2500.0, 5.0), (False, 900.0, 3.0)])
def test_the_ideal_arm_has_no_friction_counts_or_caps(monkeypatch, ideal, K, cap):
    """The complete one has a cap of 3 N, or of 2 mm times the stiffness if this is more."""
    rig, seen = build(Scene.parse("objects: [{shape: organ}]")), []

    class StoppedError(Exception):
        pass

    def stopped(o, *_):
        seen.append(o)
        raise StoppedError

    monkeypatch.setattr(arms._core, "Simulation", stopped)
    with pytest.raises(StoppedError):
        arms._press(rig, np.array([0.0, 0.0, 1.0]), K, 5.0, ideal)
    leader, caps = seen[0].leader, seen[0].stability
    assert (np.any(leader.coulomb), leader.quantised) == (not ideal, not ideal)
    assert caps.force_cap == pytest.approx(cap)
    assert caps.rate_cap == pytest.approx(1e6 if ideal else max(50.0, 0.05 * K))


def cells(table):
    return [[str(cell) for cell in column.cells] for column in table.columns]


def test_tables_state_errors_in_percent_and_delays_in_milliseconds():
    summary = {"count": 40, "median_error": 0.0025, "largest_error": 0.042, "share_within": 0.975,
               "linear_median_error": 0.031, "certified_gains": 160, "certified_broken": 2}  # fmt: skip
    assert cells(study.table(summary))[1] == [
        "40", "0.25 %", "4.2 %", "97.5 % of the devices", "3.10 % median disagreement", "2 of 160"]  # fmt: skip
    wall = {"scene": "paper", "normal": 1, "B": 5.0, "delay": 0.006, "predicted_N_per_m": 205.2, "error": 0.024,
            "simulated_N_per_m": 200.4, "frequency_Hz": 8.0, "certified_broken": 1.0}  # fmt: skip
    rows = cells(arms_table([wall, wall | {"certified_broken": 0.0}]))
    assert [column[0] for column in rows] == ["paper", "0.6, 0, 0.8", "6 ms", "5", "205", "200", "2.4 %", "swings"]
    assert rows[-1][1] == "rests"


def test_swings_are_an_option_of_the_command(tmp_path):
    file = tmp_path / "swings.json"
    command = [
        "study",
        "certificate",
        "--swings",
        "4",
        "--seed",
        "3",
        "--json",
        str(file),
        "--out",
        str(tmp_path / "s.nc"),
    ]
    assert main([*command, "--figures", str(tmp_path), "--workers", "1"]) == 0
    found = json.loads(file.read_text())
    assert (found["loops"], found["seed"], [run["run"] for run in found["runs"]]) == (4, 3, ["needed", "short"])
    assert all(run["growing"] + run["decaying"] <= 4 for run in found["runs"])


def test_normals_of_the_pressed_planes_are_unit_vectors():
    assert np.linalg.norm(arms.NORMALS, axis=1) == pytest.approx(np.ones(3))
