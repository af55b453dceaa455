"""`palpate coverage`: rows as JSON, and a run that continues."""

import json

import json_contract


def test_command_writes_rows_and_continues(palpate, tmp_path):
    how = ("coverage", "--estimate", "pivot", "--trials", "6", "--workers", "1", "--resume", tmp_path / "kept")
    first = palpate(*how, "--json", tmp_path / "one.json")
    again = palpate(*how, "--json", tmp_path / "two.json")
    assert first.code == again.code
    one, two = (json.loads((tmp_path / f"{name}.json").read_text()) for name in ("one", "two"))
    assert one == two
    assert set(one) | set(one["rows"][0]) == json_contract.keys("coverage")
    done = palpate("coverage", "--estimate", "nothing")
    assert done.code == 2
    assert "there is no estimate 'nothing'" in done.err
