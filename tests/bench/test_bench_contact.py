"""`palpate bench contact`: the documented keys, and figures that hold on any machine."""

from io import StringIO

from rich.console import Console

from palpate.bench import contact

KEYS = ["shape", "triangles", "path", "method", "p50_us", "p99_us"]
KEYS += ["direction_median_deg", "direction_p95_deg", "direction_max_deg", "magnitude_p95_mN", "magnitude_max_mN"]
KEYS += ["step_deg", "step_mN", "lost", "flipped", "energy_mJ", "load_s", "memory_MB"]


def test_a_row_has_the_documented_keys_and_beats_the_reference():
    heard = []
    rows = contact.run(shapes=("torus",), sizes=(10_000,), paths=("deep",), on_row=heard.append)
    assert heard == rows
    (row,) = rows
    assert list(row) == KEYS
    assert (row["lost"], row["flipped"]) == (0, 0)
    _, _, median, p95, top, magnitude, magnitude_top, step_deg, step_mn = contact.PROTOTYPE["torus", 10_000]
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
    assert "prototype" in console.export_text()
