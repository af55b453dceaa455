"""A person's trials: a real browser from the first page to the last answer, a closed browser, a lost device."""

import pytest

from palpate.errors import DeviceError
from palpate.experiment import ExperimentFile, Study
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
