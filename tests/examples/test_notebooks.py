"""The notebooks run, are stored without outputs, and stay small. `make test-long` runs all of them by their kernel."""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

ROOT = Path(__file__).resolve().parents[2]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
QUICK = ("2_paper_normals", "3_certificate")
"""Those whose cells `make test` runs in its own process."""


def cells(path, kind):
    return [one for one in json.loads(path.read_text(encoding="utf-8"))["cells"] if one["cell_type"] == kind]


def executed(path, folder):
    """Run a notebook by the kernel, in a folder; returns it with its outputs."""
    nbformat = pytest.importorskip("nbformat", reason="nbclient and ipykernel (group test) are not installed")
    from nbclient import NotebookClient

    notebook = nbformat.read(path, as_version=4)
    where = {"metadata": {"path": str(folder)}}
    return NotebookClient(notebook, timeout=120, kernel_name="python3", resources=where).execute()


def test_notebooks_are_found():
    assert [path.stem[0] for path in NOTEBOOKS] == ["1", "2", "3", "4"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_short_and_has_no_outputs(path):
    assert path.stat().st_size < 8_000
    code = cells(path, "code")
    assert all(cell["outputs"] == [] and cell["execution_count"] is None for cell in code)
    first = cells(path, "markdown")[0]["source"][0]
    assert first.startswith("# ")
    assert first.strip().endswith("?")
    assert len(code) <= 5


@pytest.mark.parametrize("name", QUICK)
def test_cells_run(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    plt.close("all")  # of other tests in this process
    names: dict = {}
    for cell in cells(ROOT / "examples" / "notebooks" / f"{name}.ipynb", "code"):
        exec("".join(cell["source"]), names)


@pytest.mark.long
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_in_its_kernel(path, tmp_path):
    done = executed(path, tmp_path)
    outputs = [out for cell in done.cells if cell.cell_type == "code" for out in cell.outputs]
    assert not [out for out in outputs if out.output_type == "error"]
    assert any("image/png" in out.get("data", {}) for out in outputs), "a picture"
    if path.stem.startswith("1"):
        assert any("<iframe" in out.get("data", {}).get("text/html", "") for out in outputs), "the viewer"


@pytest.mark.long
def test_a_cell_that_fails_is_told(tmp_path):
    broken = json.loads(NOTEBOOKS[1].read_text(encoding="utf-8"))
    broken["cells"] = [{**cells(NOTEBOOKS[1], "code")[0], "source": ["import palpate\n", "palpate.nothing"]}]
    (tmp_path / "broken.ipynb").write_text(json.dumps(broken))
    with pytest.raises(Exception, match="no attribute 'nothing'"):
        executed(tmp_path / "broken.ipynb", tmp_path)
