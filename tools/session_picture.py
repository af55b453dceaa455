"""Draws the states of a session from the table of the core: docs/images/session.svg and the tables of docs/session.md.

python tools/session_picture.py            # writes both
python tools/session_picture.py --check    # writes nothing; exits with 1 if one of them is out of date
"""

from __future__ import annotations

import sys
from collections import Counter
from html import escape
from pathlib import Path

from palpate.session import machine

ROOT = Path(__file__).resolve().parents[1]
PICTURE, PAGE = ROOT / "docs/images/session.svg", ROOT / "docs/session.md"
COLUMN, ROW, WIDTH, HEIGHT, LEFT, TOP = 178.0, 128.0, 104.0, 40.0, 70.0, 48.0
PLACES = {
    "off": (0, 1), "powered": (1, 1), "homing": (2, 1), "homed": (3, 1), "aligning": (4, 1), "following": (5.6, 1),
    "clutched": (4.8, 0), "executing": (3.2, 0), "camera": (4.8, 2),
    "hold": (0.25, 2), "recover": (1.25, 2), "fault": (2.25, 2),
}  # fmt: skip
COLORS = {"following": "#d5efd9", "fault": "#f6d4d0", "recover": "#f9e8cf", "hold": "#f9e8cf"}
SHARED = 4
"""Number of states from which a cause leads to the same state for it to become a line of text instead of arrows."""
Point = tuple[float, float]


def shared() -> dict[tuple[str, str], list[str]]:
    """Causes with their goal that many states share, and these states."""
    count = Counter((cause, to) for _, cause, to in machine.TRANSITIONS)
    return {
        key: [at for at, cause, to in machine.TRANSITIONS if (cause, to) == key]
        for key in count
        if count[key] >= SHARED
    }


def _center(state: str) -> Point:
    x, y = PLACES[state]
    return LEFT + WIDTH / 2 + COLUMN * x, TOP + HEIGHT / 2 + ROW * y


def _leaves(box: Point, a: Point, b: Point) -> Point:
    """First point on the way from a to b that is outside of the box around a centre."""
    for k in range(1001):
        x, y = a[0] + 1e-3 * k * (b[0] - a[0]), a[1] + 1e-3 * k * (b[1] - a[1])
        if abs(x - box[0]) > WIDTH / 2 + 3 or abs(y - box[1]) > HEIGHT / 2 + 3:
            return x, y
    return b


def _arrow(at: str, cause: str, to: str, twoway: bool) -> str:
    a, b = _center(at), _center(to)
    dx, dy = b[0] - a[0], b[1] - a[1]
    away = 13.0 / (dx * dx + dy * dy) ** 0.5 if twoway else 0.0
    start, end = (a[0] - away * dy, a[1] + away * dx), (b[0] - away * dy, b[1] + away * dx)
    (x1, y1), (x2, y2) = _leaves(a, start, end), _leaves(b, end, start)
    share = 0.28 if twoway or abs(dy) > 1.5 * ROW else 0.5  # labels of neighbouring arrows stay apart
    share = 0.75 if abs(dx) > 1.5 * COLUMN else share
    x, y = x1 + share * (x2 - x1), y1 + share * (y2 - y1)
    style = "" if cause in machine.REQUESTS else ' stroke-dasharray="5 3"'
    line = f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}"{style} marker-end="url(#tip)"/>'
    wide = 6.4 * len(cause) + 6
    box = f'<rect x="{x - wide / 2:.1f}" y="{y - 8:.1f}" width="{wide:.1f}" height="16" fill="#fff" stroke="none"/>'
    return f'{line}{box}<text class="cause" x="{x:.1f}" y="{y + 4:.1f}">{escape(cause)}</text>'


def picture() -> str:
    """Text of the SVG."""
    rare = [row for row in machine.TRANSITIONS if (row[1], row[2]) not in shared()]
    ends = {(at, to) for at, _, to in rare}
    wide, high = LEFT + 6.5 * COLUMN - 10, TOP + 3 * ROW + 40
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide:.0f} {high:.0f}" font-family="sans-serif">',
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="8" markerHeight="8" orient="auto">'
        '<path d="M0 0L8 4L0 8z" fill="#444"/></marker></defs>',
        "<style>text{font-size:13px;text-anchor:middle}.cause{font-size:11px;fill:#333}"
        ".note{text-anchor:start;font-size:12px}</style>",
        f'<rect width="{wide:.0f}" height="{high:.0f}" fill="#fff"/><g stroke="#444" fill="none" stroke-width="1.3">',
    ]
    parts += [
        _arrow(*row, (row[2], row[0]) in ends).replace("<text", '<text stroke="none" fill="#333"') for row in rare
    ]
    parts.append("</g>")
    for state in machine.NAMES:
        x, y = _center(state)
        parts.append(
            f'<rect x="{x - WIDTH / 2:.1f}" y="{y - HEIGHT / 2:.1f}" width="{WIDTH:.0f}" height="{HEIGHT:.0f}" rx="8" '
            f'fill="{COLORS.get(state, "#e4ecf7")}" stroke="#444"/><text x="{x:.1f}" y="{y + 4.5:.1f}">{state}</text>'
        )
    for k, ((cause, to), states) in enumerate(shared().items()):
        text = f"{cause} leads to {to} from {', '.join(states)}"
        parts.append(f'<text class="note" x="{LEFT:.0f}" y="{high - 18 * (len(shared()) - k):.0f}">{text}</text>')
    return "\n".join([*parts, "</svg>"]) + "\n"


def tables() -> str:
    """Tables of the page: states with the requests that each takes, and the causes."""
    rows = ["| number | state | meaning | requests that it takes |", "|---|---|---|---|"]
    rows += [
        f"| {k} | `{state}` | {words} | {', '.join(machine.legal(state))} |"
        for k, (state, words) in enumerate(machine.STATES.items())
    ]
    rows += ["", "| cause | from | meaning |", "|---|---|---|"]
    rows += [
        f"| `{cause}` | {'a person' if cause in machine.REQUESTS else 'a measurement'} | {words} |"
        for cause, words in machine.CAUSES.items()
    ]
    return "\n".join(rows) + "\n"


def page(text: str) -> str:
    """The text of the page with its tables replaced."""
    begin, end = "<!-- tables -->\n", "<!-- end of tables -->\n"
    head, rest = text.split(begin)
    return head + begin + tables() + end + rest.split(end)[1]


def main() -> int:
    """Write or check both files."""
    text = PAGE.read_text(encoding="utf-8")
    wanted = {PICTURE: picture(), PAGE: page(text)}
    if "--check" not in sys.argv[1:]:
        for path, content in wanted.items():
            path.write_text(content, encoding="utf-8")
        return 0
    old = [path.name for path, content in wanted.items() if path.read_text(encoding="utf-8") != content]
    for name in old:
        print(f"{name} is out of date: python tools/session_picture.py")
    return 1 if old else 0


if __name__ == "__main__":
    sys.exit(main())
