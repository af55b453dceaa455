"""The page with sliders: its numbers are the core's, it needs no server, and each slider changes its picture."""

import csv
import json
import re

import numpy as np
import pytest

from palpate.base.errors import PalpateError
from palpate.cli.terminal import chromium
from palpate_lab.reproduce.sliders import gaps, write_sliders
from palpate_lab.verify.bench.browser import open_browser


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("paper")
    methods = ("approach-velocity", "paper-alg1", "face-normal", "paper-plane", "proxy")
    approach = [
        {"approach_deg": a, "method": m, "normal_error_deg": a if m == methods[0] else 1.0, "largest_deg": a}
        for a in (0.0, 40.0, 75.0) for m in methods
    ]  # fmt: skip
    noise = [
        {"radius_mm": r, "noise_mm": n, "kept_of_the_relief": 1.0, "direction_deg": 100 * n / r, "error_mN": 100 * n,
         **{f"error_filtered_at_{cap}_N_per_s_mN": 80 * n for cap in (5, 10, 20, 50)}}
        for r in (1.0, 4.0) for n in (0.0, 0.1, 0.5)
    ]  # fmt: skip
    for name, rows in (("approach", approach), ("noise", noise)):
        (folder / name).mkdir()
        with (folder / name / f"{name}.csv").open("w", newline="") as stream:
            writer = csv.DictWriter(stream, rows[0])
            writer.writeheader()
            writer.writerows(rows)
    return folder


def test_without_its_items_there_is_no_page(tmp_path):
    assert write_sliders(tmp_path) is None
    assert list(tmp_path.iterdir()) == []


def test_page_holds_its_data_and_loads_nothing(folder):
    text = write_sliders(folder).read_text()
    assert not re.search(r"(src|href)=\"https?:", text)
    assert "fetch(" not in text
    data = json.loads(re.search(r"const DATA = (.*);\n", text)[1])
    assert data["approach"][0]["normal_error_deg"] == 0.0
    assert data["noise"][-1]["error_mN"] == 50.0


def test_pairs_of_the_gap_become_collinear():
    pairs = gaps()["pairs"]
    cross, gap = (np.array([p[key] for p in pairs]) for key in ("cross", "gap_mm"))
    assert (np.diff(gap) < 0).all()
    assert (np.diff(cross) < 0).all()
    assert cross[-1] < 1e-6
    assert pairs[-1]["dot"] == pytest.approx(-1.0, abs=1e-12)


def test_each_slider_changes_its_picture(folder):
    if chromium.find() is None:
        pytest.skip("Chromium is not installed (Debian: apt-get install chromium), so the page is not tested")
    page_file = write_sliders(folder)
    try:
        browser = open_browser()
        with browser as page:
            page.open(page_file.as_uri(), (1000, 1200))
            page.wait_for("document.getElementById('remedies') && document.getElementById('remedies').innerHTML")
            move = (
                "(() => {{ const s = document.getElementById('{0}'); s.value = '{1}'; "
                "s.dispatchEvent(new Event('input')); return document.getElementById('{2}').textContent; }})()"
            )
            angle = page.evaluate(move.format("angle", 20, "approach"))
            assert "20.0°" in angle
            assert "1.0°" in angle
            assert "75.0°" in page.evaluate(move.format("angle", 75, "approach"))
            wide, tight = (page.evaluate(move.format("gap", k, "pair")) for k in (0, 60))
            assert wide != tight
            assert "e-7" in tight
            assert "5.0°" in page.evaluate(move.format("noise", 0.05, "remedies"))
            assert page.evaluate(move.format("cap", 3, "cap-out")) == "50 N/s"
    except PalpateError as error:
        pytest.fail(str(error))
