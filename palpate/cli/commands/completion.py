"""`palpate completion`."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import Literal

from tyro.conf import Positional


@dataclass
class Command:
    """Print what completes commands and options of palpate with the Tab key in a shell.

    examples:
      palpate completion bash > ~/.local/share/bash-completion/completions/palpate
      palpate completion zsh > ~/.palpate.zsh
      palpate completion fish > ~/.config/fish/completions/palpate.fish
    """

    shell: Positional[Literal["bash", "zsh", "fish"]]
    """The shell."""

    def __call__(self) -> int:
        """Print the script. It takes seconds, since each command is imported for its options."""
        from palpate.cli._completion import script

        sys.stdout.write(script(self.shell))
        return 0
