"""Every line of the shell blocks on the pages runs, in the form that shell_forms.py gives it.

Lines of a page run one after the other in a folder of their own, with the files that shell_files.py makes for it;
commands of palpate run in this process. `make test` runs those of QUICK, `make test-long` those of LONG too. A block
that cannot run says why in its fence: ```bash not run: needs a device.
"""

import glob
import os
import re
import shlex
import shutil
import subprocess
import sys
import warnings
from pathlib import Path

import pytest
from cli_words import parse
from shell_files import MEANT
from shell_forms import ELSEWHERE, LONG, QUICK, RECORDINGS

from palpate.cli import main

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
DATA = Path(os.environ.get("PALPATE_DATA") or ROOT.parent / "shared" / "data")
BLOCK = re.compile(r"^( *)```(?:bash|sh|shell|console)\b([^\n]*)\n(.*?)^\1```", re.M | re.S)
REASON = re.compile(r" not run: \w+")
ALL = QUICK | LONG | ELSEWHERE


def lines_of(text):
    """Lines of the blocks of a page that have no reason, without comments, continued lines joined."""
    found = []
    for _, words, block in BLOCK.findall(text):
        if not words.strip():
            bare = (re.sub(r"(^|\s)#.*", "", line).strip() for line in block.replace("\\\n", " ").splitlines())
            found += [line for line in bare if line]
    return found


def key_of(line):
    """The longest key of the tables that begins a line; scenes are named without folder and suffix; None: no key."""
    plain = " ".join(re.sub(r"^(?:[A-Z_]+=\S+ +)+|\bscenes/(?=\w+\.yaml)|(?<=\w)\.yaml\b", "", line).split())
    return max((key for key in ALL if f"{plain} ".startswith(f"{key} ")), key=len, default=None)


LINES = {str(page.relative_to(ROOT)): lines_of(page.read_text(encoding="utf-8")) for page in PAGES}


def pages(*tables):
    """Pages with a line of these tables."""
    return [page for page, lines in LINES.items() if any(key_of(line) in table for line in lines for table in tables)]


@pytest.fixture
def place(tmp_path, monkeypatch, unarranged_figures, without_figures):
    """An empty working folder, in which the folders of the repository that pages name are found."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    monkeypatch.setenv("PALPATE_DATA", str(DATA.resolve()))
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)
    shutil.copytree(ROOT / "scenes", tmp_path / "scenes")  # some commands write beside their scene
    (tmp_path / "core").symlink_to(ROOT / "core")
    (tmp_path / "docs").mkdir()
    return tmp_path


def run(line):
    """Run a line as the shell would, with the words that its table adds; returns the exit code."""
    key = key_of(line)
    words = shlex.split(line.replace("$PWD", os.getcwd()))
    while re.match(r"[A-Z_]+=", words[0]):
        del words[0]
    words += shlex.split((QUICK | LONG)[key])
    words = [one for word in words for one in (sorted(glob.glob(word)) if "*" in word else [word])]
    if words[0] != "palpate":
        return subprocess.run(
            [sys.executable if words[0] == "python" else words[0], *words[1:]], check=False
        ).returncode
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            return main(words[1:])
        except SystemExit as end:
            return int(end.code or 0)


def run_page(page, *tables):
    """Run the lines of these tables; a certificate may find a scene unstable, which is no fault of its command.

    Lines that read recordings of others are left out where there are none (PALPATE_DATA)."""
    MEANT.get(page, lambda: None)()
    for line in LINES[page]:
        if any(key_of(line) in table for table in tables) and (DATA.is_dir() or key_of(line) not in RECORDINGS):
            for out in ("r.json", "data.nc", "f", "o"):  # of the line before
                shutil.rmtree(out, ignore_errors=True) if Path(out).is_dir() else Path(out).unlink(missing_ok=True)
            code = run(line)
            assert code == 0 or (code == 1 and line.startswith("palpate certify")), line


@pytest.mark.parametrize("page", pages(QUICK))
def test_quick_lines_run(page, place, capsys):
    run_page(page, QUICK)


@pytest.mark.long
@pytest.mark.parametrize("page", pages(LONG))
def test_all_lines_run(page, place, capsys):
    run_page(page, QUICK, LONG)


def test_every_line_has_a_form_and_every_form_a_line():
    keys = {key_of(line) for lines in LINES.values() for line in lines}
    assert [line for lines in LINES.values() for line in lines if key_of(line) is None] == []
    assert ALL.keys() - keys == set()
    assert len(QUICK) + len(LONG) + len(ELSEWHERE) == len(ALL)
    assert {page for page in MEANT if page not in pages(QUICK, LONG)} == set()


def test_the_words_of_every_long_form_are_understood(capsys):
    """`make test-long` runs them; here they are parsed."""
    for line in dict.fromkeys(line for lines in LINES.values() for line in lines if key_of(line) in LONG):
        words = shlex.split(line) + shlex.split(LONG[key_of(line)])
        if words[0] == "palpate":
            try:
                parse(words)
            except SystemExit:
                pytest.fail(f"{' '.join(words)}\n{capsys.readouterr().err}")


@pytest.mark.parametrize(("key", "file"), ELSEWHERE.items())
def test_a_line_that_runs_elsewhere_is_named_there(key, file):
    text = (ROOT / "tests" / file).read_text(encoding="utf-8")
    assert Path(key.split()[-1]).name.lstrip("-") in text


def test_a_block_that_does_not_run_says_why():
    reasons = [words for page in PAGES for _, words, _ in BLOCK.findall(page.read_text(encoding="utf-8")) if words]
    assert [words for words in reasons if not REASON.match(words)] == []


def test_the_judge_finds_a_line_that_fails(place, capsys):
    page = "```bash\npalpate keys --out a.key   # once\npalpate keys \\\n  --out a.key\n```\n"
    first, again = lines_of(page + "```bash not run: x\nfalse\n```\n")
    assert run(first) == 0
    assert run(again) == 2, "the file exists"
    assert run("palpate keys --nope") == 2
    assert key_of("palpate ros simm") is None
    assert key_of("A=1 palpate run scenes/breathing.yaml --headless") == "palpate run breathing"
