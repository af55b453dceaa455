import json

import pytest
from json_contract import keys

from palpate.cli import main

pytest.importorskip("gymnasium", reason="gymnasium (extra learning) is not installed")


def test_bench_counts_the_steps_of_all_environments(capsys):
    assert main(["bench", "gym", "--instruments", "3", "--seconds", "0.2", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found) == keys("bench gym")
    assert found["steps_per_s"] * found["cpu_us_per_step"] < 1.2e6 * found["workers"]
    assert found["cpu_us_per_step"] > 20.0  # 20 ticks of a cycle take longer
    assert found["step_ms"] == 20.0
    assert found["reset_ms"] > 0.0
    if found["control_steps_per_s"]:
        ratio = found["cpu_us_per_step"] / found["control_cpu_us_per_step"]
        assert found["ratio_to_control"] == pytest.approx(ratio)
