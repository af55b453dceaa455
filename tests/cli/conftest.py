import json
import subprocess
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import pytest

from palpate.cli import main

SCENE = """\
objects:
  - shape: organ
    triangles: 3000
    stiffness: 400
operator:
  palpate: {approach: 0.4, press: 0.3, slide: 0.6, leave: 0.2}
duration: 1.0
record: {report: false}
"""


@pytest.fixture
def scene(tmp_path) -> Path:
    path = tmp_path / "soft.yaml"
    path.write_text(SCENE)
    return path


@dataclass
class Outcome:
    code: int
    out: str
    err: str


@pytest.fixture
def palpate(capsys, monkeypatch, tmp_path, unarranged_figures, without_figures):
    """Run a command in this process; its changes to warnings are undone."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)

    def run(*args) -> Outcome:
        try:
            code = main([str(a) for a in args])
        except SystemExit as end:
            code = int(end.code or 0)
        out, err = capsys.readouterr()
        return Outcome(code, out, err)

    with warnings.catch_warnings():
        yield run


@pytest.fixture
def spawn(tmp_path):
    """Run a command in its own process."""
    running = []

    def start(*args, **more) -> subprocess.Popen:
        command = [sys.executable, "-m", "palpate", *map(str, args)]
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "stdin": subprocess.DEVNULL, "text": True}
        process = subprocess.Popen(command, cwd=tmp_path, **(pipes | more))
        running.append(process)
        return process

    yield start
    for process in running:
        if process.poll() is None:
            process.kill()
            process.wait()


def read_json(path: Path):
    return json.loads(path.read_text())
