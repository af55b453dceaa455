"""Reports about the force: few sentences from a source that flickers, and none too late from one that fails."""

import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest

from palpate.record import withheld
from palpate.record.ticks import STATUS, TICK
from palpate.ros import causes, reports
from palpate.ros.jitter import LARGEST, Jitter, jitter, offset_words, tolerance
from palpate.ros.plant import CrtkPlant
from palpate.ros.reports import ForceReports
from palpate_lab.verify.bench import ros_stand as bench

RATE = 250.0
FREE = "free to push"
SILENT = STATUS["leader_stale"][1]


class Run:
    """Feeds ticks in the chunks of a session, and keeps (time [s], sentence)."""

    def __init__(self):
        self.reports, self.told, self.t = ForceReports(), [], 0.0
        self.asked, self.who, self.shift = 0.0, None, 0.0

    def force(self, seconds, who=None, newtons=1.09, shift=0.0):
        """Ticks in which the law asks for a force [N], and the element with number `who` withholds it."""
        self.asked, self.who, self.shift = newtons, who, shift
        self.add(seconds)
        self.asked, self.who, self.shift = 0.0, None, 0.0

    def add(self, seconds, *names, cause=None):
        """Ticks with these bits for a duration [s]; cause: name of a bit with its value."""
        left = round(seconds * RATE)
        while left > 0:
            n = min(left, 25)
            ticks = np.zeros(n, TICK)
            ticks["t"] = self.t + np.arange(1, n + 1) / RATE
            ticks["status"] = sum(STATUS[name][0] for name in names)
            ticks["F_asked"][:, :2] = self.asked
            ticks["p_shift_W"][:, 1] = self.shift
            if self.who is not None:
                ticks["F_withheld"][:, self.who] = self.asked
            if cause:
                ticks["cause"][:, :2] = STATUS[cause[0]][0].bit_length() - 1, cause[1]
            self.reports.take(ticks)
            self.t, left = float(ticks["t"][-1]), left - n
            self.told += [(self.t, words) for words in self.reports.sentences()]

    def flicker(self, times):
        for _ in range(times):
            self.add(0.04, "leader_stale")
            self.add(0.1, "settling")
            self.add(5.86)


def test_source_that_flickers_is_told_a_few_times_and_then_once_a_minute_with_its_count():
    run = Run()
    run.flicker(31)
    assert [words for _, words in run.told] == [
        *[SILENT, FREE] * reports.SEVERAL, f"{SILENT} (7 times in the last 60 s)", FREE,
        f"{SILENT} (10 times in the last 60 s)", FREE, f"{SILENT} (10 times in the last 60 s)", FREE,
    ]  # fmt: skip
    assert run.told[0][0] <= 0.1, "the first one is told at once"


def test_lasting_fault_is_told_among_flickers():
    run = Run()
    run.flicker(reports.SEVERAL + 1)
    begin = run.t
    run.add(2.0, "leader_stale")
    (told,) = [t for t, words in run.told if t > begin and words.startswith(SILENT)]
    assert told - begin <= reports.LASTING + 0.2
    assert not any(words == FREE for t, words in run.told if t > begin)
    run.add(2.0)
    assert run.told[-1][1] == FREE


@pytest.mark.parametrize("period", [0.2, 0.35, 0.9])
def test_fault_that_stays_after_flickers_within_one_episode_is_told(period):
    """The flickers follow each other sooner than an episode ends, so the last one is no new episode."""
    run = Run()
    for _ in range(8):
        run.add(0.1, "leader_stale", cause=("leader_stale", 0.04))
        run.add(period)
    begin = run.t
    run.add(5.0, "leader_stale")
    told = [t - begin for t, words in run.told if t > begin and words == SILENT]
    assert told == [pytest.approx(reports.LASTING, abs=0.2)], "once"


def test_fault_that_stays_is_told_once():
    run = Run()
    run.add(5.0, "leader_stale")
    assert [words for _, words in run.told] == [SILENT]


@pytest.mark.parametrize("fault", ["leader_stale", "guarded", "not_finite", "clutched", "second_writer"])
def test_closed_gate_is_told_with_its_reason(fault):
    asked, F = np.array([1.0, 1.0, 0.0]), np.array([0, 0, 0, 0, 0, 0, 1.0])
    words = withheld.sentence(asked, F, STATUS[fault][0])
    assert f"a closed gate ({STATUS[fault][1].partition(':')[0]}) withholds 1.00 N" in words


def test_another_cause_is_told_at_once_among_flickers():
    run = Run()
    run.flicker(2)
    begin = run.t
    run.add(0.01, "clock_jumped")
    assert run.told[-1] == (pytest.approx(begin + 0.01, abs=0.1), STATUS["clock_jumped"][1])


def test_pedals_are_told_at_each_change_and_caps_never():
    run = Run()
    for _ in range(3):
        run.add(1.5, "clutched")
        run.add(1.5, "force_capped", "passivity")
    assert [words for _, words in run.told] == [STATUS["clutched"][1], FREE] * 3


def rows(arrivals, age=1e-4):
    return np.column_stack([arrivals, np.full(len(arrivals), age)])


@pytest.mark.parametrize("period", [0.1, 0.2, 0.3])
@pytest.mark.parametrize("pause", [0.012, 0.02, 0.05])
def test_jitter_is_the_longest_gap_or_age_that_comes_back(pause, period):
    regular = np.arange(500) * 2e-3
    assert jitter(rows(regular), 0.998).gap == pytest.approx(2e-3)
    assert jitter(rows(regular), 0.998).rate == pytest.approx(500, rel=0.01)
    paused = regular + pause * np.floor(regular / period)
    assert jitter(rows(paused), paused[-1]).gap == pytest.approx(pause + 2e-3, abs=1e-6)
    late = rows(regular)
    late[(regular % period) < 0.03, 1] += pause
    assert jitter(late, 0.998).gap == pytest.approx(pause), "late by a queue"
    for age in (1.7e9, np.nan):
        assert jitter(rows(regular, age), 0.998).gap == pytest.approx(2e-3), "a stamp of zero is no jitter"


@pytest.mark.parametrize("at", [0.0, 0.098, 0.31, 0.5, 0.999])
@pytest.mark.parametrize("pause", [0.02, 0.05, 0.08])
def test_single_pause_is_no_jitter_and_widens_nothing(pause, at):
    """As of a program that starts: the states queue meanwhile, and arrive late together."""
    regular = np.arange(500) * 2e-3
    arrivals = np.where((regular >= at) & (regular < at + pause), at + pause, regular)
    found = jitter(np.column_stack([arrivals, 1e-4 + arrivals - regular]), 1.0 + pause * (at > 0.9))
    assert found.gap == pytest.approx(2e-3, abs=1e-3)
    assert at == 0.0 or found.longest >= pause - 2e-3, "which lets the measurement go on"
    assert found.offset == pytest.approx(-1e-4, abs=1e-4)
    assert tolerance(found, 0.03) == (0.03, "")


@pytest.mark.parametrize("offset", [-0.05, -0.012, 0.012, 0.02, 3600.0])
def test_offset_of_the_clock_is_no_jitter_and_widens_nothing(offset):
    regular = np.arange(500) * 2e-3
    found = jitter(rows(regular, 2e-4 - offset), 0.998)
    assert found.gap == pytest.approx(2e-3)
    assert found.offset == pytest.approx(offset, abs=3e-4)
    assert tolerance(found, 0.03) == (0.03, "")
    words = offset_words(found.offset, 0.03)
    assert ("ahead" if offset > 0 else "behind") in words
    assert ("no force" in words) == (abs(offset) > 0.03)
    assert causes.offset(offset) in words


@pytest.mark.parametrize("valid", [0, 1, 250])
def test_stamps_of_zero_of_an_arm_without_power_are_no_offset(valid):
    regular = rows(np.arange(500) * 2e-3)
    regular[: 500 - valid, 1] = np.nan
    found = jitter(regular, 0.998)
    assert offset_words(found.offset, 0.03) == ""
    assert tolerance(found, 0.03) == (0.03, "")


def test_stamps_of_zero_are_told_of_an_arm_with_power_alone():
    run = Run()
    run.add(2.0, "not_enabled", "bad_stamp")
    assert [words for _, words in run.told] == [STATUS["not_enabled"][1]]
    run.add(2.0)
    run.add(0.5, "bad_stamp")
    assert [words for _, words in run.told][-1] == STATUS["bad_stamp"][1]


def test_small_offset_is_not_told():
    assert offset_words(0.002, 0.03) == offset_words(-0.002, 0.03) == ""


WITHHELD = {"passivity": 2, "force_cap": 3, "gate": 6}


@pytest.mark.parametrize("who", WITHHELD)
def test_who_withholds_a_force_for_half_a_second_is_told_in_newtons(who):
    run = Run()
    run.force(0.4, WITHHELD[who], 0.4)
    assert not run.told, "short losses are ordinary"
    run.force(1.0)
    run.force(0.8, WITHHELD[who], 1.09)
    (told,) = [words for _, words in run.told]
    assert "0.00 of 1.09 N are felt (law 1.09, guidance 0.00 N)" in told
    assert f"{withheld.WORDS[who]} withholds 1.09 N" in told
    assert run.told[0][0] == pytest.approx(1.4 + reports.LASTING, abs=0.15)
    run.force(5.0, WITHHELD[who], 1.09)
    assert len(run.told) == 1
    run.force(2.0)
    assert run.told[-1][1] == FREE


def test_value_of_a_cause_is_told_in_each_episode():
    run = Run()
    for norm in (1.2, 0.0, 0.5):
        run.add(0.1, "not_rotation", cause=("not_rotation", norm))
        run.add(3.0)
    told = [words for _, words in run.told if words != FREE]
    assert [words.partition(":")[0] for words in told] == [
        "a quaternion had the norm 1.2 instead of 1", "a quaternion was zero",
        "a quaternion had the norm 0.5 instead of 1",
    ]  # fmt: skip


def test_shift_is_told_with_how_to_take_it_back():
    run = Run()
    run.force(1.0, shift=0.004)
    (told,) = [words for _, words in run.told if words != FREE]
    assert "shifted the tool by 4.0 mm" in told
    assert "clutch" in told
    run.force(1.0, shift=0.0)
    assert "no shift is left" in run.told[-1][1] or "no shift is left" in run.told[-2][1]


@pytest.mark.parametrize(
    ("gap", "chosen", "words"),
    [(0.004, 0.03, ""), (0.014, 0.03, ""), (0.02, 0.04, "instead of 30 ms"), (0.04, LARGEST, "not tolerated")],
)
def test_tolerance_is_twice_the_jitter_within_its_bounds(gap, chosen, words):
    value, told = tolerance(Jitter(500, 500.0, gap), 0.03)
    assert value == pytest.approx(chosen)
    assert words in told
    assert bool(told) == bool(words)


def test_tolerance_is_never_smaller_than_that_of_the_scene():
    assert tolerance(None, 0.03) == (0.03, "")
    assert tolerance(Jitter(500, 500.0, 0.01), 0.1)[0] == 0.1


class Pauses(threading.Thread):
    """Silences the leader for `pause` [s] every `period` [s], until it is left."""

    def __init__(self, stand, pause, period):
        super().__init__(daemon=True)
        self.stand, self.pause, self.period, self.ended, self.times = stand, pause, period, threading.Event(), 0

    def run(self):
        while not self.ended.wait(self.period):
            self.stand.inject(silent=True)
            time.sleep(self.pause)
            self.stand.inject()
            self.times += 1

    def __enter__(self):
        self.start()
        return self

    def __exit__(self, *error):
        self.ended.set()
        self.join()


@pytest.mark.parametrize(
    ("messages", "told"), [(0, []), (100, ["the leader's clock agrees with this machine's again"])]
)
def test_offset_is_not_taken_back_before_the_first_state(messages, told):
    """The node knows no offset yet, so it does not contradict what was measured before it started."""
    timing = {"leader_clock_s": 0.0, "leader_messages": messages}
    loop = SimpleNamespace(told_offset=-0.05, stale_after=0.03, timing=lambda: timing)
    plant = SimpleNamespace(loop=loop, events=[])
    CrtkPlant._look_at_clock(plant)
    assert plant.events == told


def test_jittery_leader_sets_the_tolerance_and_prints_few_lines(native, tmp_path):
    stand = bench.Stand(native, "JITTERY")
    with Pauses(stand, 0.025, 0.2):
        node = bench.Node(stand, tmp_path, "--bare")
        node.output.await_line("states pause for up to")
    try:
        stand.press(60.0)
        first = len(node.output.lines)
        with Pauses(stand, 0.15, 0.35) as pauses:
            time.sleep(5.0)
        assert pauses.times >= 5
        flickered = node.output.lines[first:]
        assert len(flickered) <= 4, flickered
        assert sum("the leader is silent" in line for line in flickered) <= 1, flickered
        assert not any("not yet for long enough" in line for line in flickered)
        first = len(node.output.lines)
        stand.inject(silent=True)
        node.output.await_line("the leader is silent", after=first)
        stand.inject()
        node.output.await_line(FREE, after=first)
        assert "silent" in " ".join(node.end()["faults"])
    finally:
        node.process.kill()
        node.process.wait()
