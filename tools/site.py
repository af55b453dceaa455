"""Builds the documentation site: all pages, the examples, and a reference of the Python interface from its docstrings.

    python tools/site.py [OUT]        # make site: into build/site

The pages stay where they are in the repository, and link to each other and to its files. The builder copies them, with
every file of the repository to which one links, and a link or an anchor that leads nowhere is an error. The site needs
no server of others: fonts and search are part of it.
"""

from __future__ import annotations

import ast
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]
#: Headings of the site and their pages: those of docs by name, those of the root with a slash in front. A page that
#: is in none of them is an error.
NAVIGATION = {
    "Start": "/index howto /examples/index /examples/*/index comparison platforms viewer session",
    "Contact": "contact contact-* meshes slicer geometry wall oscillation",
    "Soft tissue": "tissue tissue-* soft-thread grasping",
    "Sensing and registration": "sensing camera scan frames registration registration-*",
    "Guidance and plans": "guidance guidance-* planning planning-*",
    "Stability": "stability stability-* certificate torque hands verification",
    "Arms and devices": "arms calibrate dynamics device device-* haply ecm",
    "Several hands": "pairs pairs-*",
    "ROS 2": "ros2 ros2-*",
    "Records and studies": "record metrics studies coverage operators paper requirements * json json/*",
    "Python": "/api/*",
    "Project": "/ARCHITECTURE /NOTATION /CONTRIBUTING changes extending security /SECURITY /CHANGELOG",
    "History": "decisions/* history/*",
}
#: Languages of the files in folders of examples.
CODE = {".py": "python", ".cpp": "cpp", ".hpp": "cpp", ".toml": "toml", ".txt": "cmake", ".yaml": "yaml"}
_LINK = re.compile(r"(\]\()([^)#\s]+)((?:#[^)\s]*)?\))")


def main(out: Path) -> int:
    """Copy, complete, build; returns the exit code of the builder."""
    work = ROOT / "build" / "site-source"
    shutil.rmtree(work, ignore_errors=True)
    pages = work / "pages"
    for page in sorted([*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]):
        copy(page, pages)
    examples(pages)
    reference(pages)
    (work / "mkdocs.yml").write_text(yaml.safe_dump(settings(pages, out.resolve()), sort_keys=False), encoding="utf-8")
    return subprocess.run([sys.executable, "-m", "mkdocs", "build", "--strict", "-f", work / "mkdocs.yml"],
                          check=False).returncode  # fmt: skip


def copy(page: Path, pages: Path) -> None:
    """Copy a page and the files to which it links; README.md becomes the first page."""

    def target(found: re.Match[str]) -> str:
        link = found[2]
        file = (page.parent / link).resolve()
        if "://" in link or not file.is_relative_to(ROOT):
            return found[0]
        if file == ROOT / "README.md":
            return f"{found[1]}{link.removesuffix('README.md')}index.md{found[3]}"
        if file.is_dir():
            return f"{found[1]}{link.rstrip('/')}/index.md{found[3]}"
        if file.suffix != ".md" and file.is_file():
            place = pages / file.relative_to(ROOT)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(file, place)
        return found[0]

    name = "index.md" if page == ROOT / "README.md" else str(page.relative_to(ROOT))
    place = pages / name
    place.parent.mkdir(parents=True, exist_ok=True)
    place.write_text(_LINK.sub(target, page.read_text(encoding="utf-8")), encoding="utf-8")


def examples(pages: Path) -> None:
    """Pages with all examples, with the notebooks, and with the files of each other folder of examples."""
    here = ROOT / "examples"
    lines = ["# Examples", "", "Numbered examples, one idea each.", ""]
    for file in sorted(here.glob("*.py")):
        text = file.read_text(encoding="utf-8")
        words = ast.get_docstring(ast.parse(text)) or ""
        lines += [f"## {file.stem}", "", words, "", "```python", text, "```", ""]
    found = {"": lines, "notebooks": notebooks(here / "notebooks")}
    for folder in sorted(here.iterdir()):
        if folder.is_dir() and folder.name not in ("notebooks", "__pycache__"):
            lines = found[folder.name] = [f"# examples/{folder.name}", ""]
            for file in sorted(one for one in folder.rglob("*") if one.suffix in CODE):
                lines += [f"## {file.relative_to(folder)}", "", f"```{CODE[file.suffix]}"]
                lines += [file.read_text(encoding="utf-8"), "```", ""]
    for name, lines in found.items():
        (pages / "examples" / name).mkdir(parents=True, exist_ok=True)
        (pages / "examples" / name / "index.md").write_text("\n".join(lines), encoding="utf-8")


def notebooks(folder: Path) -> list[str]:
    """Lines of a page with the cells of all notebooks of a folder, without their outputs."""
    lines = ["# Notebooks", "", "Open them with `jupyter lab examples/notebooks`.", ""]
    for file in sorted(folder.glob("*.ipynb")):
        for cell in json.loads(file.read_text(encoding="utf-8"))["cells"]:
            text = "".join(cell["source"])
            if cell["cell_type"] == "code":
                lines += ["```python", text, "```", ""]
            else:
                lines += [f"#{text}" if text.startswith("# ") else text, ""]
    return lines


def reference(pages: Path) -> None:
    """A page for each public name of the package."""
    import palpate

    (pages / "api").mkdir()
    for name in palpate.__all__:
        if name.startswith("_"):
            continue
        place = palpate._PLACE.get(name, f"palpate.{name}").replace(":", ".")
        (pages / "api" / f"{name}.md").write_text(f"# palpate.{name}\n\n::: {place}\n", encoding="utf-8")


def navigation(pages: Path) -> list[dict[str, list[str]]]:
    """NAVIGATION with the files that exist, each once.

    Raises:
        SystemExit: a page is in no part of it.
    """
    left = {str(page.relative_to(pages).with_suffix("")) for page in pages.rglob("*.md")}
    parts: list[dict[str, list[str]]] = []
    asked = {
        heading: [name[1:] if name[0] == "/" else f"docs/{name}" for name in names.split()]
        for heading, names in NAVIGATION.items()
    }
    named = {name for names in asked.values() for name in names if "*" not in name}
    for heading, names in asked.items():
        found: list[str] = []
        for name in names:
            fitting = [name] if "*" not in name else sorted(one for one in left - named if Path(one).match(name))
            found += [f"{one}.md" for one in fitting if one in left]
            left -= set(fitting)
        parts.append({heading: found})
    if left:
        raise SystemExit(f"tools/site.py: add to NAVIGATION: {', '.join(sorted(left))}")
    return parts


def settings(pages: Path, out: Path) -> dict[str, object]:
    """What mkdocs needs to know."""
    python = {
        "docstring_style": "google", "show_root_heading": False, "show_root_toc_entry": False, "show_source": False,
        "members_order": "source", "merge_init_into_class": True, "filters": ["!^_"], "separate_signature": True,
        "heading_level": 2,
    }  # fmt: skip
    handlers = {"python": {"paths": [str(ROOT)], "options": python}}
    extensions = ["tables", "admonition", "pymdownx.superfences", "pymdownx.highlight", {"toc": {"permalink": True}}]
    strict = {"not_found": "warn", "anchors": "warn", "absolute_links": "warn"}
    return {
        "site_name": "Palpate",
        "docs_dir": str(pages),
        "site_dir": str(out),
        "use_directory_urls": False,
        "theme": {"name": "material", "font": False, "features": ["navigation.indexes", "content.code.copy"]},
        "plugins": ["search", "offline", {"mkdocstrings": {"handlers": handlers}}],
        "markdown_extensions": extensions,
        "validation": {"links": strict, "omitted_files": "warn"},
        "nav": navigation(pages),
    }


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "build" / "site"))
