"""A policy and a person with a device share an instrument: the device gets the force, the pedal has the authority."""

import time

import numpy as np
import pytest

from palpate.base.errors import PalpateError
from palpate.devices.driver import Driver, Reading
from palpate.record import Record

pytest.importorskip("gymnasium", reason="gymnasium (extra learning) is not installed")

from palpate.gym.mixing import Hand, Mixer
from palpate.gym.shared import SharedDevice, share
from palpate.gym.world import Motion

FLOOR = {
    "objects": [{"name": "floor", "plane": {"size": 0.3}, "stiffness": 1000.0}],
    "operator": {"palpate": {"at": [0, 0, 0], "force": 1.0, "hover": 0.002}},
    "record": {"report": False, "frames": False},
}


class Held(Driver):
    """A device whose handle moves along +x by 0.1 mm at each reading; its clutch is pressed from reading `at` on."""

    rate, force_max, workspace = 250.0, 3.0, (0.1, 0.1, 0.1)

    def __init__(self, at=np.inf):
        self.at, self.wrenches, self.closed, self.read_count = at, [], False, 0

    def read(self):
        self.read_count += 1
        X = np.eye(4)
        X[0, 3] = 1e-4 * self.read_count
        return Reading(X, buttons=int(self.read_count > self.at))

    def write(self, wrench):
        self.wrenches.append(np.array(wrench))

    def close(self):
        self.closed = True


def test_person_feels_what_the_policy_does_and_takes_over_by_the_pedal(tmp_path, monkeypatch):
    """By readings, not by the clock, which a busy machine stretches: the authority passes within 75 of them."""
    rows, moved = [], Mixer.moved

    def spied(mixer, t, hand):
        X = moved(mixer, t, hand)
        rows.append((mixer.share, X[0, 3], hand.X[0, 3]))
        return X

    monkeypatch.setattr(Mixer, "moved", spied)
    device = Held(at=150)
    _, mixer = share(FLOOR, lambda seen: [0, 0, 0.02 * (seen["force"][2] - 0.5), 0, 0, 0], device, 3.0, record=tmp_path)
    authority, goal, hand = np.array(rows).T
    steps, own = np.diff(goal), np.diff(hand)
    np.testing.assert_allclose(steps, (1.0 - authority[1:]) * own, atol=1e-12)  # no jump, wherever the hand is
    assert (authority == 1.0).sum() > 50  # the policy's: none along x
    assert (authority[200:] == 0.0).sum() > 20  # the person's
    assert max(np.linalg.norm(one[:3]) for one in device.wrenches) > 0.1  # the policy pressed, the hand felt it
    assert not device.wrenches[-1].any()
    assert device.closed
    assert mixer.asked.count > 5


def test_a_policy_that_hangs_holds_the_follower_and_the_device_goes_on(tmp_path):
    def hangs(seen):
        hangs.calls += 1
        if hangs.calls > 3:
            time.sleep(5.0)
        return [0, 0, -0.01, 0, 0, 0]

    hangs.calls, device = 0, Held()
    began = time.monotonic()
    summary, mixer = share(FLOOR, hangs, device, 1.0, record=tmp_path)
    assert time.monotonic() - began < 4.5
    record = Record.open(summary.record)
    assert np.ptp(record["p_WT_goal"][record["t"] > 0.6], axis=0).max() < 1e-9
    assert any("silent" in note for note in mixer.asked.notes)
    assert len(device.wrenches) > 50


def test_facts_of_the_device_are_those_of_what_wraps_it():
    device = Held()
    shared = SharedDevice(device, Mixer(Motion(), device.rate, 0.1, "pedal"))
    assert (shared.rate, shared.force_max, shared.workspace) == (250.0, 3.0, (0.1, 0.1, 0.1))
    assert shared.moment_max == 0.0


def test_mixed_steps_add_up_to_the_motion_of_who_has_the_authority():
    """By hand: with the pedal the hand moves all, without it the policy; the ramp between them is linear."""
    mixer = Mixer(Motion(), 1000.0, 0.1, "pedal")
    mixer.answer(lambda seen: [0.03, 0, 0, 0, 0, 0], {}, 0.0)
    x = []
    for k in range(1500):
        mixer.asked.at = 1e-3 * k
        X = np.eye(4)
        X[1, 3] = 1e-5 * k
        x.append(mixer.moved(1e-3 * k, Hand(X, pedal=k >= 700))[:2, 3].copy())
    steps = np.diff(x, axis=0)
    np.testing.assert_allclose(steps[350:690], [[3e-5, 0.0]] * 340, atol=1e-12)
    np.testing.assert_allclose(steps[1010:], [[0.0, 1e-5]] * 489, atol=1e-12)
    share_of_hand = np.arange(1, 290) / 300
    np.testing.assert_allclose(steps[699 : 699 + 289, 1], 1e-5 * share_of_hand, atol=1e-9)


def test_mistakes_are_named():
    with pytest.raises(PalpateError, match="authority = 'voice'"):
        Mixer(Motion(), 1000.0, 0.1, "voice")
    with pytest.raises(PalpateError, match="timeout = 0"):
        Mixer(Motion(), 1000.0, 0.0, "pedal")
    with pytest.raises(PalpateError, match="seconds = inf"):
        share(FLOOR, lambda seen: np.zeros(6), Held(), np.inf)


def test_command_shares_a_simulated_device(tmp_path, capsys):
    import json

    from json_contract import keys

    from palpate.cli import main

    (tmp_path / "mine.py").write_text("def down(seen):\n    return [0, 0, -0.02, 0, 0, 0]\n")
    words = ["policy", "palpation", f"{tmp_path}/mine.py:down", "--duration", "0.6", "--device", "simulated"]
    assert main([*words, "--out", str(tmp_path), "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == keys("policy")
    assert found["actions"] > 0
    assert Record.open(found["record"]).complete
