"""The comparison of the factor of lockstep with another commit: its table, and the checkout with a patch."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "tools"))
import lockstep_ratio  # noqa: E402
from lockstep_ratio import Round, table  # noqa: E402


def test_the_table_has_the_ratio_of_the_medians():
    before = [Round(50.0, 5.0), Round(10.0, 9.0), Round(60.0, 6.0)]
    now = [Round(100.0, 2.0), Round(125.0, 3.0), Round(300.0, 2.5)]
    lines = [line.split("  ") for line in table(before, now).splitlines()]
    words = [[word.strip() for word in line if word.strip()] for line in lines]
    assert words[1] == ["1", "50.0", "100.0", "2.00", "5.00", "2.00"]
    assert words[-1] == ["median", "50.0", "125.0", "2.50", "6.00", "2.50"]
    assert len({len(line) for line in table(before, now).splitlines()}) == 1


def test_a_worktree_is_patched_and_removed(tmp_path, monkeypatch):
    repository = tmp_path / "repository"
    git = ["git", "-C", str(repository), "-c", "user.name=a", "-c", "user.email=a@b"]
    subprocess.run(["git", "init", "-q", str(repository)], check=True)
    (repository / "word").write_text("old\n")
    subprocess.run([*git, "add", "word"], check=True)
    subprocess.run([*git, "commit", "-qm", "one"], check=True)
    (repository / "word").write_text("new\n")
    patch = tmp_path / "word.patch"
    patch.write_text(subprocess.check_output([*git, "diff"], text=True))
    monkeypatch.setattr(lockstep_ratio, "ROOT", repository)
    with lockstep_ratio.worktree("HEAD", patch) as root:
        assert (root / "word").read_text() == "new\n"
    assert not root.exists()
    with pytest.raises(subprocess.CalledProcessError), lockstep_ratio.worktree("HEAD", tmp_path / "none"):
        pass
    assert len(subprocess.check_output([*git, "worktree", "list"], text=True).splitlines()) == 1
