"""`palpate study contact`: its keys, and results that hold on any machine."""

from functools import partial
from io import StringIO

import json_contract
import numpy as np
import pytest
from rich.console import Console

from palpate.base.sweep import sweep
from palpate.scene.contact_method import METHODS
from palpate.world.shapes.analytic import SHAPES
from palpate_lab.studies.contact import work as contact
from palpate_lab.studies.contact.figures import draw
from palpate_lab.studies.contact.words import table


@pytest.fixture(scope="module")
def result():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(contact, "DRAWS", 60)
        patch.setattr(contact, "SWEPT", 2_000)
        patch.setattr(contact, "PENETRATIONS", (1e-3, 3e-3, 6e-3))
        patch.setattr(contact, "PLACES", 2)
        yield contact.run((2_000,), partial(sweep, executor="serial"), shapes=("plate",))


def rows(result, **selected):
    found = [r for r in result["rows"] if all(r[k] == v for k, v in selected.items())]
    assert found
    return found


def test_rows_have_the_documented_keys(result):
    keys = json_contract.keys("bench contact") - {
        "load_s",
        "again_s",
        "memory_MB",
        "bytes_per_triangle",
    } | json_contract.keys("study contact")
    assert all(set(r) == keys for r in result["rows"])
    documented = json_contract.keys_of("study contact", "`planes`") - {"null"}
    assert all(set(r) == documented for r in result["planes"])
    assert {r["method"] for r in result["rows"]} == set(METHODS)


def test_default_method_is_accurate_at_every_depth_and_angle(result):
    for r in rows(result, method="proxy"):
        assert (r["lost"], r["flipped"], r["artefacts"]) == (0, 0, 0)
        assert r["direction_max_deg"] < 0.01
        assert r["magnitude_max_mN"] < 0.1


def test_other_methods_fail_in_their_known_cases(result):
    for r in rows(result, method="approach-velocity", path="approach"):
        assert r["direction_median_deg"] == pytest.approx(r["approach_deg"], abs=0.01)
    through = {"path": "penetration", "penetration_mm": 3.0}
    assert rows(result, method="penalty", **through)[0]["flipped"] > 3000
    assert rows(result, method="paper-alg1", path="shallow")[0]["direction_median_deg"] > 3
    assert rows(result, method="paper-plane", path="shallow")[0]["step_deg"] > 10


def test_planes_of_several_points_have_the_expected_noise(result):
    """Least squares tilts by sigma / (s sqrt n) about each axis with s = spread / 4; compared as Rayleigh medians."""
    (r,) = [r for r in result["planes"] if (r["points"], r["spread_mm"], r["noise_um"]) == (15, 0.8, 10.0)]
    law = np.degrees(np.sqrt(2 * np.log(2)) * 10e-6 / (0.8e-3 / 4 * np.sqrt(15)))
    assert r["direction_median_deg"] == pytest.approx(law, rel=0.25)
    refused = {r["spread_mm"]: r["refused"] for r in result["planes"] if (r["points"], r["noise_um"]) == (15, 1.0)}
    assert refused[0.1] == 1.0  # closer than the baseline
    assert refused[0.8] == 0.0


def test_approaches_end_at_the_pressed_depth():
    for shape in ("sphere", "torus"):
        for approach in contact.approaches(SHAPES[shape], 60.0):
            phi, n = SHAPES[shape].distance(approach.tips)
            assert phi[approach.steady] == pytest.approx(contact.RADIUS - contact.PRESSED, abs=1e-9)
            assert phi[0] > contact.RADIUS
            into = np.diff(approach.tips, axis=0)[0]
            end = n[approach.steady.start]
            assert np.degrees(np.arccos(-into @ end / np.linalg.norm(into))) == pytest.approx(60.0, abs=1e-6)


def test_table_and_figures(result, tmp_path):
    console = Console(width=160, record=True, file=StringIO())
    console.print(table(result["rows"]))
    text = console.export_text()
    assert all(method in text for method in METHODS)
    files = draw(result, tmp_path)
    assert len(files) == 4
    assert all(1_000 < f.stat().st_size < 150_000 for f in files)
