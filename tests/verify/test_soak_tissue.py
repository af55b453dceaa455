"""A short soak test of soft bodies, and faults that its checks must find."""

import json

import json_contract
import pytest

from palpate import _verify
from palpate.cli import main
from palpate_lab.verify.soak import tissue as soak


@pytest.fixture(scope="module")
def done():
    return soak.run(50, seed=3)


def test_nothing_fails_up_to_three_newtons(done):
    assert done.actions == 50
    assert done.total("touched") > 40
    assert done.failures == 0, done
    assert max(body.largest_force_N for body in done.bodies) > 1.0, "it presses hard"


def test_same_seed_gives_the_same_actions():
    one, other = (soak.run(10, seed=5).bodies for _ in range(2))
    assert one == other


def test_held_pokes_come_to_rest_though_the_tool_spans_several_cells(done):
    assert done.total("held") > 10
    ratios = [soak._RADIUS * cells[2] / size[2] for cells, size in map(soak._blocks, range(40))]
    assert min(ratios) == pytest.approx(0.5)
    assert max(ratios) == pytest.approx(1.5)


def test_a_force_that_creeps_faster_than_rest_allows_is_found():
    """No force is as constant as this, because tissue relaxes."""
    strict = _verify.TissueSoakRange()
    strict.restless, strict.decay = 1e-9, 0.0
    assert soak.run(25, seed=3, range_=strict).total("restless") > 5


def test_a_tool_that_goes_through_is_found():
    """Far beyond the thickness of the body, without a limit of the force."""
    through = _verify.TissueSoakRange()
    through.depth, through.force_min, through.force_max = 0.3, 1e6, 2e6
    assert soak.run(30, seed=1, range_=through).failures > 0


def test_command_writes_its_contract(tmp_path, capsys):
    file = tmp_path / "soak.json"
    assert main(["soak", "tissue", "--pokes", "5", "--json", str(file)]) == 0
    written = json.loads(file.read_text())
    assert set(written) == json_contract.keys("soak tissue")
    assert "actions on soft bodies" in capsys.readouterr().out


def test_invalid_number_is_reported():
    with pytest.raises(ValueError, match="pokes must be at least 1, got 0"):
        soak.run(0)


def test_small_cells_do_not_fold_under_the_tool():
    """Without the barrier against inversion the guard stops four of these actions below 3 N, with det F down to -1."""
    report = soak._at_one_body("liver", 25, 81, (8, 8, 4), soak._SIZE, None)
    assert report.touched > 20
    assert report.guarded == 0
    assert report.least_volume > 0.0
