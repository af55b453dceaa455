"""`palpate bench ros`: the pairing of states and wrenches by hand-made times, and the whole command once, briefly."""

import json

import json_contract
import numpy as np
import pytest

from palpate.cli import main
from palpate.verify.bench.ros import answers


def felt(rows):
    """(received, stamped) -> rows as of the puppet; both clocks alike."""
    out = np.zeros((len(rows), 10))
    out[:, 0], out[:, 2] = [r[0] for r in rows], [r[1] for r in rows]
    return out


def test_each_state_is_paired_with_its_own_answer():
    sent = np.array([0.0, 1e-3, 2e-3, 3e-3])
    rows = [(1.0e-4, 0.8e-4), (1.2e-3, 1.15e-3), (2.9e-3, 2.8e-3), (3.1e-3, 3.05e-3)]
    took, late = answers(sent, felt(rows), 0.0)
    np.testing.assert_allclose(took, [1e-4, 2e-4, 9e-4, 1e-4], atol=1e-12)
    assert late == 0


def test_an_answer_after_the_next_state_counts_against_the_first():
    """Stamped 5 us after the second state: it cannot have known it."""
    sent = np.array([0.0, 1e-3, 2e-3])
    took, late = answers(sent, felt([(1.02e-3, 1.005e-3), (2.1e-3, 2.05e-3)]), 0.0)
    np.testing.assert_allclose(took, [1.02e-3, 1e-4], atol=1e-12)
    assert late == 1


def test_clocks_are_brought_together_and_repeats_count_once():
    sent = np.array([5.0, 5.001])
    rows = felt([(5.0001, 1e9 + 5.00008), (5.0005, 1e9 + 5.0004), (5.0012, 1e9 + 5.0011)])
    took, late = answers(sent, rows, 1e9)
    np.testing.assert_allclose(took, [1e-4, 2e-4], atol=1e-6)
    assert late == 0


def test_the_command_measures_and_keeps_its_contract(built, tmp_path, capsys):
    file = tmp_path / "ros.json"
    assert main(["bench", "ros", "--duration", "1.5", "--rate", "250", "--json", str(file)]) == 0
    told = json.loads(file.read_text())
    assert set(told) | {"sim_cores", "sim_rate_hz"} == json_contract.keys("bench ros")
    assert told["states"] == pytest.approx(375, rel=0.2)
    assert told["lost"] == 0
    assert abs(told["echo_lost"]) < 0.1 * told["echoes"]  # those that are on their way at its ends
    assert 0.0 < told["echo_p50_us"] < told["echo_max_us"]
    assert 0.0 < told["latency_p50_us"] < told["latency_max_us"]
    assert told["force_N"] > 0.1
    assert "bare echo" in capsys.readouterr().out
