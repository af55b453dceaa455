"""Claims of the certificate that no other test states: the sure stiffness, advice about delay, trials, poses."""

from types import SimpleNamespace

import numpy as np
import pytest

import palpate
from palpate import _verify
from palpate.arm.hands import PRESETS
from palpate.base.errors import OutputError, RecordingError
from palpate.devices.certificate import certify_all, trials
from palpate.devices.certificate.certificate import Case, Certificate, judge
from palpate.devices.certificate.device import as_viscous
from palpate.devices.certificate.scene import _DIRECTIONS, _along, _poses, worst_of
from palpate.scene.rig import build

DEVICE = palpate.DeviceModel(mass=0.3, damping=0.6, rate=1000, delay=0.009, filter=50, quantum=1e-5, friction=0.05)


def test_sure_stiffness_is_97_percent_of_the_lower_limit():
    limits = palpate.certify(DEVICE, B=0.6)
    assert limits.k_sure == pytest.approx(0.97 * min(limits.k_max, limits.k_linear))
    assert palpate.certify(DEVICE, K=0.999 * limits.k_sure, B=0.6).verdict == "stable"
    assert palpate.certify(DEVICE, K=1.001 * limits.k_sure, B=0.6).verdict != "stable"


@pytest.mark.parametrize(
    ("K", "k_max", "k_linear", "verdict", "margin"),
    [
        (None, 100.0, 100.0, None, None),
        (0.0, 100.0, 100.0, "stable", None),
        (0.0, 0.0, 0.0, "unstable", None),
        (0.5, 0.3, 0.3, "unstable", -0.4),
        (96.9, 100.0, 100.0, "stable", 100.0 / 96.9 - 1.0),
        (97.1, 100.0, 100.0, "marginal", 100.0 / 97.1 - 1.0),
        (103.0, 100.0, 100.0, "marginal", 100.0 / 103.0 - 1.0),
        (103.2, 100.0, 100.0, "unstable", 100.0 / 103.2 - 1.0),
        (60.0, 120.0, 50.0, "marginal", 1.0),  # dry friction alone holds it
        (60.0, 50.0, 120.0, "unstable", -1.0 / 6.0),
        (5.0, np.inf, np.inf, "stable", None),
    ],
)
def test_verdict_is_stable_below_97_percent_of_both_limits_and_unstable_3_percent_above(
    K, k_max, k_linear, verdict, margin
):
    found = judge(K, k_max, k_linear)
    assert found[0] == verdict
    assert found[1] == (margin if margin is None else pytest.approx(margin))


@pytest.mark.parametrize(("delay", "advice"), [(0.009, "3 ms less delay"), (0.0012, "0.4 ms less delay"), (0.0, "")])
def test_advice_is_a_third_less_delay_in_whole_milliseconds_where_possible(delay, advice):
    reason = palpate.certify(palpate.DeviceModel(mass=0.3, damping=0.6, rate=1000, delay=delay), K=1e5, B=0.6).reason
    assert (advice in reason) if advice else ("less delay" not in reason)


def test_free_taps_meet_a_spring_and_presses_a_wall_each_with_the_energy_of_its_tap(monkeypatch):
    calls = []

    class Seen:
        def __init__(self, options):
            self.bilateral = options.bilateral

        def run(self, x0, v0, push):
            calls.append((self.bilateral, x0, v0, push))
            return SimpleNamespace(oscillates=False)

    monkeypatch.setattr(_verify, "Axis", Seen)
    monkeypatch.setattr(type(DEVICE), "axis", lambda self, hand, K, B, both: SimpleNamespace(bilateral=both))
    hand, K = next(iter(PRESETS.values())), 500.0
    assert not trials.oscillates(DEVICE, hand, K, 1.0)
    stiff, mass = K + hand.stiffness, DEVICE.mass + hand.mass
    for (bilateral, x0, v0, push), trial in zip(calls, trials.TRIALS, strict=True):
        assert bilateral == (push == 0.0), "only who presses may leave the wall"
        away = x0 - push / stiff
        assert 0.5 * stiff * away**2 + 0.5 * mass * v0**2 == pytest.approx(0.5 * mass * trial.tap**2)
    pressed = [(x0 - push / stiff, v0) for _, x0, v0, push in calls if push]
    assert min(v0 for _, v0 in pressed) < 0.0 < max(v0 for _, v0 in pressed), "towards the wall and away from it"
    assert min(away for away, _ in pressed) < 0.0 < max(away for away, _ in pressed)


def test_a_device_that_always_oscillates_has_no_stable_stiffness(monkeypatch):
    monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B: True)
    assert trials.limit(DEVICE, next(iter(PRESETS.values())), 0.0, 500.0) == 0.0


@pytest.mark.parametrize(("expected", "edge"), [(500.0, 200.0), (0.5, 0.2)])
def test_the_limit_of_trials_is_where_they_begin_to_oscillate(monkeypatch, expected, edge):
    monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B: edge < K)
    found = trials.limit(DEVICE, next(iter(PRESETS.values())), 0.0, expected)
    assert found == pytest.approx(edge, rel=0.02)
    assert found <= edge, "a stiffness at which no trial oscillates"


def test_trials_go_to_130_percent_with_friction_and_to_the_linear_limit_without(monkeypatch):
    hand, dry, smooth = PRESETS["normal"], DEVICE, palpate.DeviceModel(mass=0.3, damping=0.6)
    for edge, limits in ((600.0, (600.0, 500.0)), (400.0, (400.0, 400.0)), (1e9, (650.0, 500.0))):
        monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B, edge=edge: edge < K)
        assert [trials.limit(one, hand, 0.0, 500.0) for one in (dry, smooth)] == pytest.approx(limits, rel=0.004)
    for expected in (0.0, np.inf):
        assert trials.limit(dry, hand, 0.0, expected) == expected


def test_each_trial_starts_with_the_energy_of_its_tap_on_a_spring_or_a_wall(monkeypatch):
    runs = []

    class Axis:
        def __init__(self, options):
            self.bilateral = options.bilateral

        def run(self, x0, v0, push):
            runs.append((self.bilateral, x0, v0, push))
            return type("Run", (), {"oscillates": False})

    monkeypatch.setattr(_verify, "Axis", Axis)
    hand, K = PRESETS["normal"], 700.0
    assert not trials.oscillates(DEVICE, hand, K, 1.0)
    assert len(runs) == len(trials.TRIALS)
    for (bilateral, x0, v0, push), trial in zip(runs, trials.TRIALS, strict=True):
        assert (bilateral, push) == (trial.spring, trial.press)
        stiff, M = K + hand.stiffness, DEVICE.mass + hand.mass
        energy = 0.5 * M * v0**2 + 0.5 * stiff * (x0 - push / stiff) ** 2
        assert energy == pytest.approx(0.5 * M * trial.tap**2)


def test_poses_of_a_scene_place_the_tool_on_the_operators_path():
    rig = build(
        palpate.Scene.parse("""
mapping: {scale: 0.5}
objects: [{name: table, plane: {size: 0.3}, stiffness: 800}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0.01, -0.005, 0.01]}, {t: 2, xyz: [0.02, 0.01, -0.001]}]}
""")
    )
    arms = rig.arms
    start = arms.leader.fk(arms.q_leader0)[:3, 3]
    tool = (arms.X_WB @ arms.follower.fk(arms.q_follower0))[:3, 3]
    found = dict(_poses(rig))
    assert len(found) >= 2
    for words, q in found.items():
        if words == "at the start":
            continue
        t = float(words.split()[1])
        wanted = rig.path.positions_W[np.argmin(np.abs(rig.path.times - t))]
        moved = arms.X_WL[:3, :3] @ (arms.leader.fk(q)[:3, 3] - start)
        np.testing.assert_allclose(tool + 0.5 * moved, wanted, atol=5e-4)


def test_bounds_frequency_and_hands_of_a_device():
    """References: the published bounds, with the jitter in the delay, and the loop of the most critical hand."""
    device = palpate.DeviceModel(
        0.3, 3.0, 800.0, 0.003, jitter=0.001, quantum=2e-5, friction=0.01, hand=(PRESETS["light"], PRESETS["relaxed"])
    )
    found = palpate.certify(device, B=1.0)
    lag = 0.5 / 800.0 + 0.004
    least = min(PRESETS[name].damping for name in ("light", "relaxed"))
    assert found.bounds == pytest.approx({
        "colgate_brown": (3.0 - 1.0) / lag,
        "colgate_brown_with_hand": (3.0 + least - 1.0) / lag,
        "abbott_okamura": min(2.0 * 3.0 * 800.0, 2.0 * 0.01 / 2e-5),
    })  # fmt: skip
    frictionless = palpate.DeviceModel(0.3, 3.0, 800.0, 0.003, hand=PRESETS["light"])
    alone = palpate.certify(frictionless, K=1e5, B=1.0)
    K, w = frictionless.loop(PRESETS["light"]).K_max(1.0)
    assert (alone.k_linear, alone.frequency) == pytest.approx((K, w / (2.0 * np.pi)))
    assert f"it would swing at {alone.frequency:.3g} Hz, hand light" in alone.reason


def test_trials_press_with_02_to_10_newtons_and_tap_both_ways():
    walls = [t for t in trials.TRIALS if not t.spring]
    presses = sorted({t.press for t in walls})
    np.testing.assert_allclose(presses, 0.2 * 50.0 ** (np.arange(9) / 8), rtol=1e-12)
    for k, press in enumerate(presses):
        taps = sorted((t.tap for t in walls if t.press == press), key=abs)
        np.testing.assert_allclose(taps, 0.5 * np.array([0.07, -0.3, 1.0 if k % 2 else -1.0]), rtol=1e-12)
        assert all(abs(t.phase) <= 0.3 for t in walls), "nearly all of the energy is speed"
    assert min(t.phase for t in walls) < 0.0 < max(t.phase for t in walls)
    assert {t.tap for t in trials.TRIALS if t.spring} == {0.5, 0.5 / 3.0}


def test_directions_are_the_axes_and_their_bisectors():
    axes = np.eye(3)
    wanted = [
        *axes,
        *((axes[i] + sign * axes[j]) / np.sqrt(2.0) for i in range(3) for j in range(i) for sign in (1, -1)),
    ]
    alike = np.abs(np.array(_DIRECTIONS) @ np.array(wanted).T) > 1.0 - 1e-12
    assert (alike.sum(axis=0) == 1).all()
    assert (alike.sum(axis=1) == 1).all()


def test_the_worst_certificate_has_the_smallest_ratio_of_limit_to_stiffness():
    def of(k_max, K):
        return Certificate(0.0, k_max, k_max, 1.0, "", K, None, None, "")

    order = [of(0.0, 500.0), of(0.3, 1.0), of(400.0, 500.0), of(900.0, 500.0), of(np.inf, 500.0)]
    for k in range(len(order)):
        assert worst_of(order[: k - 1 : -1] if k else order[::-1]) is order[k]
    assert worst_of([of(100.0, None), order[3]]) is order[3]


def test_a_device_is_read_as_it_was_written(tmp_path):
    DEVICE.save(tmp_path / "d.yaml", {"bench": 3})
    assert palpate.DeviceModel.load(tmp_path / "d.yaml") == DEVICE
    with pytest.raises(OutputError, match="cannot be written"):
        DEVICE.save(tmp_path / "absent" / "d.yaml")


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("kind: hand\nmass: 1\n", "no line kind: device"), ("kind: device\nmas: 1\nx: 1\n", "unknown key 'mas'"),
        ("kind: device\nmass: heavy\n", "mass = 'heavy' is no number"), ("kind: device\nmass: 1\n", "damping"),
        ("kind: device\nmass: true\n", "mass = True is no number"), ("kind: device\nmass: [\n", "flow"),
        (None, "No such file"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_device_is_refused_with_its_reason(tmp_path, text, why):
    if text is not None:
        (tmp_path / "d.yaml").write_text(text)
    with pytest.raises(RecordingError, match=why):
        palpate.DeviceModel.load(tmp_path / "d.yaml")


def test_a_fixture_is_judged_in_all_directions_whatever_the_objects_are():
    rest = """
operator: {path: [{t: 0, xyz: [0, 0, 0.04]}, {t: 1, xyz: [0, 0, 0.035]}]}
guidance: [{name: wall, role: forbid, geometry: {plane: {}}, law: {stiffness: 500, damping: 1}}]
"""
    plane, ball = (
        certify_all(palpate.Scene.parse(f"objects: [{{name: a, {shape}, stiffness: 500}}]{rest}"))[-1]
        for shape in ("plane: {size: 0.3}", "sphere: {radius: 0.02}")
    )
    assert plane.name == ball.name == "fixture wall"
    assert plane.k_max == pytest.approx(ball.k_max, rel=1e-9)
    assert plane.worst == ball.worst


@pytest.mark.parametrize(
    ("B", "largest", "top"), [(2.0, (100.0, 50.0), 30.0), (10.0, (100.0, 50.0), 40.0), (2.0, (100.0, 7.0), 7.0)]
)
def test_the_boundary_reaches_30_or_four_times_the_damping_or_the_largest_stable_one(B, largest, top):
    """Each point is the limit of the worst case."""

    def case(B_max):
        return Case("", SimpleNamespace(B_max=B_max, K_max=lambda b: (1e3 - B_max - b, 1.0)))

    limits = Certificate(B, 1.0, 1.0, 1.0, "", None, None, None, "", cases=tuple(map(case, largest)))
    dampings, K = limits.boundary(21)
    np.testing.assert_allclose(dampings, np.linspace(0.0, top, 21), rtol=1e-5)
    np.testing.assert_allclose(K, 900.0 - dampings)


def test_viscous_friction_dissipates_as_much_as_dry_friction():
    """Reference: the work of both over one period of a velocity with amplitude 0.4 m/s."""
    v = 0.4 * np.sin(np.linspace(0.0, 2.0 * np.pi, 10001))
    dry, viscous = np.mean(0.3 * np.abs(v)), np.mean(as_viscous(0.3, 0.4) * v**2)
    assert viscous == pytest.approx(dry, rel=1e-3)


def test_jitter_counts_as_delay_in_full():
    late, jitter = (palpate.DeviceModel(0.3, 2.0, delay=d, jitter=j) for d, j in ((0.005, 0.0), (0.003, 0.002)))
    hand = PRESETS["normal"]
    assert jitter.loop(hand).K_max(1.0) == pytest.approx(late.loop(hand).K_max(1.0))


@pytest.mark.parametrize(
    ("n", "text"),
    [((0, 0, -1), "along z"), ((1, 0, 0), "along x"), ((0.6, 0, 0.8), "along (0.60, 0.00, 0.80)"),
     ((0.6, 0, -0.8), "along (-0.60, 0.00, 0.80)")],
)  # fmt: skip
def test_a_direction_in_words_points_along_its_largest_component(n, text):
    assert _along(np.array(n)) == text


def test_a_tilted_plane_is_judged_along_its_normal():
    tilted = palpate.Scene.parse("""
objects: [{name: table, plane: {size: 0.3}, stiffness: 800, pose: {rpy_deg: [0, 30, 0]}}]
operator: {path: [{t: 0, xyz: [0, 0, 0.02]}, {t: 1, xyz: [0, 0, 0.019]}]}
""")
    assert palpate.certify(tilted).worst.startswith("pressing along (0.50, 0.00, 0.87) ")


@pytest.mark.parametrize(("share", "leans"), [(0.9, True), (0.5, False)])
def test_a_marginal_stiffness_leans_on_friction_only_beyond_the_limit_without(monkeypatch, share, leans):
    """The limit of the simulated trials is a share of the linear one with friction; the frictionless one is 60 %."""
    monkeypatch.setattr(trials, "oscillates", lambda device, hand, K, B: True)
    monkeypatch.setattr(trials, "limit", lambda device, hand, B, expected: share * expected)
    hand = PRESETS["light"]
    device = palpate.DeviceModel(0.05, 0.05, 1000.0, 0.006, friction=0.5, hand=hand)
    dry, smooth = (device.loop(hand, lubricated).K_max(0.0)[0] for lubricated in (False, True))
    assert share * dry < 0.9 * smooth or leans
    found = palpate.certify(device, K=share * dry)
    assert found.verdict == "marginal"
    assert ("it leans on the device's dry friction" in found.reason) == leans
