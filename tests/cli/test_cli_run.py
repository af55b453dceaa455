"""`palpate run`: its output files, its end, and its error messages."""

import ctypes
import hashlib
import json
import resource
import signal
import socket
import time

import json_contract
import numpy as np
import pytest
from effort import LONG

from palpate import __version__
from palpate.base.errors import PortError
from palpate.cli.terminal.view import free_port
from palpate.record import Record
from palpate.session.summary import summarise


def test_run_writes_record_report_and_json(palpate, scene, tmp_path):
    scene.write_text(scene.read_text().replace("report: false", "report: true"))
    done = palpate("run", scene, "--headless", "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    assert done.code == 0, done.err
    report = json.loads((tmp_path / "run.json").read_text())
    assert set(report) == json_contract.keys("run")
    assert report["faults"] == []
    assert 0.5 < report["peak_force_N"] < 3.0
    assert report["contact_s"] > 0.3
    assert f"record: {report['record']}" in done.out
    assert f"report: {report['report']}" in done.out
    assert "lockstep" in done.out
    with open(report["record"], "rb") as file:
        assert hashlib.sha256(file.read()).hexdigest() == report["record_sha256"]


def test_a_run_without_a_viewer_leaves_the_report_to_its_command(palpate, scene, tmp_path, monkeypatch):
    """Most of the start of a short run was its figures."""
    monkeypatch.setattr("palpate.report.write_report", None, raising=False)
    scene.write_text(scene.read_text().replace("record: {report: false}", ""))
    done = palpate("run", scene, "--headless", "--duration", "0.05", "--out", tmp_path, "--json", tmp_path / "run.json")
    run = json.loads((tmp_path / "run.json").read_text())
    assert (done.code, run["report"], run["faults"]) == (0, None, [])
    assert f"report: palpate report {run['record']}" in done.out


def test_summary_agrees_with_the_record(palpate, scene, tmp_path):
    palpate("run", scene, "--headless", "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    report = json.loads((tmp_path / "run.json").read_text())
    record = Record.open(report["record"])
    again = summarise(record.ticks, record.rate)
    for key in ("ticks", "peak_force_N", "mean_force_N", "max_penetration_m", "contact_s", "energy_J"):
        assert report[key] == pytest.approx(getattr(again, key), rel=1e-12), key  # other batches of the sum


def test_same_scene_and_seed_give_the_same_bytes(palpate, scene, tmp_path):
    sums = []
    for seed in (3, 3, 4):
        palpate("run", scene, "--headless", "--seed", seed, "--out", tmp_path / "o", "--json", tmp_path / "run.json")
        sums.append(json.loads((tmp_path / "run.json").read_text())["record_sha256"])
    assert sums[0] == sums[1] != sums[2]


def test_json_on_standard_output_comes_without_other_text(palpate, scene, tmp_path):
    done = palpate("run", scene, "--headless", "--duration", 0.2, "--out", tmp_path / "o", "--json", "-")
    assert json.loads(done.out)["ticks"] == 200
    assert "record:" in done.err


def test_last_duration_wins(palpate, scene, tmp_path):
    """`make demo ARGS="--duration 5"` gives the option twice."""
    args = ("--duration", 20, "--headless", "--duration", 0.1, "--json", tmp_path / "run.json")
    assert palpate("run", scene, *args).code == 0
    assert json.loads((tmp_path / "run.json").read_text())["duration_s"] == 0.1


def test_report_and_replay_find_the_record_in_its_folder(palpate, scene, tmp_path, monkeypatch):
    monkeypatch.setattr("palpate.report.html._page", lambda run: "page " * 300)
    palpate("run", scene, "--headless", "--duration", 0.5, "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    folder = next((tmp_path / "o").iterdir())
    done = palpate("report", folder, "--out", tmp_path / "page.html", "--json", tmp_path / "again.json")
    assert done.code == 0, done.err
    assert (tmp_path / "page.html").stat().st_size > 1000
    assert json.loads((tmp_path / "again.json").read_text())["ticks"] == 500


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["run", "nowhere.yaml"], "error: nowhere.yaml: scene file not found"),
        (["run", "soft.yaml", "--fast", "--realtime"], "--realtime and --fast contradict each other"),
        (["run", "soft.yaml", "--serve", "--headless"], "--serve and --headless contradict each other"),
        (["run", "soft.yaml", "--duration", "-1"], "--duration -1: must be above 0 s"),
        (["run", "soft.yaml", "--duration", "nan"], "--duration nan: must be above 0 s"),
        (["run", "soft.yaml", "--seed", "-1"], "--seed -1: must be a whole number from 0"),
        (["run", "soft.yaml", "--out", "soft.yaml/x"], "records cannot be written into this folder"),
        (["run", "soft.yaml", "--json", "no/such/dir/a.json"], "the file cannot be written"),
        (["report", "nowhere.mcap"], "nowhere.mcap"),
        (["replay", "soft.yaml"], "soft.yaml"),
        (["check", "nowhere.stl"], "mesh file not found"),
        (["schema", "--out", "no/such/dir/a.json"], "the file cannot be written"),
    ],
)
def test_mistakes_exit_with_2_and_a_message(palpate, scene, args, message):
    done = palpate(*args)
    assert done.code == 2
    assert message in done.err
    assert "Traceback" not in done.err


@pytest.mark.parametrize("args", [["rnu"], ["run"], ["run", "a.yaml", "--durations", "3"], ["bench", "everything"]])
def test_wrong_arguments_exit_with_2(palpate, args):
    done = palpate(*args)
    assert done.code == 2
    assert "Traceback" not in done.err


@pytest.mark.parametrize("command", ["run", "replay", "report", "check", "bench", "schema"])
def test_help_has_examples(palpate, command):
    done = palpate(command, "--help")
    assert done.code == 0
    assert f"palpate {command}" in done.out


def test_call_without_arguments_lists_the_commands(palpate):
    done = palpate()
    assert done.code == 0
    assert all(word in done.out for word in ("run", "replay", "report", "check", "bench", "schema"))


def test_version_is_printed_without_loading_the_core(spawn):
    done = spawn("--version")
    out, _ = done.communicate(timeout=60)
    assert (done.returncode, out) == (0, f"palpate {__version__}\n")


def test_busy_port_is_replaced_by_the_next_free_port():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        assert port < free_port(port) <= port + 20


def test_port_out_of_range_is_rejected():
    with pytest.raises(PortError, match="port 70000 does not exist"):
        free_port(70000)


@pytest.mark.parametrize(
    ("mode", "end"),
    [
        ("--realtime", signal.SIGINT),
        pytest.param("--fast", signal.SIGINT, marks=pytest.mark.long),  # in this process: tests/session
        ("--realtime", signal.SIGTERM),
        ("--fast", signal.SIGHUP),
    ],
)
def test_interrupt_keeps_the_record_and_prints_the_summary(spawn, scene, tmp_path, mode, end):
    args = ("--headless", mode, "--duration", 600, "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    process = spawn("run", scene, *args)
    assert "force" in process.stdout.readline()  # the run has begun
    time.sleep(0.2)
    process.send_signal(end)
    out, err = process.communicate(timeout=60)
    assert process.returncode == 130, err
    assert "stopped by Ctrl-C" in out
    assert "Traceback" not in err
    report = json.loads((tmp_path / "run.json").read_text())
    assert report["interrupted"] is True
    record = Record.open(report["record"])
    assert record.complete
    assert len(record.ticks) == report["ticks"] > 0


def test_real_time_run_without_priority_and_locked_memory_reports_it(spawn, scene, tmp_path):
    def refuse():
        resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (0, 0))
        for capability in (14, 23):  # CAP_IPC_LOCK, CAP_SYS_NICE; only root has these capabilities
            ctypes.CDLL(None).prctl(24, capability, 0, 0, 0)  # PR_CAPBSET_DROP: takes effect at the following exec

    args = ("--headless", "--realtime", "--duration", 1, "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    process = spawn("run", scene, *args, preexec_fn=refuse)
    out, err = process.communicate(timeout=100)
    assert process.returncode == 0, err
    report = json.loads((tmp_path / "run.json").read_text())
    assert report["realtime"]
    assert report["ticks"] >= 900
    assert "SCHED_FIFO refused" in report["scheduler"]
    assert "memory not locked" in report["scheduler"]
    assert f"scheduling: {report['scheduler']}" in out


def test_interrupt_while_loading_is_silent(spawn, scene):
    process = spawn("run", scene, "--headless")
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=60)
    assert process.returncode in (130, -signal.SIGINT)  # the second value if the interpreter was still starting


def test_a_viewer_that_opens_ends_with_any_signal(spawn, scene, tmp_path):
    """200 signals of both kinds in the long version, at random moments of the first two seconds."""
    rng = np.random.default_rng(4)
    for k in range(200 if LONG else 4):
        end = (signal.SIGINT, signal.SIGTERM)[k % 2]
        process = spawn("run", scene, "--serve", "--port", 18900, "--duration", 600, "--out", tmp_path / str(k))
        time.sleep(float(rng.uniform(0.2, 2.2)))
        process.send_signal(end)
        _, err = process.communicate(timeout=30)  # fails if the signal was lost
        assert process.returncode != 0, err


def test_full_disk_ends_the_record_but_not_the_run(spawn, scene, tmp_path):
    def small_files():
        resource.setrlimit(resource.RLIMIT_FSIZE, (700_000, 700_000))

    args = ("--headless", "--duration", 2, "--out", tmp_path / "o", "--json", tmp_path / "run.json")
    process = spawn("run", scene, *args, preexec_fn=small_files)
    out, err = process.communicate(timeout=100)
    assert process.returncode == 1, err
    report = json.loads((tmp_path / "run.json").read_text())
    assert report["ticks"] == 2000
    assert report["record_sha256"] is None
    assert any("recording stopped after" in fault for fault in report["faults"])
    assert "recording stopped after" in out
    assert 0 < len(Record.open(report["record"]).ticks) < 2000


def test_closed_output_pipe_gives_no_traceback(spawn, scene):
    process = spawn("run", scene, "--headless", "--duration", 0.2)
    process.stdout.close()
    process.stdout = None
    _, err = process.communicate(timeout=60)
    assert "Traceback" not in err


def test_run_warns_of_a_coarse_mesh_as_check_does(palpate, scene, tmp_path):
    done = palpate("run", scene, "--headless", "--duration", 0.1, "--out", tmp_path / "o")
    assert done.code == 0, done.err
    assert "object 'organ': coarse mesh" in done.err
    assert "triangles of the same object would do" in done.err
    scene.write_text(scene.read_text().replace("triangles: 3000", "triangles: 20000"))
    assert "coarse mesh" not in palpate("run", scene, "--headless", "--duration", 0.1, "--out", tmp_path / "o").err
