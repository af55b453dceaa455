"""`palpate bench contact`: the documented keys, and numbers that hold on any machine."""

from io import StringIO

import json_contract
from rich.console import Console

from palpate_lab.verify.bench import contact


def test_row_has_the_documented_keys_and_beats_the_reference():
    heard = []
    rows = contact.run(shapes=("torus",), sizes=(10_000,), paths=("deep",), on_row=heard.append)
    assert heard == rows
    (row,) = rows
    assert set(row) == json_contract.keys("bench contact")
    assert (row["lost"], row["flipped"]) == (0, 0)
    median, p95, top, magnitude, magnitude_top, step_deg, step_mn = 0.29, 0.61, 0.8, 26, 30, 1.3, 13  # of a prototype
    assert row["direction_median_deg"] <= median
    assert row["direction_p95_deg"] <= p95
    assert row["direction_max_deg"] <= top
    assert row["magnitude_p95_mN"] <= magnitude
    assert row["magnitude_max_mN"] <= magnitude_top
    assert row["step_deg"] <= step_deg
    assert row["step_mN"] <= step_mn
    assert abs(row["energy_mJ"]) < 0.25
    console = Console(width=220, record=True, file=StringIO())
    console.print(contact.table(rows))
    assert "CHAI3D" in console.export_text()


def test_tool_of_many_spheres_is_as_exact_as_one_sphere():
    (row,) = contact.run(shapes=("sphere",), sizes=(10_000,), paths=("tool",))
    assert (row["lost"], row["flipped"]) == (0, 0)
    assert row["direction_p95_deg"] < 0.2
    assert row["magnitude_p95_mN"] < 16 * 10
