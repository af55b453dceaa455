"""``palpate study figure12``."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

from rich.console import Console

from palpate.cli.terminal.output import say
from palpate_lab.studies._command import Findings, Study


@dataclass
class Command(Study):
    """The paper's Fig 12: instrument in four meshes, body and spatial force on the master arm (half a minute).

    examples:
      palpate study figure12
      palpate study figure12 --figures docs/images
    """

    def study(self, console: Console) -> Findings:
        """Compute the result of the study."""
        from palpate_lab.studies.figure12.figures import save
        from palpate_lab.studies.figure12.work import line, row, run

        moments = run()
        for moment in moments:
            say(console, line(moment))
        return Findings([row(moment) for moment in moments], partial(save, moments))
