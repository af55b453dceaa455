"""A short soak test: no tool pops through; a method without memory does, which shows that the check can fail."""

import json
from dataclasses import replace

import json_contract
import pytest

from palpate.cli import main
from palpate_lab.verify.soak import contact as soak


def test_nothing_pops_through():
    done = soak.run(8_000, seed=3)
    assert done.passes == 8_000
    assert done.touched > 0.9 * done.passes
    assert done.popped == 0, soak.table(done)


def test_same_seed_gives_the_same_passes():
    one, other = (replace(soak.run(800, seed=5), seconds=0.0) for _ in range(2))
    assert one == other


def test_method_without_memory_pops_through(tmp_path, capsys):
    file = tmp_path / "soak.json"
    assert main(["soak", "contact", "--passes", "1000", "--method", "penalty", "--json", str(file)]) == 1
    done = json.loads(file.read_text())
    assert set(done) == json_contract.keys("soak contact")
    assert done["popped"] > 0.05 * done["passes"]
    assert done["examples"]
    assert "popped through" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"passes": 0}, "passes must be at least 1, got 0"),
        ({"passes": 1, "method": "magic"}, "no contact method 'magic'"),
    ],
)
def test_invalid_arguments_are_reported(arguments, message):
    with pytest.raises(ValueError, match=message):
        soak.run(**arguments)
