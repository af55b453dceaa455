"""Every `palpate ros haptics` and `palpate ros sim` command that README, docs or --help print starts as printed, beside
the simulated robot as its printed command starts it."""

import re
import shlex
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from palpate_lab.verify.bench.ros_stand import OutputLines

ROOT = Path(__file__).resolve().parents[2]
PAGES = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "palpate/cli/commands/ros").glob("*.py")),
]
LINE = re.compile(r"^\s*(palpate ros (?:haptics|sim)(?: [^#\n`]*)?)(?:#.*)?$", re.MULTILINE)
DEVICES = {
    "right": "{leader: MTMR, follower: PSM1, teleop: MTMR_PSM1}",
    "left": "{leader: MTML, follower: PSM2, teleop: MTML_PSM2}",
}
"""As docs/pairs.md names the arms."""
GIVEN = {"wall.yaml": "wall", "my_two_hands.yaml": "two_hands"}  # files that the reader makes, from these scenes


def printed(what):
    """Commands of one kind, each once."""
    found = {" ".join(one.split()) for page in PAGES for one in LINE.findall(page.read_text(encoding="utf-8"))}
    return sorted(one for one in found if one.startswith(f"palpate ros {what}") and "SCENE" not in one)


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    for name, scene in GIVEN.items():
        text = (ROOT / "scenes" / f"{scene}.yaml").read_text()
        for pair, arms in DEVICES.items() if scene == "two_hands" else ():
            text = re.sub(rf"^  {pair}:.*$", f"  {pair}:\n    devices: {arms}", text, flags=re.MULTILINE)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.fixture(scope="module")
def robot(start_once):
    """The robot with all its arms, as `palpate ros sim` starts it."""
    process = start_once("-m", "palpate", "ros", "sim")
    for line in process.stdout:
        if "Ctrl-C" in line:
            return process
    pytest.fail(process.stderr.read())


def test_commands_are_found():
    assert any(
        "scenes/palpation.yaml --leader MTMR --follower PSM1 --teleop MTMR_PSM1" in one for one in printed("haptics")
    )
    assert len(printed("sim")) >= 2


@pytest.mark.parametrize("command", printed("haptics"))
def test_printed_command_starts(robot, folder, command):
    words = shlex.split(command)[1:]
    process = subprocess.Popen(
        [sys.executable, "-m", "palpate", *words], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    output = OutputLines(process)
    try:
        output.await_line("wrenches to", 60.0)
    finally:
        process.send_signal(signal.SIGTERM)
        code = process.wait(60)
    assert code in (0, 130), output.lines  # 130: ended by Ctrl-C, as shells count it
    refused = [line for line in output.lines if "too rarely" in line or "the cycle needs" in line]
    assert not refused, refused


def test_second_robot_of_the_same_names_is_refused_unless_forced(robot):
    command = [sys.executable, "-m", "palpate", "ros", "sim", "--arms", "PSM1"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 2
    assert re.search(r"error: (/PSM1/\w+,? )+.*exists? already, of /dvrk\n", done.stderr)  # those discovered first
    assert "--force" in done.stderr
    forced = subprocess.Popen([*command, "--force"], stdout=subprocess.PIPE, text=True)
    try:
        assert any("Ctrl-C" in line for line in forced.stdout)
    finally:
        forced.send_signal(signal.SIGINT)
        forced.wait(30)
