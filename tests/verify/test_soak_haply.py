"""`palpate soak haply`: a case of each kind is named and silent; the judge finds what is late and what is not named."""

import json

import json_contract
import pytest

pytest.importorskip("websockets", reason="the stand-in needs the extra haply")

from palpate.cli import main
from palpate_lab.verify.soak import haply


def test_a_service_that_talks_nonsense_and_one_that_dies_are_named(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(haply, "run", lambda repeats, rate, progress: real(repeats, rate, ("malformed", "killed")))
    main(["soak", "haply", "--repeats", "1", "--rate", "500", "--json", str(tmp_path / "soak.json")])
    found = json.loads((tmp_path / "soak.json").read_text())
    assert set(found) | set(found["faults"][0]) <= json_contract.keys("soak haply")
    assert found["rate_Hz"] == 500.0
    for one in found["faults"]:
        assert one["named"] == one["cases"] == 1, one
        assert 0.0 < one["rendered_p50_ms"] <= one["rendered_max_ms"]
    assert found["faults"][0]["motors_max_ms"] is not None
    assert found["faults"][1]["motors_max_ms"] is None, "nobody is there to ask"


real = haply.run


@pytest.mark.parametrize(
    ("seen", "late", "named", "bad"),
    [((0.009, 0.001, True), 0, 1, False), ((0.021, 0.001, True), 1, 1, True), ((0.009, 0.03, True), 1, 1, True),
     ((0.009, 0.001, False), 0, 0, True)],
    ids=["good", "rendered late", "at the motors late", "not named"],
)  # fmt: skip
def test_the_judge_finds_what_is_late_and_what_is_not_named(monkeypatch, seen, late, named, bad):
    monkeypatch.setattr(haply, "_case", lambda fault, rate: seen)
    (found,) = haply.run(1, 500.0, ("stall",))
    assert (found.late, found.named, found.bad) == (late, named, bad)
