"""`palpate reproduce`."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from tyro.conf import Positional, arg

if TYPE_CHECKING:
    from rich.console import Console

    from palpate_lab.reproduce.run import Made


_KEYS = ("verdict", "value", "paper", "why", "section", "title")


@dataclass
class Command:
    """Compute the paper's figures, Table 1 and equations again, and set each beside what the paper prints.

    examples:
      palpate reproduce
      palpate reproduce fig11 table1 --out paper
      palpate reproduce eq1 --json -

    The items are all, fig1 to fig13, table1, eq1 to eq20, alg1 (the algorithm), and what the text says on the angle of
    approach, on noise and on dense meshes: approach, noise and mesh. Each gets a folder with pictures (PNG, SVG) and
    data (CSV); index.html shows them in the paper's order, sliders.html moves angle, gap and noise. Complete items are
    kept: after Ctrl-C or a kill the same command goes on.
    """

    items: Positional[tuple[str, ...]] = field(default=("all",))
    """The items to make; all when left out."""
    out: Annotated[Path, arg(metavar="DIR")] = Path("runs/paper")
    """Folder for the items and the page."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write verdicts and figures as JSON (docs/json/reproduce.md); - for the standard output."""
    seed: int = 1
    """Seed of all random numbers [-]."""
    workers: Annotated[int | None, arg(metavar="N")] = None
    """Processes of the parameter studies; default: one per core."""
    again: bool = False
    """Make every item anew, also complete ones."""

    def __call__(self) -> int:
        """Make the items, write the page and the JSON."""
        from importlib.util import find_spec

        from palpate.base.errors import MissingExtraError, PalpateError
        from palpate.cli.terminal.output import console_for, make_folder, require_writable, say, write_json
        from palpate_lab.reproduce.catalogue import chosen

        names = chosen(self.items or ("all",))
        if not 0 <= self.seed < 2**32:
            raise PalpateError(f"--seed {self.seed}: must be a whole number from 0 to 2^32", mend="give e.g. --seed 1")
        if self.workers is not None and self.workers < 1:
            raise PalpateError(f"--workers {self.workers}: must be 1 or more", mend="leave it out for one per core")
        if find_spec("matplotlib") is None:
            raise MissingExtraError("what draws the pictures", "report")
        console = console_for(self.json)
        require_writable(self.json)
        make_folder(self.out)
        require_writable(self.out / "index.html")
        made = self._make(names, console)
        from palpate_lab.reproduce.page import write_page
        from palpate_lab.reproduce.sliders import write_sliders

        sliders = write_sliders(self.out)
        say(console, str(write_page(made, self.out, None if sliders is None else sliders.name)), "page")
        write_json(self.json, {
            "seed": self.seed,
            "wall_s": sum(one.wall_s for one in made),
            "cpu_s": sum(one.cpu_s for one in made),
            "items": {one.name: {key: one.result[key] for key in _KEYS} for one in made},
        })  # fmt: skip
        return 0

    def _make(self, names: list[str], console: Console) -> list[Made]:
        from palpate.cli.terminal.output import say
        from palpate_lab.reproduce.run import make_all

        def told(line: str) -> None:
            say(console, line)
            console.file.flush()  # for readers of a pipe: an item takes up to a minute

        total = iter(range(1, len(names) + 1))
        try:
            return make_all(
                names, self.out, self.seed, self.workers, self.again,
                on_item=lambda one: told(self._line(one, next(total), len(names))),
            )  # fmt: skip
        except KeyboardInterrupt:
            say(console, f"complete items are kept in {self.out}: the same command goes on")
            raise

    @staticmethod
    def _line(one: Made, number: int, total: int) -> str:
        spent = "kept" if one.kept else f"{one.wall_s:.1f} s, {one.cpu_s:.1f} s of processor time"
        return f"{number:2}/{total} {one.name:7} {one.result['verdict']:8} {spent}"
