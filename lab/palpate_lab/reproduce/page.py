"""The page that sets each item beside the paper."""

from __future__ import annotations

from html import escape
from pathlib import Path

from palpate.cli.terminal.output import write_text
from palpate.report.html import page_of
from palpate_lab.reproduce.figures_in_words import prose, values
from palpate_lab.reproduce.item import VERDICTS
from palpate_lab.reproduce.run import Made

PAGE = "index.html"
_SOURCE = "Munawar and Fischer, Frontiers in Robotics and AI 3:47 (2016), doi:10.3389/frobt.2016.00047"
_NOTE = {"agrees": "note", "differs": "note warn", "not testable without the robot": "note", "not made": "note bad"}
_STYLE = """<style>
nav { columns: 4 190px; font-size: 14.5px; margin-top: 18px; }
nav a { display: block; color: var(--cool); text-decoration: none; }
nav .v { color: var(--muted); font-size: 12px; }
figure { margin: 14px 0 0; }
figcaption { color: var(--muted); font-size: 14px; margin-top: 4px; }
.sides { display: grid; grid-template-columns: 1fr 1fr; gap: 0 32px; margin-top: 6px; }
.sides h3 { font-size: 13px; color: var(--muted); margin: 8px 0 2px; font-weight: 600; }
.sides p { margin: 0; }
.sides ul { margin: 0; padding-left: 18px; overflow-wrap: anywhere; }
.sides table { font-size: 13px; overflow-wrap: normal; }
.sides > div { min-width: 0; }
.files { font-size: 13.5px; color: var(--muted); margin: 12px 0 0; }
figure img { max-width: 100%; }
section > .note p { max-width: 90ch; }
@media (max-width: 700px) { .sides { grid-template-columns: 1fr; } }
</style>"""


def write_page(made: list[Made], folder: Path, sliders: str | None) -> Path:
    """Write the page of the items into their folder; returns its file.

    Args:
        made: the items, in the paper's order.
        folder: folder of the items.
        sliders: name of the page with sliders in this folder, or None.

    Raises:
        OutputError: the page cannot be written.
    """
    counts = {verdict: sum(one.result["verdict"] == verdict for one in made) for verdict in VERDICTS}
    facts = "".join(
        f'<div class="fact"><b>{count}</b><span>{escape(verdict)}</span></div>' for verdict, count in counts.items()
    )
    links = "".join(
        f'<a href="#{one.name}">{_number(one)} {escape(one.result["title"])} '
        f'<span class="v">{escape(one.result["verdict"])}</span></a>'
        for one in made
    )
    more = (
        f'<p><a href="{sliders}">Sliders: angle of approach, gap, noise and radius</a> (needs no server)</p>'
        if sliders
        else ""
    )
    head = (
        "<header><h1>The paper beside Palpate</h1>"
        f"<p>{_SOURCE}. Each figure, table and equation with what the paper shows or says in our words, the reading "
        "taken, "
        "our figures, and a verdict. Arms, hands and sensors are simulated.</p></header>"
    )
    body = f'{_STYLE}{head}<div class="facts">{facts}</div>{more}<nav>{links}</nav>{"".join(map(_section, made))}'
    file = folder / PAGE
    write_text(file, page_of("The paper beside Palpate", body))
    return file


def _number(one: Made) -> str:
    """The item's name as the paper writes it, such as Fig 13."""
    for prefix, word in (("fig", "Fig "), ("table", "Table "), ("eq", "Eq "), ("alg", "Algorithm ")):
        if one.name.startswith(prefix):
            return word + one.name.removeprefix(prefix)
    return ""


def _section(one: Made) -> str:
    r = one.result
    reading = f"<h3>Reading taken</h3><p>{prose(r['reading'])}</p>" if r["reading"] else ""
    later = f"<h3>The authors' later code</h3><p>{prose(r['later'])}</p>" if r["later"] else ""
    pictures = "".join(
        f'<figure><a href="{one.name}/{pair[1]["file"]}"><img src="{one.name}/{pair[0]["file"]}" loading="lazy" '
        f'alt="{escape(pair[0]["caption"])}"></a><figcaption>{prose(pair[0]["caption"])}</figcaption></figure>'
        for pair in zip(r["pictures"][::2], r["pictures"][1::2], strict=True)
    )
    data = f'<a href="{one.name}/{r["data"]}">data (CSV)</a> · ' if r["data"] else ""
    code = ", ".join(f"<code>{escape(name)}</code>" for name in r["code"])
    rows = f" · requirements {', '.join(r['rows'])}" if r["rows"] else ""
    return (
        f'<section id="{one.name}"><h2>{_number(one)} {escape(r["title"])}</h2><p>{escape(r["section"])}</p>'
        f'<div class="sides"><div><h3>The paper</h3><p>{escape(r["claim"])}</p>{values(r["paper"])}'
        f"{reading}{later}</div>"
        f"<div><h3>Palpate</h3>{values(r['value'])}</div></div>"
        f'<div class="{_NOTE[r["verdict"]]}"><p><b>{escape(r["verdict"].capitalize())}.</b> '
        f"{prose(r['why'])}</p></div>"
        f'{pictures}{r["table"]}<p class="files">{data}code: {code}{rows}</p></section>'
    )
