"""The scenes that come with Palpate: in the installed package, or in the folder `scenes` of the repository."""

from __future__ import annotations

from pathlib import Path

from palpate.base.errors import PalpateError


def folder() -> Path | None:
    """Folder of the shipped scenes; None if there is none."""
    here = Path(__file__).resolve().parents[1]
    return next((f for f in (here / "scenes", here.parent / "scenes") if (f / "palpation.yaml").is_file()), None)


def names() -> tuple[str, ...]:
    """Names of the shipped scenes in alphabetical order."""
    found = folder()
    return tuple(sorted(path.stem for path in found.glob("*.yaml"))) if found is not None else ()


def file(name: str) -> Path:
    """The file of the shipped scene with this name.

    Raises:
        PalpateError: it is missing.
    """
    found = folder()
    if found is None or not (found / f"{name}.yaml").is_file():
        raise PalpateError(f"the shipped scene {name}.yaml is missing", mend="install palpate again")
    return found / f"{name}.yaml"


def find(path: Path) -> Path:
    """The file of the shipped scene with this name, such as ``palpation``; any other path is returned unchanged."""
    plain = path.name == str(path) and not path.suffix
    return file(path.name) if plain and not path.exists() and path.name in names() else path


def summary(name: str) -> str:
    """The first sentence of the comment at the start of a shipped scene."""
    lines = file(name).read_text(encoding="utf-8").splitlines()[1:]
    comment = []
    for line in lines:
        if not line.startswith("# "):
            break
        comment.append(line.removeprefix("# "))
    return " ".join(comment).partition(". ")[0].rstrip(".")


def copy_text(name: str) -> str:
    """Text of a shipped scene for a folder of the user, without the line that refers to the repository."""
    lines = file(name).read_text(encoding="utf-8").splitlines(keepends=True)
    return "".join(line for line in lines if not line.startswith("# yaml-language-server:"))
