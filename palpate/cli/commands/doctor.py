"""`palpate doctor`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from palpate.cli.terminal.output import console_for, require_writable, say, write_json

_LOOKS = {"ok": ("ok", "green"), "optional": ("-", "yellow"), "problem": ("fix", "red")}


@dataclass
class Command:
    """Examine this machine: compiler, real-time rights, browser, ROS 2, devices, ports, disk; and how to fix each.

    Nothing is changed, and no device is opened.

    examples:
      palpate doctor
      palpate doctor real-time USB
      palpate doctor --json -
    """

    topics: Positional[tuple[str, ...]] = ()
    """Topics, e.g. real-time; none: all."""
    json: Annotated[Path | None, arg(metavar="FILE")] = None
    """Write the findings as JSON (docs/json.md); - for the standard output."""

    def __call__(self) -> int:
        """Print the findings; returns 1 if there is a problem."""
        from palpate.cli.doctor import examine

        console = console_for(self.json)
        require_writable(self.json)
        findings = examine(self.topics)
        topic = ""
        for one in findings:
            if one.topic != topic:
                topic = one.topic
                say(console, topic, style="bold")
            mark, style = _LOOKS[one.state]
            console.print(f"  {mark:3s}", style=style, end=" ", markup=False)
            say(console, f"{one.thing}: {one.found}")
            if one.fix:
                say(console, f"        needed for {one.needed_for}; fix: {one.fix}")
        problems = sum(one.state == "problem" for one in findings)
        say(console, "")
        say(console, "no problem was found" if not problems else f"problems: {problems}, marked `fix`")
        write_json(self.json, {"problems": problems, "findings": findings})
        return 1 if problems else 0
