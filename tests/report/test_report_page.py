import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import synthetic_run

from palpate.errors import OutputError
from palpate.record import SIGNALS, Record, Recorder
from palpate.report import report, write_report

pytest.importorskip("matplotlib", reason="the report extra is not installed")

SCENE = """\
name: floor <&>
objects: [{name: floor, mesh: /nowhere/floor.stl, stiffness: [500.0, 500.0, 500.0], friction: 0.1}]
mapping: {scale: 0.5, force_scale: 1.0}
stability: {force_cap: 3.0, rate_cap: 50.0}
"""


def record_of(folder, ticks, deterministic=True, scene=SCENE) -> Record:
    with Recorder(folder / "record.mcap", scene, 4, 1000.0, deterministic) as recorder:
        recorder.append(ticks)
    return Record.open(folder / "record.mcap")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    return report(record_of(tmp_path_factory.mktemp("page"), synthetic_run.run(3.0), deterministic=False))


class Outline(HTMLParser):
    """Opened and closed tags, and every address that the page loads."""

    VOID = ("meta", "link", "img", "source", "br")

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.headings: list[str] = []

    def handle_starttag(self, tag, attrs):
        if tag not in self.VOID:
            self.open.append(tag)
        self.addresses += [value for key, value in attrs if key in ("src", "href", "srcset", "action", "data")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def test_page_is_well_formed_and_loads_nothing(page):
    outline = Outline()
    outline.feed(page)
    assert outline.open == []
    assert outline.addresses
    assert all(address.startswith("data:") for address in outline.addresses)
    assert re.search(r"https?://|url\(|@import|<script", page) is None
    assert "Time" in outline.headings


def test_page_names_every_signal_with_its_unit_and_states_that_it_is_simulated(page):
    for name, signal in SIGNALS.items():
        assert f"/{name}</code>" in page, name
        assert signal.unit in page
    assert "load cell are simulated" in page
    assert "floor &lt;&amp;&gt;" in page
    assert "The hand feels 250 N/m" in page
    assert "not available any more" in page


def test_lockstep_page_is_reproducible_and_has_no_computing_times(tmp_path):
    record = record_of(tmp_path, synthetic_run.run(0.6))
    assert write_report(record.path) == tmp_path / "report.html"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page == report(record)
    assert "<h2>Time</h2>" not in page
    assert "haptic cycle</td>" not in page


@pytest.mark.parametrize("case", ["one tick", "no contact", "no scene, not finite"])
def test_unusual_runs_have_a_page_too(tmp_path, case):
    ticks = synthetic_run.run(1.0)
    if case == "one tick":
        ticks = ticks[:1]
    elif case == "no contact":
        for name in ("contacts", "depth", "normal", "delta_x", "F_T_W", "F_spring_W", "F_damping_W"):
            ticks[name] = 0.0
    else:
        ticks["F_cell_L"][300:400] = np.nan
    page = report(record_of(tmp_path, ticks, scene="" if "no scene" in case else SCENE))
    assert "Energy ledger" in page


def test_unwritable_page_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr("palpate.report.html.report", lambda record: "")
    record = record_of(tmp_path, synthetic_run.run(0.3))
    with pytest.raises(OutputError, match="the report cannot be written"):
        write_report(record.path, tmp_path / "no" / "page.html")


CHROMIUM = "/usr/bin/chromium"


@pytest.mark.skipif(not os.path.exists(CHROMIUM), reason="Chromium is not installed")
@pytest.mark.parametrize("width", [1280, 420])
def test_page_fits_the_width_of_a_browser(page, tmp_path, width):
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright (test group) is not installed")
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        view = browser.new_page(viewport={"width": width, "height": 900})
        errors: list[str] = []
        view.on("pageerror", lambda error: errors.append(str(error)))
        view.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        view.goto((tmp_path / "page.html").as_uri())
        view.evaluate("document.querySelectorAll('img').forEach(image => image.loading = 'eager')")
        view.wait_for_function("[...document.images].every(image => image.complete)")
        assert view.evaluate("[...document.images].every(image => image.naturalWidth > 100)")
        assert view.evaluate("document.documentElement.scrollWidth") <= width
        assert errors == []
        browser.close()
