"""A policy in the loop: caps, guidance and watchdog hold whatever it does; authority passes without a jump."""

import sys
import time

import numpy as np
import pytest

from palpate.base.errors import PalpateError
from palpate.record import Record

pytest.importorskip("gymnasium", reason="gymnasium (extra learning) is not installed")

from palpate.gym.drive import Hand, drive
from palpate.gym.policy import OnnxPolicy, load_policy

FLOOR = {
    "objects": [{"name": "floor", "plane": {"size": 0.3}, "stiffness": 2000.0}],
    "operator": {"palpate": {"at": [0, 0, 0], "force": 1.0, "hover": 0.01}},
    "stability": {"force_cap": 2.0},
    "record": {"report": False, "frames": False},
}
DOWN = [0.0, 0.0, -0.05, 0.0, 0.0, 0.0]


def recorded(done):
    return Record.open(done.summary.record)


def test_force_stays_below_its_cap_and_the_record_holds_all(tmp_path):
    done = drive(FLOOR, lambda seen: DOWN, 1.5, record=tmp_path)
    record = recorded(done)
    force = np.linalg.norm(record["F_H_L"], axis=1)
    assert len(record) == 1500
    assert force.max() <= 2.0 + 1e-9
    assert force.max() > 1.9
    assert np.abs(np.diff(force)).max() < 0.5
    assert done.actions == 75
    assert done.notes == ()


def test_policy_sees_the_force_and_holds_it(tmp_path):
    """A policy by force ends at its force: what it sees is the newest, and what it asks for is done."""
    done = drive(FLOOR, lambda seen: [0, 0, 0.01 * (seen["force"][2] - 1.0), 0, 0, 0], 4.0, record=tmp_path)
    force = recorded(done)["F_T_W"][-500:, 2]
    np.testing.assert_allclose(force, 1.0, atol=0.05)


class Later:
    """A policy that waits for 0.5 s, in which the fixtures of a new session fade in."""

    def __init__(self):
        self.calls = 0

    def __call__(self, seen):
        self.calls += 1
        return DOWN if self.calls > 25 else np.zeros(6)


def test_hard_guidance_keeps_the_policy_out(tmp_path):
    wall = {"geometry": {"plane": {}}, "frame": {"pose": {"xyz": [0, 0, 0.008]}}, "role": "forbid", "hard": True}
    done = drive(FLOOR | {"guidance": [{"name": "wall", **wall}]}, Later(), 1.5, record=tmp_path)
    assert recorded(done)["p_WT"][:, 2].min() > 0.008
    free = drive(FLOOR, Later(), 1.5, record=tmp_path)
    assert recorded(free)["p_WT"][:, 2].min() < 0.002


def broken(seen):
    broken.calls += 1
    if broken.calls > 10:
        raise RuntimeError("no memory")
    return DOWN


@pytest.mark.parametrize(
    ("policy", "words"),
    [
        (broken, "RuntimeError: no memory"),
        (lambda seen: [np.nan] * 6, "not six finite numbers"),
        (lambda seen: [0.0, 0.0], "not six finite numbers"),
    ],
)
def test_watchdog_stops_the_goal_of_a_policy_that_fails(policy, words, tmp_path):
    broken.calls = 0
    done = drive(FLOOR, policy, 1.0, record=tmp_path)
    goal = recorded(done)["p_WT_goal"]
    assert np.ptp(goal[-500:], axis=0).max() < 1e-9
    assert any(words in note for note in done.notes)


def test_slow_policy_does_not_hold_up_the_loop_in_real_time(tmp_path):
    def slow(seen):
        time.sleep(0.3)
        return DOWN

    began = time.monotonic()
    done = drive(FLOOR, slow, 1.0, record=tmp_path, realtime=True, timeout=0.1)
    took = time.monotonic() - began
    assert 0.9 < took < 4.0
    assert done.actions <= took / 0.3 + 1
    assert any("silent" in note for note in done.notes)
    assert len(recorded(done)) == 1000


class Person:
    """A hand that moves along +x, and takes the authority between 0.5 and 1.5 s."""

    def __init__(self, speed=0.02, jump=0.0):
        self.speed, self.jump, self.felt = speed, jump, []

    def read(self, t):
        X = np.eye(4)
        X[0, 3] = self.speed * t + (self.jump if t > 1.0 else 0.0)
        takes = 0.5 <= t < 1.5
        return Hand(X, gripper=0.1 if takes else 0.8, pedal=takes)

    def feel(self, wrench):
        self.felt.append(wrench.copy())


@pytest.mark.parametrize("by", ["pedal", "gripper"])
def test_authority_passes_without_a_jump(by, tmp_path):
    person = Person()
    done = drive(FLOOR, lambda seen: [-0.03, 0, 0, 0, 0, 0], 2.5, record=tmp_path, person=person, authority=by)
    x = recorded(done)["p_WT_goal"][:, 0]
    speed = np.diff(x[400:]) * 1000
    assert np.abs(speed).max() < 0.031  # never faster than the faster of the two
    assert np.abs(np.diff(speed)).max() < 0.05 / 300 * 1.05  # the change is spread over the ramp of 0.3 s
    np.testing.assert_allclose(np.diff(x[900:1400]) * 1000, 0.02, atol=1e-6)  # the person's
    np.testing.assert_allclose(np.diff(x[2000:]) * 1000, -0.03, atol=1e-6)  # the policy's
    assert done.authority[1200] == 0.0
    assert done.authority[2200] == 1.0
    assert len(person.felt) == 2500


@pytest.mark.parametrize("by", ["pedal", "gripper"])
def test_force_does_not_jump_at_a_hand_over_in_contact(by, tmp_path):
    """The policy holds 1 N; the person, whose hand was moved by 80 mm before, takes over and pulls at 1 mm/s.

    At a hand-over, no step of the force is larger than the goal's own motion explains: stiffness times its step.
    """

    class Pulls(Person):
        def read(self, t):
            X = np.eye(4)
            X[2, 3] = 0.2 * np.clip(t - 1.2, 0.0, 0.4) + 0.001 * max(0.0, t - 2.0)
            takes = 2.0 <= t < 2.8
            return Hand(X, gripper=0.1 if takes else 0.8, pedal=takes)

    def hold(seen):
        return [0, 0, 0.02 * (seen["force"][2] - 1.0), 0, 0, 0]

    done = drive(FLOOR, hold, 4.0, record=tmp_path, person=Pulls(), authority=by)
    force = recorded(done)["F_H_L"]
    steps = np.linalg.norm(np.diff(force, axis=0), axis=1)
    assert np.linalg.norm(force[1990]) == pytest.approx(1.0, abs=0.1)
    assert np.ptp(np.linalg.norm(force[2300:2800], axis=1)) > 0.2  # the person pulls
    over = [*range(1990, 2310), *range(2790, 3110)]
    moved = np.abs(np.diff(recorded(done)["p_WT_goal"][:, 2]))
    assert (steps - 2000.0 * moved)[over].max() < 0.005  # the rest is damping
    assert steps[over].max() < 0.02


def test_motion_without_authority_does_not_move_the_tool(tmp_path):
    """A hand that was moved elsewhere while the policy drove takes over from where the tool is."""

    class Late(Person):
        def read(self, t):
            X = np.eye(4)
            X[0, 3] = 0.2 * min(t, 1.0)  # 200 mm away before it takes over
            return Hand(X, pedal=t >= 1.2)

    done = drive(FLOOR, lambda seen: np.zeros(6), 2.0, record=tmp_path, person=Late())
    x = recorded(done)["p_WT_goal"][:, 0]
    assert np.ptp(x[400:]) < 1e-9


def test_turn_of_a_policy_stops_at_the_tilt_as_in_an_environment(tmp_path):
    done = drive(FLOOR, lambda seen: [0, 0, 0, 0, 0, 2.0], 1.5, record=tmp_path)
    asked = recorded(done)["quat_WT_asked"]
    assert 2.0 * np.arccos(abs(asked[0] @ asked[-1])) == pytest.approx(0.8, abs=1e-3)


def test_hand_that_is_not_a_number_for_a_while_is_a_fault_and_no_jump(tmp_path):
    class Torn(Person):
        def read(self, t):
            X = np.eye(4)
            X[0, 3] = 0.02 * t
            return Hand(np.full((4, 4), np.nan) if 0.6 <= t < 0.61 else X, pedal=True)

    done = drive(FLOOR, lambda seen: np.zeros(6), 1.5, record=tmp_path, person=Torn())
    x = recorded(done)["p_WT_goal"][:, 0]
    assert any("not finite" in fault for fault in done.summary.faults)
    assert np.abs(np.diff(x[400:])).max() < 0.03e-3
    np.testing.assert_allclose(np.diff(x[1200:]) * 1000, 0.02, atol=1e-6)


def test_onnx_file_is_a_policy(tmp_path):
    onnx = pytest.importorskip("onnx", reason="onnx, which writes the network of this test, is not installed")
    pytest.importorskip("onnxruntime", reason="onnxruntime (extra learning) is not installed")
    helper, kind = onnx.helper, onnx.TensorProto.FLOAT
    W = np.zeros((7, 6), np.float32)
    W[2, 2] = 0.01
    graph = helper.make_graph(
        [helper.make_node("Gemm", ["force", "W", "b"], ["action"])], "policy",
        [helper.make_tensor_value_info("force", kind, [1, 7])], [helper.make_tensor_value_info("action", kind, [1, 6])],
        [helper.make_tensor("W", kind, W.shape, W.ravel()), helper.make_tensor("b", kind, [6], [0, 0, -0.01, 0, 0, 0])],
    )  # fmt: skip
    file = tmp_path / "policy.onnx"
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8), file)
    done = drive(FLOOR, OnnxPolicy(file), 4.0, record=tmp_path)
    np.testing.assert_allclose(recorded(done)["F_T_W"][-300:, 2], 1.0, atol=0.05)


def test_policies_are_found_by_name_and_mistakes_are_named(tmp_path):
    (tmp_path / "mine.py").write_text("def down(seen):\n    return [0, 0, -0.05, 0, 0, 0]\n\nx = 3\n")
    assert load_policy(f"{tmp_path}/mine.py:down")({}) == DOWN
    for name, words in [
        (f"{tmp_path}/mine.py:up", "no policy"),
        (f"{tmp_path}/mine.py:x", "int is not a function"),
        ("no.such:thing", "no policy"),
        (f"{tmp_path}/none.py:f", "no policy"),
    ]:
        with pytest.raises(PalpateError, match=words):
            load_policy(name)
    with pytest.raises(PalpateError, match="rate = 2000"):
        drive(FLOOR, lambda seen: DOWN, 1.0, rate=2000.0)
    (tmp_path / "json.py").write_text("import json as other\n\nf = other.dumps\n")
    assert load_policy(f"{tmp_path}/json.py:f").__module__ == "json"
    assert sys.modules["json"].__file__ != f"{tmp_path}/json.py"
    (tmp_path / "raises.py").write_text("1 / 0")
    with pytest.raises(PalpateError, match="ZeroDivisionError"):
        load_policy(f"{tmp_path}/raises.py:f")
    for more, error, words in [
        ({"seconds": np.inf}, PalpateError, "seconds = inf"),
        ({"authority": "voice"}, PalpateError, "authority = 'voice'"),
        ({"goal": (0.0, np.nan, 0.0)}, ValueError, "three finite numbers"),
    ]:
        with pytest.raises(error, match=words):
            drive(FLOOR, lambda seen: DOWN, **{"seconds": 1.0, **more})
    (tmp_path / "bad.onnx").write_bytes(b"nothing")
    with pytest.raises(PalpateError, match="cannot be read"):
        load_policy(str(tmp_path / "bad.onnx"))


def test_command_drives_and_tells(tmp_path, capsys):
    import json

    from json_contract import keys

    from palpate.cli import main

    (tmp_path / "mine.py").write_text("def down(seen):\n    return [0, 0, -0.05, 0, 0, 0]\n")
    name = f"{tmp_path}/mine.py:down"
    assert main(["policy", "palpation", name, "--duration", "1", "--out", str(tmp_path), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == keys("policy")
    assert found["actions"] == 50
    assert Record.open(found["record"]).complete
