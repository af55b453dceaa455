"""`palpate fuzz`."""

import json

import json_contract


def test_fuzz_command_finds_no_faults(palpate, tmp_path):
    done = palpate("fuzz", "contact", "--runs", "5", "--json", tmp_path / "fuzz.json")
    assert done.code == 0, done.err
    assert "5 cases" in done.out
    report = json.loads((tmp_path / "fuzz.json").read_text())
    assert set(report) == json_contract.keys("fuzz")
    assert report["faults"] == []
