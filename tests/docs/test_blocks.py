"""Every block of Python and YAML on the pages is tried: Python runs, YAML is a valid scene or a valid arm.

Blocks of a page run one after the other with the same names. What a page takes for granted (an open session, a file of
the reader) is in MEANT; a block that cannot run says why in its fence: ```python not run: needs a cluster.
"""

import re
import shutil
import warnings
from pathlib import Path

import numpy as np
import pytest

import palpate
from palpate import Scene
from palpate.base.errors import PalpateError

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")])
BALL = "objects: [{name: ball, sphere: {radius: 0.03}}]\n"
#: Scripts that another test runs as a process, and why: they start workers or real-time threads.
ELSEWHERE = {"README.md": "tests/package/test_readme.py", "docs/studies.md": "tests/sweep/test_docs.py"}
_BLOCK = re.compile(r"^```(python|yaml)([^\n]*)\n(.*?)^```", re.M | re.S)


def blocks(kind):
    """Page, number and text of the blocks without a reason not to run."""
    return [
        (str(page.relative_to(ROOT)), k, text)
        for page in PAGES
        for k, (language, words, text) in enumerate(_BLOCK.findall(page.read_text(encoding="utf-8")))
        if language == kind and not words.strip()
    ]


def session_of(_folder):
    return {"palpate": palpate, "session": palpate.Session(Scene.parse(BALL))}


def cloud_of(folder):
    points, _ = palpate.shapes.organ()
    np.savetxt(folder / "scan.xyz", points)
    palpate.PointCloud.load(folder / "scan.xyz", unit="m").save(folder / "scan.pcd")
    return {"palpate": palpate, "tips": [[0.0, 0.0, 0.060 - 0.0004 * i] for i in range(100)]}


def record_of(folder):
    summary = palpate.Session(Scene.parse(BALL + "duration: 0.2\n"), out=str(folder / "out")).run(0.2)
    shutil.copy(summary.record, folder / "record.mcap")
    return {}


def points_of(_folder):
    moving = np.random.default_rng(0).normal(scale=0.05, size=(6, 3))
    return {"moving": moving, "fixed": moving + 0.1}


#: What a page takes for granted before its blocks; it returns names.
MEANT = {
    "docs/guidance.md": session_of,
    "docs/session.md": session_of,
    "docs/sensing.md": cloud_of,
    "docs/record.md": record_of,
    "docs/registration.md": points_of,
}


@pytest.mark.parametrize("page", sorted({page for page, _, _ in blocks("python")} - set(ELSEWHERE)))
def test_python_runs(page, tmp_path, monkeypatch, capsys):
    """An error that a comment announces (`# StateError: ...`) is raised by its line."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    (tmp_path / "scenes").symlink_to(ROOT / "scenes")
    names = MEANT.get(page, lambda _: {})(tmp_path)
    for _, _, text in [one for one in blocks("python") if one[0] == page]:
        for part in re.split(r"(?m)^(?=.*# \w+Error: )", text):
            run(part, names)


def run(part, names):
    """Run lines of which the first may announce the error that it raises."""
    first, _, rest = part.partition("\n")
    announced = re.search(r"# (\w+Error): (.*)", first)
    if announced is None:
        exec(part, names)
        return
    with pytest.raises(Exception, match=re.escape(announced[2].split(" ... ")[0])) as found:
        exec(first, names)
    assert type(found.value).__name__ == announced[1]
    exec(rest, names)


@pytest.mark.parametrize(("page", "k", "text"), blocks("yaml"), ids=lambda value: str(value)[:20])
def test_yaml_is_a_scene_or_an_arm(page, k, text):
    faults = yaml_faults(text)
    assert faults == "", f"{page}, block {k}"


def yaml_faults(text):
    """The message of the first error; a block without objects gets a ball."""
    if re.search(r"^(urdf|device):", text, re.M):
        return arm_faults(text)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            Scene.parse(text if re.search(r"^objects:", text, re.M) else BALL + text)
    except PalpateError as error:
        return str(error)
    return ""


def arm_faults(text):
    """As of a scene, for the file of an arm; a missing URDF is not a fault."""
    from palpate.arm.arm import Arm

    file = Path("my_arm.yaml")
    try:
        file.write_text(text, encoding="utf-8")
        Arm.load(file)
    except PalpateError as error:
        return "" if "No such file or directory: 'my_arm.urdf'" in str(error) else str(error)
    return ""


@pytest.fixture(autouse=True)
def in_a_folder_of_its_own(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


def test_the_judge_finds_wrong_blocks():
    assert "unknown key 'objects[0].stifness'" in yaml_faults("objects: [{sphere: {radius: 0.03}, stifness: 3}]")
    assert "base_radius" in yaml_faults("device: delta\nparameters: {base_radius: -1}\n")
    with pytest.raises(NameError):
        run("nothing_of_this_name()\n", {})
    with pytest.raises(pytest.fail.Exception):
        run("x = 1  # ValueError: never\n", {})
    assert all(page in {one[0] for one in blocks("python")} for page in MEANT)
    reasons = [words for page in PAGES for kind, words, _ in _BLOCK.findall(page.read_text(encoding="utf-8")) if words]
    assert all(re.match(r" not run: \w+", words) for words in reasons)
