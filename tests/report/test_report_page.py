import os
import re
from html.parser import HTMLParser

import numpy as np
import pytest
import synthetic_run

from palpate.base.errors import OutputError
from palpate.record import SIGNALS, Record, Recorder
from palpate.record.ticks import STATUS
from palpate.report import report, write_report
from palpate.report.energy import words as ledger_words
from palpate.report.remote import crossed
from palpate.report.run import Run

pytest.importorskip("matplotlib", reason="the report extra is not installed")
from palpate.base.plotting import style

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


@pytest.fixture
def one_width(monkeypatch, unarranged_figures):
    """Figures of one width alone, because a page with both takes seconds; gives the choice of the width."""

    def choose(k):
        canvas = style.CANVASES[k]
        monkeypatch.setattr(style, "picture", lambda draw, alt: style._data_uri(draw(canvas)))

    with style.style():
        yield choose


def test_lockstep_page_is_reproducible_and_has_no_computing_times(tmp_path, one_width):
    one_width(0)
    record = record_of(tmp_path, synthetic_run.run(0.6))
    assert write_report(record.path) == tmp_path / "report.html"
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page == report(record)
    assert "data:image/svg" in page
    assert "<h2>Time</h2>" not in page
    assert "haptic cycle</td>" not in page


@pytest.mark.parametrize("case", ["one tick", "no contact", "no scene, not finite"])
def test_unusual_runs_have_a_page_too(tmp_path, one_width, case):
    one_width(1)
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
    assert "data:image/svg" in page


def test_a_record_without_signals_of_a_remote_site_tells_nothing_of_one(tmp_path):
    with Recorder(tmp_path / "record.mcap", SCENE, 4, 1000.0, True, linked=False) as recorder:
        recorder.append(synthetic_run.run(0.1))
    assert not crossed(Run(Record.open(tmp_path / "record.mcap")))


def test_unwritable_page_is_reported(tmp_path, monkeypatch):
    monkeypatch.setattr("palpate.report.html._page", lambda run: "")
    record = record_of(tmp_path, synthetic_run.run(0.3))
    with pytest.raises(OutputError, match="the report cannot be written"):
        write_report(record.path, tmp_path / "no" / "page.html")


CHROMIUM = "/usr/bin/chromium"


@pytest.mark.skipif(not os.path.exists(CHROMIUM), reason="Chromium is not installed")
def test_page_fits_the_width_of_a_browser(page, tmp_path):
    playwright = pytest.importorskip("playwright.sync_api", reason="playwright (test group) is not installed")
    (tmp_path / "page.html").write_text(page, encoding="utf-8")
    with playwright.sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        errors: list[str] = []
        for width in (1280, 420):
            view = browser.new_page(viewport={"width": width, "height": 900})
            view.on("pageerror", lambda error: errors.append(str(error)))
            view.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
            view.goto((tmp_path / "page.html").as_uri())
            view.evaluate("document.querySelectorAll('img').forEach(image => image.loading = 'eager')")
            view.wait_for_function("[...document.images].every(image => image.complete)")
            assert view.evaluate("[...document.images].every(image => image.naturalWidth > 100)")
            assert view.evaluate("document.documentElement.scrollWidth") <= width
            assert errors == []
            view.close()
        browser.close()


def test_energy_that_no_element_withholds_is_the_rest(tmp_path):
    """Reference: docs/stability.md. Sources = port + all withheld, and springs and damping take the sources."""
    from palpate.base.plotting.style import CANVASES
    from palpate.report import figures

    ticks = synthetic_run.run(1.0)
    withheld = {"energy_cut": 0.7e-3, "energy_passivity": 0.5e-3, "energy_low_pass": 0.3e-3, "energy_coupling": 0.2e-3}
    ramp, friction = np.linspace(0.0, 1.0, len(ticks)), 0.11e-3
    for name, energy in withheld.items():
        ticks[name] = energy * ramp
    ticks["energy_port"] = ticks["energy_spring"] + ticks["energy_damping"] + friction * ramp
    ticks["energy_port"] -= sum(withheld.values()) * ramp
    (axes,) = figures.energy(Run(record_of(tmp_path, ticks)), CANVASES[1]).axes
    drawn = {line.get_label(): line.get_ydata() for line in axes.lines}
    (rest,) = (y for label, y in drawn.items() if label.startswith("the rest"))
    assert rest[-1] == pytest.approx(1e3 * friction, rel=1e-6)
    for words, name in {
        "caps": "cut",
        "passivity": "passivity",
        "low-pass": "low_pass",
        "coupling": "coupling",
    }.items():
        (curve,) = (y for label, y in drawn.items() if label.startswith("withheld") and words in label)
        assert curve[-1] == pytest.approx(1e3 * withheld[f"energy_{name}"])


def test_words_of_the_ledger_name_each_element_with_its_energy(tmp_path):
    ticks = synthetic_run.run(1.0)
    grows = np.linspace(0.0, 1.0, len(ticks)) ** 4  # so that only the last tick has the whole energy
    ticks["energy_cut"], ticks["energy_passivity"], ticks["energy_low_pass"] = 2e-3 * grows, 3e-3 * grows, -4e-3 * grows
    ticks["energy_source"][:, 0] = 5e-3 * grows
    ticks["energy_source"][:, -2:] = np.outer(grows, [6e-3, 7e-3])
    ticks["status"][100:350] = STATUS["passivity"][0]
    ticks["status"][400:500] = sum(bit for name, (bit, *_) in STATUS.items() if name != "passivity")
    text = ledger_words(Run(record_of(tmp_path, ticks)))
    assert (
        "Energy taken by the end, before limits and filters: floor 5.00 mJ, guidance 6.00 mJ, all others 7.00 mJ."
        in text
    )
    assert "Energy withheld: the caps 2.00 mJ, the passivity controller 3.00 mJ, the low-pass -4.00 mJ." in text
    assert "The passivity controller reduced the force for 0.25 s." in text


def test_words_of_the_ledger_leave_out_what_did_nothing(tmp_path):
    text = ledger_words(Run(record_of(tmp_path, synthetic_run.run(1.0))))
    assert "withheld" not in text
    assert "Energy taken" not in text
    assert "reduced the force" not in text


def test_soft_tissue_is_drawn_beside_its_closed_form():
    """The report reads the tissue of the recorded scene; a rigid scene has none."""
    from types import SimpleNamespace

    from palpate.report.soft import soft_law

    def law(scene):
        return soft_law(SimpleNamespace(setting=lambda key, *rest: scene[key] if not rest else scene[key][rest[0]]))

    objects = [
        {"name": "table"},
        {"name": "liver", "tissue": {"young": 4e3, "poisson": 0.4, "prony": [{"g": 1.0, "tau": 1.0}]}},
    ]
    found = law({"objects": objects, "contact": {"radius": 0.005}})
    assert (found.radius, found.rest, found.poisson) == (0.005, 4e3, 0.4)
    assert 1.8 < found.fast / found.rest < 2.0
    assert law({"objects": objects[:1], "contact": {"radius": 0.005}}) is None
