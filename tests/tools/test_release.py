"""The checks before a release find what they are for; forms for issues are valid."""

import importlib.util
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))


@pytest.fixture
def tool(tmp_path, monkeypatch):
    spec = importlib.util.spec_from_file_location("release_tool", ROOT / "tools" / "release.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    monkeypatch.setattr(module, "ROOT", tmp_path)
    (tmp_path / "pyproject.toml").write_text('[project]\nversion = "1.2.3"\n')
    (tmp_path / "CITATION.cff").write_text("version: 1.2.3\n")
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## 1.2.3 (2026-12-01)\n\n## 1.2.2 (2026-11-01)\n")
    return module


def test_same_version_everywhere_passes(tool):
    assert tool.same_version() == ""


@pytest.mark.parametrize(
    ("file", "text", "words"),
    [
        ("CITATION.cff", "version: 1.2.2\n", "names 1.2.2 instead of 1.2.3"),
        ("CITATION.cff", "title: a\n", "names none"),
        ("CHANGELOG.md", "## 1.2.3 (unreleased)\n", "no date for 1.2.3"),
        ("CHANGELOG.md", "## 1.2.2 (2026-11-01)\n", "no heading"),
    ],
)
def test_another_version_is_found(tool, tmp_path, file, text, words):
    (tmp_path / file).write_text(text)
    assert words in tool.same_version()


def test_uncommitted_file_is_found(tool, tmp_path):
    tool.command("git", "init", "--quiet")
    assert "CITATION.cff" in tool.clean_tree()


def test_failed_command_gives_its_last_words(tool, capsys, monkeypatch):
    assert tool.last_line(tool.command("sh", "-c", "echo one; echo two >&2; exit 3")) == "two"
    assert tool.last_line(tool.command("true")) == ""
    monkeypatch.setattr(tool, "QUICK", (lambda: "a fault",))
    assert tool.main(["--quick"]) == 1
    assert "a fault" in capsys.readouterr().out


@pytest.mark.parametrize("form", FORMS, ids=lambda form: form.stem)
def test_form_has_what_the_host_of_the_repository_asks_for(form):
    made = yaml.safe_load(form.read_text(encoding="utf-8"))
    assert {"name", "description", "body"} <= set(made)
    ids = [part["id"] for part in made["body"] if part["type"] != "markdown"]
    assert len(ids) == len(set(ids)) > 0
    assert all(part["attributes"].get("label") or part["attributes"].get("value") for part in made["body"])
