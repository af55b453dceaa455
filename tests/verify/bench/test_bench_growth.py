"""The growth of time and memory: exponents by closed form, and those of small sizes, each in a process of its own."""

import json

import json_contract
import numpy as np
import pytest
from rich.console import Console

from palpate.base.errors import PalpateError
from palpate_lab.commands.bench.growth import Command
from palpate_lab.verify.bench import growth

LIMITS = {
    "objects": {"cycle_p50_us": 0.11},  # twice the time for 512 objects
    "fixtures": {"stage_p50_us": 1.2},
    "triangles": {"build_s": 1.3, "p50_us": 0.3, "memory_mb": 1.1},
    "points": {"frame_ms": 1.3, "memory_mb": 1.1},
    "tetrahedra": {"tick_ms": 1.3, "memory_mb": 1.1},
    "pairs": {"second_s": 1.3, "memory_mb": 0.9},
    "duration": {"run_s": 1.2, "report_s": 1.0, "memory_mb": 0.3},
    "participants": {"one_worker_s": 1.1, "two_workers_s": 1.1},
}
"""Largest accepted exponents between the small sizes; ten times the size at 1.3 is twice the time of linear growth."""


@pytest.mark.parametrize("power", [0.0, 1.0, 2.0])
def test_exponent_of_a_power_law(power):
    sizes = np.array([3.0, 10.0, 500.0])
    assert growth.exponent(sizes, 7.0 * sizes**power) == pytest.approx(power)


def test_memory_below_the_noise_and_sizes_that_are_approached():
    rows = [
        {"tetrahedra": 600.0, "tick_ms": 1.0, "memory_mb": 0.1},
        {"tetrahedra": 6000.0, "tick_ms": 10.0, "memory_mb": 4.0},
    ]
    found = growth.growth("tetrahedra", "", (500, 5000), rows)
    assert found["sizes"] == [600.0, 6000.0]
    assert found["exponents"] == pytest.approx({"tick_ms": 1.0, "memory_mb": 0.0})


def judged(names):
    result = growth.run(names, small=True)
    for one in result["axes"]:
        for key, most in LIMITS[one["axis"]].items():
            assert one["exponents"][key] <= most, (one["axis"], key, one["figures"][key])
    return result


def test_objects_and_fixtures_grow_no_faster_than_they_may(tmp_path, monkeypatch):
    """Also the documented keys, the table and the figure of the command; one size in a process of its own."""
    alone = growth._in_a_process
    monkeypatch.setattr(
        growth, "_in_a_process", lambda *one: (alone if one == ("fixtures", 2) else growth.measure)(*one)
    )
    result = judged(("objects", "fixtures"))
    assert set(LIMITS) == set(growth.AXES)
    Console(width=120, record=True, quiet=True).print(growth.table(result))
    monkeypatch.setattr(growth, "run", lambda *args, **kwargs: result)
    Command(json=tmp_path / "g.json", small=True, figure=tmp_path / "g.png")()
    written = json.loads((tmp_path / "g.json").read_text())
    assert set(written) == json_contract.keys("bench growth")
    assert set(written["axes"][0]) == set(result["axes"][0])
    assert (tmp_path / "g.png").stat().st_size > 10_000


def test_a_stopped_measurement_goes_on_with_the_sizes_that_are_left(tmp_path, monkeypatch):
    done = []

    def fails_at_the_second(name, size):
        if len(done) == 1:
            raise PalpateError("stopped")
        done.append(size)
        return {"stage_p50_us": float(size), "memory_mb": 1.0}

    monkeypatch.setattr(growth, "_in_a_process", fails_at_the_second)
    file = tmp_path / "growth.journal"
    with pytest.raises(PalpateError, match="stopped"):
        growth.run(("fixtures",), small=True, resume=file)
    with file.open("ab") as cut:
        cut.write(b'1234 ["fixtures", 32')  # a line that a kill has cut off
    done.append(None)
    (axis,) = growth.run(("fixtures",), small=True, resume=file)["axes"]
    assert done == [2, None, 32]
    assert axis["figures"]["stage_p50_us"] == [2.0, 32.0]
    assert axis["exponents"]["stage_p50_us"] == pytest.approx(1.0)


def test_a_file_of_another_kind_or_version_is_refused_and_stays(tmp_path, monkeypatch):
    monkeypatch.setattr(growth, "_in_a_process", lambda name, size: {"stage_p50_us": float(size), "memory_mb": 1.0})
    notes, file = tmp_path / "notes.json", tmp_path / "growth.journal"
    notes.write_text("[1,\n2]")
    growth.run(("fixtures",), small=True, resume=file)
    monkeypatch.setattr(growth, "identity", lambda: "9.9.9 (new)")
    for other in (notes, file):
        before = other.read_bytes()
        with pytest.raises(PalpateError, match=rf"{other.name}: this is no journal of palpate bench growth"):
            growth.run(("fixtures",), small=True, resume=other)
        assert other.read_bytes() == before


@pytest.mark.long
def test_everything_grows_no_faster_than_it_may():
    judged(tuple(growth.AXES))


def test_an_unknown_axis_is_refused_by_name():
    with pytest.raises(PalpateError, match="no axis 'colour'"):
        growth.run(("colour",), small=True)
