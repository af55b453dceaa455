"""Processes of a measurement are gone afterwards, also one that ignores the request to end."""

import signal
import subprocess

import pytest

from palpate_lab.verify.processes import end


@pytest.mark.parametrize(("trap", "killed_by"), [("", signal.SIGTERM), ("trap '' TERM; ", signal.SIGKILL)])
def test_a_process_ends_when_asked_or_is_killed(trap, killed_by):
    process = subprocess.Popen(["sh", "-c", f"{trap}echo ready; exec sleep 60"], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "ready\n"
    end(process, 0.2)
    assert process.returncode == -killed_by
    end(process)  # one that has ended stays so
    process.stdout.close()
