"""No trial is lost or doubled, whenever the process ends; attempts are never overwritten."""

import multiprocessing
import os
import random
import signal
from pathlib import Path

import pytest
from small_experiment import FILE, SCENE

from palpate.base.errors import JournalError, OutputError, PalpateError, SweepError
from palpate.base.sweep.lines import Lines
from palpate.experiment import ExperimentFile, Outcome, SimulatedParticipant, Study, run_participant, simulate
from palpate.experiment.journal import FILE as JOURNAL
from palpate.experiment.journal import Journal, progress_of
from palpate.experiment.simulated import Performed
from palpate.record import Record

PEOPLE = ("S01",)


class Killed(BaseException):
    """The process ends here: nothing that follows is written."""


def longer(folder):
    text = (folder / "small.yaml").read_text()
    (folder / "small.yaml").write_text(text.replace("repetitions: 1", "repetitions: 2"))
    return ExperimentFile.load(folder / "small.yaml")


def opened(experiment, folder):
    return Study(experiment, folder, PEOPLE, simulated=True)


def run(experiment, folder):
    study = opened(experiment, folder)
    run_participant(study, "S01", SimulatedParticipant(0, 1, study.settings))
    return study


def require_whole(study):
    """Every planned trial ended once, its record is whole, and every attempt has its folder."""
    done = study.progress("S01")
    assert sorted(done.ended) == list(range(1, len(study.plan["S01"]) + 1))
    records = [event["record"] for event in done.ended.values()]
    assert len(set(records)) == len(records)
    assert all(Record.open(study.folder / record).complete for record in records)
    folders = sorted(path.name for path in (study.folder / "S01").glob("trial-*"))
    assert len(folders) >= sum(done.attempts.values())
    assert set(done.answers) == {"block-1", "block-2", "end"}


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "table.yaml").write_text(SCENE)
    (folder / "small.yaml").write_text(FILE)
    study = run(longer(folder), folder / "data")
    return {number: event["measures"] for number, event in study.progress("S01").ended.items()}


def kill_at(monkeypatch, point):
    """Let the process end at a number of its calls that change the disk: half of them after half of the bytes."""
    count, written = [0], os.write

    def write(file, data):
        count[0] += 1
        if count[0] == point:
            if len(data) > 1 and point % 2:
                written(file, data[: len(data) // 2])
            raise Killed
        if count[0] > point:
            raise Killed  # a dead process writes nothing
        return written(file, data)

    made = Path.mkdir

    def mkdir(path, *args, **more):
        count[0] += 1
        if count[0] >= point:
            raise Killed
        return made(path, *args, **more)

    monkeypatch.setattr("palpate.base.sweep.lines.os.write", write)
    monkeypatch.setattr(Path, "mkdir", mkdir)


def test_killed_again_and_again_it_ends_with_every_trial_once(folder, monkeypatch, undisturbed):
    """Points of all kinds: before and within a line, before and after a folder was made."""
    experiment, rng, kills = longer(folder), random.Random(1), 0
    while kills < 200:
        with monkeypatch.context() as patched:
            kill_at(patched, rng.randint(1, 9))
            try:
                study = run(experiment, folder / "data")
                break
            except Killed:
                kills += 1
    assert kills >= 4
    require_whole(study)
    assert {n: e["measures"] for n, e in study.progress("S01").ended.items()} == undisturbed


def _child(file, folder):
    run(ExperimentFile.load(file), Path(folder))


def killed_for_good(folder, kills, seed=2):
    """Kill a process -9 after random times until it has been killed so often; then let it end. Returns the study."""
    experiment, rng = longer(folder), random.Random(seed)
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload(["palpate.experiment", "palpate.metrics", "palpate.viewer", "scipy.signal"])
    done = round_ = 0
    study = None
    while done < kills:
        round_ += 1
        target = folder / f"data-{round_}"
        for _ in range(1000):
            child = context.Process(target=_child, args=(experiment.file, str(target)))
            child.start()
            child.join(rng.uniform(0.0, 1.0) ** 2 * 2.5)
            if child.exitcode is not None:
                assert child.exitcode == 0
                break
            os.kill(child.pid, signal.SIGKILL)
            child.join()
            done += 1
            if done >= kills:
                break
        study = run(experiment, target)
        require_whole(study)
    return study


@pytest.mark.long
def test_killed_by_the_system_at_200_random_points(folder):
    killed_for_good(folder, 200)


def test_attempts_get_new_folders_also_after_a_kill_between_folder_and_journal(tmp_path):
    with Journal(tmp_path, 2) as journal:
        (tmp_path / "trial-001-attempt-1").mkdir()
        assert journal.begin(1) == (2, tmp_path / "trial-001-attempt-2")
        assert journal.begin(1) == (3, tmp_path / "trial-001-attempt-3")
    with Journal(tmp_path, 2) as journal:
        assert journal.begin(1)[0] == 4
        assert journal.next() == 1


def test_two_processes_cannot_run_one_participant(tmp_path):
    with Journal(tmp_path, 2), pytest.raises(SweepError, match="another process is writing"):
        Journal(tmp_path, 2)


def test_a_file_that_is_no_journal_and_a_broken_line_are_refused(tmp_path):
    (tmp_path / JOURNAL).write_text("hello\nworld\n")
    with pytest.raises(JournalError, match="no journal"):
        Journal(tmp_path, 2)
    (tmp_path / JOURNAL).unlink()
    with Journal(tmp_path, 2) as journal:
        journal.begin(1)
    whole = (tmp_path / JOURNAL).read_bytes()
    (tmp_path / JOURNAL).write_bytes(whole.replace(b"begin", b"began"))
    with pytest.raises(JournalError, match="line 2"):
        Journal(tmp_path, 2)


@pytest.mark.parametrize(
    ("events", "words"),
    [
        ([{"event": "opened", "version": 9}], "another version of palpate wrote the journal"),
        ([{"event": "opened", "version": 1}, {"event": "begin", "trial": 1}], "line 2 of the journal is broken"),
        ([{"event": "opened", "version": 1}, {"trial": 1}], "line 2 of the journal is broken"),
        ([{"event": "opened", "version": 1}, 3], "line 2 of the journal is broken"),
    ],
)
def test_lines_of_others_are_refused_when_read_and_when_written(tmp_path, events, words):
    lines = Lines(tmp_path / JOURNAL)
    lines.append(events)
    lines.close()
    with pytest.raises(JournalError, match=words):
        progress_of(tmp_path / JOURNAL)
    with pytest.raises(JournalError, match=words):
        Journal(tmp_path, 2)


def test_a_journal_that_cannot_be_read_is_named(tmp_path):
    (tmp_path / JOURNAL).mkdir()
    with pytest.raises(JournalError, match="the journal cannot be read"):
        progress_of(tmp_path / JOURNAL)


class Clumsy:
    """A participant whose first attempts end as they are told."""

    def __init__(self, real, endings):
        self.real, self.endings = real, list(endings)

    def perform(self, trial, folder):
        if self.endings:
            reason = self.endings.pop(0)
            return Performed(Outcome("aborted", reason, 0.1), None)
        return self.real.perform(trial, folder)

    def answer(self, *asked):
        return self.real.answer(*asked)

    def rest(self, seconds):
        pass


def test_an_aborted_attempt_is_kept_with_its_reason_and_repeated(small, tmp_path):
    study, said = opened(small, tmp_path / "data"), []
    real = SimulatedParticipant(0, 1, study.settings)
    run_participant(study, "S01", Clumsy(real, ["the device was lost"]), said.append)
    done = study.progress("S01")
    assert [(one["trial"], one["reason"]) for one in done.aborted] == [(1, "the device was lost")]
    assert done.ended[1]["attempt"] == 2
    assert any("attempt 1 was aborted: the device was lost; it is repeated" in line for line in said)


def test_a_trial_that_fails_again_and_again_ends_the_sitting_and_nothing_is_lost(small, tmp_path):
    study = opened(small, tmp_path / "data")
    real = SimulatedParticipant(0, 1, study.settings)
    with pytest.raises(PalpateError, match="trial 1 of S01 was aborted 3 times: no reply") as refused:
        run_participant(study, "S01", Clumsy(real, ["no reply"] * 3))
    assert "continues with this trial" in str(refused.value)
    run_participant(study, "S01", real)
    assert len(study.progress("S01").ended) == 2


def test_no_space_is_told_before_a_trial_and_in_one_and_nothing_is_lost(small, tmp_path, monkeypatch):
    study = opened(small, tmp_path / "data")
    real = SimulatedParticipant(0, 1, study.settings)
    with monkeypatch.context() as patched:
        usage = type("Usage", (), {"free": 1000})
        patched.setattr("palpate.experiment.study.shutil.disk_usage", lambda _: usage)
        with pytest.raises(OutputError, match=r"no space for trial 1: 0 MB are free, 3 MB are needed") as refused:
            run_participant(study, "S01", real)
        assert "continues with this trial" in str(refused.value)

    def full(file, data):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("palpate.base.sweep.lines.os.write", full)
        with pytest.raises(OutputError, match="No space left"):
            run_participant(study, "S01", real)
    run_participant(study, "S01", real)
    assert len(study.progress("S01").ended) == 2


def stl():
    corners = ("0 0 0", "0.1 0 0", "0 0.1 0", "0 0 0.1")
    facets = [[corners[k] for k in face] for face in ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))]
    loops = ["".join(f"vertex {corner}\n" for corner in facet) for facet in facets]
    body = "".join(f"facet normal 0 0 0\nouter loop\n{loop}endloop\nendfacet\n" for loop in loops)
    return f"solid ball\n{body}endsolid ball\n"


@pytest.mark.parametrize("change", ["scene", "experiment", "mesh"])
def test_a_file_changed_after_the_first_trial_is_named(folder, change):
    text = (folder / "table.yaml").read_text()
    ball = stl()
    (folder / "ball.stl").write_text(ball)
    if change == "mesh":
        text = text.replace("plane: {size: 0.2}", "mesh: ball.stl, unit: m")
        (folder / "table.yaml").write_text(text)
    small = ExperimentFile.load(folder / "small.yaml")
    opened(small, folder / "data")
    opened(small, folder / "data")
    if change == "scene":
        (folder / "table.yaml").write_text(text.replace("400", "500"))
    elif change == "mesh":
        (folder / "ball.stl").write_text(ball.replace("0.1 0 0", "0.11 0 0"))
    else:
        (folder / "small.yaml").write_text((folder / "small.yaml").read_text().replace("force: 0.6", "force: 0.7"))
    words = {"experiment": "tasks.press.force was 0.6 and is 0.7"}.get(change, "the scene of press/none was changed")
    with pytest.raises(JournalError, match=words) as refused:
        opened(ExperimentFile.load(folder / "small.yaml"), folder / "data")
    assert "nothing was lost" in str(refused.value)


def test_a_comment_may_change_and_another_number_of_simulated_people_may_not(folder, small):
    simulate(small, 1, folder / "data", workers=1)
    (folder / "small.yaml").write_text("# why\n" + (folder / "small.yaml").read_text())
    again = ExperimentFile.load(folder / "small.yaml")
    simulate(again, 1, folder / "data", workers=1)
    with pytest.raises(JournalError, match="another experiment: the plan differ"):
        simulate(again, 2, folder / "data", workers=1)
