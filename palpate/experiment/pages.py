"""Pages between trials: instructions with a button, questionnaires, breaks."""

from __future__ import annotations

import threading
import time
from html import escape
from typing import Any

import viser

from palpate.base import stop_signals
from palpate.experiment.questions import Question

_TEXT = '<div style="padding:6px 10px;font-size:15px;line-height:1.45" id="palpate-page">{}</div>'


class Pages:
    """Pages on an open server. Each waits for the participant, also while no browser is open; Ctrl-C ends the wait."""

    def __init__(self, server: viser.ViserServer) -> None:
        self._gui = server.gui

    def show(self, text: str, button: str = "Continue", earliest: float = 0.0) -> None:
        """Show a text until the button is pressed, which appears after a time [s]."""
        pressed = threading.Event()
        folder = self._gui.add_folder("Experiment")
        with folder:
            self._gui.add_html(_TEXT.format(escape(text).replace("\n", "<br>")))
            click = self._gui.add_button(button, visible=earliest <= 0.0)
        click.on_click(lambda _: pressed.set())
        due = time.monotonic() + earliest

        def look() -> None:
            if not click.visible and time.monotonic() >= due:
                click.visible = True

        try:
            stop_signals.wait(pressed, look)
        finally:
            folder.remove()

    def ask(self, title: str, questions: list[Question]) -> dict[str, Any]:
        """Ask questions until all are answered; no answer is filled in beforehand."""
        done, answered = threading.Event(), set[str]()
        folder = self._gui.add_folder(title)
        with folder:
            fields = {one.name: self._field(one, answered) for one in questions}
            said = self._gui.add_html("")
            click = self._gui.add_button("Done")

        def press(_: object) -> None:
            open_ = [one.words for one in questions if one.name not in answered]
            if open_:
                said.content = _TEXT.format("Please answer: " + escape(open_[0]))
            else:
                done.set()

        click.on_click(press)
        try:
            stop_signals.wait(done)
            return {name: field.value for name, field in fields.items()}
        finally:
            folder.remove()

    def _field(self, one: Question, answered: set[str]) -> Any:
        ends = f" ({one.ends[0]} ... {one.ends[1]})" if any(one.ends) else ""
        self._gui.add_html(f'<div style="padding:6px 10px 0 10px;font-size:13px">{escape(one.words + ends)}</div>')
        field: Any
        if one.options:
            field = self._gui.add_dropdown(one.name, ("-", *one.options), initial_value="-")
        else:
            middle = one.low + one.step * round(0.5 * (one.high - one.low) / one.step)
            field = self._gui.add_slider(one.name, one.low, one.high, one.step, middle)

        def note(_: object) -> None:
            (answered.discard if field.value == "-" else answered.add)(one.name)

        field.on_update(note)
        return field
