"""The command line: `palpate NAME` is a file in `commands`; `terminal` writes, `doctor` examines the machine."""

from __future__ import annotations

import atexit
import gc
import os
import sys
import warnings
from typing import Any

from palpate.base import stop_signals
from palpate.base.errors import PalpateError, PalpateWarning
from palpate.cli.terminal import INTERRUPTED, MISTAKE

#: Packages whose files are the commands.
MEMBERS = ("palpate.cli.commands", "palpate_lab.commands")

#: Commands that `palpate --help` lists first, in this order; the others follow in alphabetical order.
FIRST = (
    "run", "replay", "report", "record", "metrics", "check", "frames", "certify", "study", "experiment", "reproduce",
    "calibrate", "identify", "register", "tracker", "device", "bench", "fuzz", "soak", "coverage", "ros", "plan",
    "export", "policy", "path", "grid", "scan", "scenes", "schema", "cache", "doctor", "licenses", "completion",
)  # fmt: skip

_DESCRIPTION = """\
Palpate renders the contact forces of virtual and scanned anatomy on the master arm of a surgical robot.

examples:
  palpate run palpation
  palpate check my_organ.stl
  palpate run --help"""


def main(args: list[str] | None = None) -> int:
    """Run one command; returns the exit code: 0 success, 2 a mistake that the message explains, 130 Ctrl-C."""
    if args is None:  # the process is ours
        args = sys.argv[1:]
        _collect_seldom()
    if args in (["--version"], ["-V"]):
        from palpate import __version__

        print(f"palpate {__version__}")
        return 0
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # to look for them takes 10 ms at each start
    warnings.showwarning = _show_warning
    warnings.simplefilter("always", PalpateWarning)
    try:
        with stop_signals.handled():
            from palpate.cli._folder import dispatch

            return dispatch(sys.modules[__name__], "palpate", _DESCRIPTION, args)
    except PalpateError as error:
        print(_paint(f"error: {error}", 31), file=sys.stderr)
        return MISTAKE
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of the output has closed it, e.g. `| head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1


def _collect_seldom() -> None:
    """Collect garbage seldom at the start, and not at the end: both pass over all modules, a quarter of a short run."""
    gc.set_threshold(50_000, 20, 50)
    atexit.register(gc.freeze)


def _show_warning(message: Any, category: type[Warning], *place: Any, **more: Any) -> None:
    name = "warning" if issubclass(category, PalpateWarning) else category.__name__
    print(_paint(f"{name}: {message}", 33), file=sys.stderr)


def _paint(text: str, colour: int) -> str:
    first, colon, rest = text.partition(":")
    return f"\033[{colour}m{first}{colon}\033[0m{rest}" if sys.stderr.isatty() else text
