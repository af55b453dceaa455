"""The JSON of `palpate bench loop` is a contract: its keys, types and units. No timing is asserted."""

import json_contract

from palpate.verify.bench import loop


def test_the_documented_keys_are_there_and_the_table_shows_them():
    told = []
    result = loop.run(0.4, rates=(1000.0, 4000.0), lockstep_seconds=4.0, on_progress=told.append)
    assert set(result) == json_contract.keys("bench loop")
    for row in result["realtime"]:
        assert set(row) == json_contract.keys_of("bench loop", "A row of `realtime`")
    assert [row["rate_hz"] for row in result["realtime"]] == [1000.0, 4000.0]
    assert result["contact_share"] > 0.2  # it felt something
    assert 0 < result["cycle_p50_us"] <= result["cycle_p99_us"] <= result["cycle_p999_us"]
    assert len(told) == 3
    text = loop.table(result)
    assert f"p50 {result['cycle_p50_us']:.2f} us" in text
    assert "1000 Hz control" in text
    assert "4000 Hz loop" in text
