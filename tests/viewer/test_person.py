"""A person's trials: a real browser from the first page to the last answer, a closed browser, a lost device."""

import threading
import time

import numpy as np
import pytest
from browser import on_screen, open_page

from palpate.base.errors import DeviceError
from palpate.experiment import ExperimentFile, Study, run_participant
from palpate.experiment import person as person_module
from palpate.experiment.person import Person
from palpate.record import Record
from palpate.viewer.server import close_server, open_server

SCENE = "objects: [{name: table, plane: {size: 0.2}, stiffness: 200, damping: 2}]\nmapping: {scale: 0.5}\n"
FILE = """\
title: Two trials
participants: [P01]
conditions:
  none: {felt: false}
  cues: {felt: false, cues: {displaced: 1, dimple: 2, colour: 1, bar: 2, tone: 1}}
order: seeded
tasks: {reach: {words: Reach the mark., scene: table.yaml, path: [[0, 0, 0.009], [0, 0, -0.003]], near: 0.009,
                dwell: 8.0, time_limit: 300}}
familiarisation: 0
repetitions: 1
questionnaires: {likert: [{name: clear, words: The force was clear to me.}], preference: true}
measures: [time_s]
"""
LOST = """\
import numpy as np
from palpate.devices import Driver


class Lost(Driver):
    workspace = (0.2, 0.2, 0.2)
    reads = 0

    def read(self):
        Lost.reads += 1
        if Lost.reads > 200:
            raise OSError("cable pulled")
        return np.eye(4)

    def write(self, wrench):
        pass
"""


@pytest.fixture
def study(tmp_path):
    (tmp_path / "table.yaml").write_text(SCENE)
    (tmp_path / "two.yaml").write_text(FILE)
    return Study(ExperimentFile.load(tmp_path / "two.yaml"), tmp_path / "data")


@pytest.fixture
def server():
    made = open_server("127.0.0.1", 0, "Two trials")
    yield made
    close_server(made)


def without_pages(person, monkeypatch):
    monkeypatch.setattr(person.pages, "show", lambda *words: None)
    return person


def test_a_browser_that_was_closed_aborts_the_trial_with_its_reason(study, server, tmp_path, monkeypatch):
    monkeypatch.setattr(person_module, "ALONE", 0.3)
    person = without_pages(Person(study, server), monkeypatch)
    done = person.perform(study.plan["P01"][0], tmp_path / "trial")
    assert (done.outcome.result, done.outcome.reason) == ("aborted", "the browser was closed")
    assert Record.open(done.record).complete, "what was done until then is kept"


def test_a_device_that_is_lost_aborts_the_trial_with_its_reason(study, server, tmp_path, monkeypatch):
    (tmp_path / "lost_device.py").write_text(LOST)
    (tmp_path / "table.yaml").write_text(SCENE + "arms: {leader: {driver: lost_device:Lost}}\n")
    monkeypatch.setattr(person_module, "ALONE", 30.0)
    lost = Study(study.experiment, tmp_path / "lost", trust=True)
    person = without_pages(Person(lost, server), monkeypatch)
    done = person.perform(lost.plan["P01"][0], tmp_path / "trial")
    assert done.outcome.result == "aborted"
    assert "cable pulled" in done.outcome.reason
    assert person._reason == done.outcome.reason, "the next page says why the trial is repeated"


def test_a_device_that_cannot_be_opened_aborts_the_trial(study, server, tmp_path, monkeypatch):
    def refuse(self):
        raise DeviceError("no device is connected")

    monkeypatch.setattr(person_module._JudgedSession, "start", refuse)
    person = without_pages(Person(study, server), monkeypatch)
    done = person.perform(study.plan["P01"][0], tmp_path / "trial")
    assert (done.outcome.result, done.outcome.reason) == ("aborted", "no device is connected")


def wait(condition, seconds=90.0):
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.05)


def drag_down(page, server, person):
    """Drag the ball down by 24 mm: the tool sinks half as far, into the table. Again, if the page was still moving."""
    wait(lambda: person.view is not None and person.view.frames > 3)
    for _ in range(10):
        time.sleep(1.0)
        ball = np.array(person.view.ball.position)
        start, end = on_screen(page, server, ball), on_screen(page, server, ball - np.array([0.0, 0.0, 0.024]))
        page.mouse.move(*start)
        page.mouse.down()
        for share in np.linspace(0.2, 1.0, 5):
            page.mouse.move(*(np.array(start) + share * (np.array(end) - start)))
            time.sleep(0.1)
        time.sleep(1.0)
        if person.view is None or person.view.ball.position[2] < ball[2] - 0.015:
            return
        page.mouse.up()
    pytest.fail("the ball does not follow the mouse")


@pytest.mark.long
def test_two_trials_and_all_questions_in_a_browser(study, server):
    person, said = Person(study, server), []
    run = threading.Thread(target=run_participant, args=(study, "P01", person, said.append), daemon=True)
    with open_page(person.url, ready="#root") as page:
        run.start()
        shown = []
        for _ in range(2):
            page.get_by_role("button", name="Start").click()
            drag_down(page, server, person)
            if person.cues.bar > 0.0:
                bar = "parseFloat((document.getElementById('palpate-cue-bar') || {style: {}}).style.width) || 0"
                wait(lambda bar=bar: page.evaluate(bar) > 0.0)
                wait(lambda: page.evaluate("window.palpateTone.hz") > 220.0)
                shown.append("cues")
            else:
                shown.append("none")
                assert not page.locator("#palpate-cue-bar").is_visible()
            wait(lambda: page.get_by_text("The force was clear to me.").count() > 0)
            page.mouse.up()
            page.get_by_role("button", name="Done").click()
            page.wait_for_selector("text=Please answer: The force was clear to me.")
            page.get_by_role("slider").last.focus()
            page.keyboard.press("ArrowRight")
            time.sleep(0.3)
            page.get_by_role("button", name="Done").click()
        wait(lambda: page.get_by_text("Which part of the experiment").count() > 0)
        page.locator("input[aria-haspopup=listbox]").last.click()
        page.get_by_role("option", name="part 2").click()
        time.sleep(0.3)
        page.get_by_role("button", name="Done").click()
        run.join(60.0)
        assert not run.is_alive()
        assert page.errors == []
        assert page.strangers == []
    assert sorted(shown) == ["cues", "none"]
    done = study.progress("P01")
    assert [done.ended[k]["result"] for k in (1, 2)] == ["success", "success"]
    assert done.aborted == []
    assert done.answers["end"] == {"preference": "part 2"}
    assert {done.answers[f"block-{k}"]["clear"] for k in (1, 2)} == {5}
    assert all(Record.open(study.folder / done.ended[k]["record"]).complete for k in (1, 2))
