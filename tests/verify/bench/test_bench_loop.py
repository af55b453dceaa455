"""The JSON of `palpate bench loop` has the documented keys, types and units. No timing is asserted."""

import json_contract

from palpate_lab.verify.bench import loop


def test_json_has_the_documented_keys_and_the_table_shows_them():
    progress = []
    result = loop.run(0.4, rates=(1000.0, 4000.0), lockstep_seconds=4.0, arms=2, on_progress=progress.append)
    assert set(result) == json_contract.keys("bench loop")
    for row in result["realtime"]:
        assert set(row) == json_contract.keys_of("bench loop", "A row of `realtime`")
    assert [row["rate_hz"] for row in result["realtime"]] == [1000.0, 4000.0]
    assert result["contact_share"] > 0.2  # control: there is contact
    assert 0 < result["cycle_p50_us"] <= result["cycle_p99_us"] <= result["cycle_p999_us"]
    stages = json_contract.keys_of("bench loop", "An entry of `stages`") - {"p50_us", "p99_us"}
    for part in (result, *result["realtime"]):
        assert set(part["stages"]) == stages
        for time in part["stages"].values():
            assert 0 <= time["p50_us"] <= time["p99_us"]
    assert 0 < result["control_us"]["p50"] <= result["control_us"]["p99"]
    for row in result["arms"]:
        assert set(row) == json_contract.keys_of("bench loop", "A row of `arms`")
    assert [(row["arm"], row["rate_hz"]) for row in result["arms"]] == [(0, 1000.0), (1, 1000.0), (0, 10000.0)]
    assert len(progress) == 5
    text = loop.table(result)
    assert f"p50 {result['cycle_p50_us']:.2f} us" in text
    assert "1000 Hz control" in text
    assert "4000 Hz loop" in text
    assert "stability" in text
