"""The plan: balanced, reproducible, and fixed before the first trial."""

from collections import Counter
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from palpate.base.errors import PalpateError
from palpate.experiment import ExperimentFile, plan_of
from palpate.experiment.order import orders, williams
from palpate.experiment.scenes import Settings


@given(n=st.integers(2, 12))
def test_each_condition_follows_each_other_one_equally_often(n):
    square = williams(n)
    assert len(square) == (n if n % 2 == 0 else 2 * n)
    assert all(sorted(row) == list(range(n)) for row in square)
    for column in zip(*square, strict=True):
        assert set(Counter(column).values()) == {len(square) // n}
    follows = Counter(pair for row in square for pair in pairwise(row))
    assert len(follows) == n * (n - 1)
    assert set(follows.values()) == {len(square) // n}


@given(seed=st.integers(0, 99), latin=st.booleans(), few=st.integers(1, 6))
def test_orders_do_not_depend_on_later_participants(seed, latin, few):
    names = ("a", "b", "c", "d")
    assert orders(names, 9, latin, seed)[:few] == orders(names, few, latin, seed)


def test_every_participant_does_every_trial_once_in_blocks(small):
    plan = plan_of(small, ("P01", "P02", "P03"))
    for trials in plan.values():
        assert [one.number for one in trials] == list(range(1, len(trials) + 1))
        assert Counter(one.condition for one in trials) == {"none": 1, "force": 1}
        assert [one.last for one in trials] == [True, True]
    assert len({one.seed for trials in plan.values() for one in trials}) == 6
    assert plan == plan_of(small, ("P01", "P02", "P03"))


def test_familiarisation_comes_first_and_breaks_come_between(folder):
    text = (folder / "small.yaml").read_text()
    text = text.replace("familiarisation: 0", "familiarisation: 2\nbreaks: {every: 2, seconds: 5}")
    (folder / "more.yaml").write_text(text.replace("repetitions: 1", "repetitions: 3"))
    trials = plan_of(ExperimentFile.load(folder / "more.yaml"), ("P01",))["P01"]
    assert [one.repetition == 0 for one in trials] == [True] * 2 + [False] * 6
    assert trials[0].condition == trials[2].condition, "people get used to the condition that they begin with"
    assert [one.number for one in trials if one.rest] == [3, 5, 7]
    assert [one.number for one in trials if one.last] == [5, 8]


BAD = [
    ("participants: 4", "participants: [P01, P02, P01]", "participant P01 is listed twice"),
    ("participants: 4", "participants: [Ann, ann, B]", "participants Ann and ann differ by capitals alone"),
    ("felt: false", "felt: false, delay: 0.1", "delay has no effect with felt: false"),
    ("force: {}", "force: {feel: true}", "feel"),
    ("tlx: true", "tlx: 3", "tlx"),
    ("[force_error_N, time_s]", "[force_eror_N]", "force_eror_N"),
    ("force: 0.6", "force: -1", "force"),
    ("path: [[0.0, 0.0, 0.0]]", "path: []", "path"),
    ("participants: 4", "participants: 0", "participants must be at least 1"),
    ("participants: 4", "participants: [P01, ../P02]", "'../P02' is no name: at most 40 letters"),
    ("  force: {}", "  a/b: {}", "'a/b' is no name"),
    ("repetitions: 1", "repetitions: 0", "repetitions must be at least 1"),
    ("felt.}", "felt.}, {name: trust, words: Again?}", "item trust is asked twice"),
    ("name: trust", "name: participant", "an item cannot be named participant"),
    ("dwell: 0.1", "dwell: 2.0", "nobody can dwell 2 s within 2 s"),
    ("dwell: 0.1", "fail_above: 0.6", "a force of 0.6 N fails above 0.6 N"),
]


@pytest.mark.parametrize(("was", "wrong", "words"), BAD)
def test_a_mistake_is_named_with_its_line(folder, was, wrong, words):
    (folder / "bad.yaml").write_text((folder / "small.yaml").read_text().replace(was, wrong, 1))
    with pytest.raises(PalpateError, match=r"bad\.yaml:") as refused:
        ExperimentFile.load(folder / "bad.yaml")
    assert words in str(refused.value)


def test_a_condition_without_its_scene_is_named(folder):
    text = (folder / "small.yaml").read_text().replace("force: {}", "force: {scene: gone.yaml}")
    (folder / "bad.yaml").write_text(text)
    with pytest.raises(PalpateError, match="condition 'force', task 'press': scene file not found") as refused:
        Settings(ExperimentFile.load(folder / "bad.yaml")).all()
    assert "bad.yaml:6" in str(refused.value)


def test_an_object_or_value_that_the_scene_lacks_is_named(folder):
    text = (folder / "small.yaml").read_text()
    (folder / "bad.yaml").write_text(text.replace("force: 0.6", "object: liver, force: 0.6"))
    with pytest.raises(PalpateError, match="no object 'liver'"):
        Settings(ExperimentFile.load(folder / "bad.yaml")).all()
    (folder / "bad.yaml").write_text(text.replace("force: {}", "force: {changes: {mapping.scal: 1.0}}"))
    with pytest.raises(PalpateError, match=r"condition 'force', task 'press'.*scal"):
        Settings(ExperimentFile.load(folder / "bad.yaml")).all()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("{scene: two_hands}", "a scene with several pairs cannot be used in an experiment yet"),
        ("{changes: {record.signals: [p_WT]}}", "the record would lack F_T_W, F_touch_W, by which trials are judged"),
        ("{changes: {arms.leader.start: [5, 5, 5]}}", "leader"),
    ],
)
def test_a_scene_that_cannot_be_used_is_refused_before_the_first_trial(folder, change, words):
    (folder / "bad.yaml").write_text((folder / "small.yaml").read_text().replace("force: {}", f"force: {change}"))
    with pytest.raises(PalpateError, match=r"condition 'force', task 'press'") as refused:
        Settings(ExperimentFile.load(folder / "bad.yaml")).all()
    assert words in str(refused.value)


def test_the_path_of_the_hand_in_the_scene_does_not_count(folder):
    """With this scale the scene's own path would lead the leader out of its reach; a trial has its own path."""
    text = (folder / "small.yaml").read_text().replace("force: {}", "force: {changes: {mapping.scale: 0.1}}")
    (folder / "scaled.yaml").write_text(text)
    assert len(Settings(ExperimentFile.load(folder / "scaled.yaml")).all()) == 2


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(PalpateError, match="experiment file not found"):
        ExperimentFile.load(tmp_path / "none.yaml")


@pytest.mark.parametrize(("content", "words"), [("", "the experiment is empty"), ("- a", "an experiment is a mapping")])
def test_a_file_without_sections_is_told_how_an_experiment_begins(tmp_path, content, words):
    (tmp_path / "one.yaml").write_text(content)
    with pytest.raises(PalpateError, match=words) as error:
        ExperimentFile.load(tmp_path / "one.yaml")
    assert "title: Does a felt force help?" in str(error.value)


def test_a_way_point_far_from_its_surface_is_no_place_on_it(folder):
    """One in millimetres would be moved in silence to the nearest edge of the organ."""
    text = (folder / "small.yaml").read_text().replace("path: [[0.0, 0.0, 0.0]]", "path: [[0.0, 0.0, 100.0]]")
    (folder / "far.yaml").write_text(text)
    with pytest.raises(PalpateError, match=r"way point 1 is 1000.. mm from the surface"):
        Settings(ExperimentFile.load(folder / "far.yaml")).all()
