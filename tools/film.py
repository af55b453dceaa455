"""Makes a film of two minutes, and a gallery of pictures, from the records of shipped scenes.

    .venv/bin/python tools/film.py [--out build/film] [--seconds 120] [--size 720 1280]

Each chapter is a run of a scene: what its endoscope sees, the force on the hand as a curve, and the command that
repeats it. The folder gets film.mp4 (H.264, 30 frames/s), a picture of each chapter, and index.html with the commands.
Nothing of it is kept in the repository. Pictures are drawn by OpenGL without a window, 40 ms of processor time each
without a graphics card. It needs the extras learning and report.
"""

from __future__ import annotations

import argparse
import html
import shutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib import font_manager
from PIL import Image, ImageDraw, ImageFont

from palpate import cli
from palpate.base.arrays import Array
from palpate.export.demonstration import demonstrations
from palpate.export.episode import episode_of
from palpate.export.video.drawing import Image as Picture
from palpate.export.video.film import Eye, Film, films

FPS = 30
SHARE = 0.78  # of the height that the picture takes; the rest is the curve
FONT = font_manager.findfont("DejaVu Sans")


@dataclass(frozen=True)
class Chapter:
    """A part of the film."""

    scene: str
    words: str
    seconds: float = 11.5
    """Length in the film of two minutes, and least simulated time [s]."""

    @property
    def command(self) -> str:
        """What a reader types to see it live."""
        return f"palpate run {self.scene}"


CHAPTERS = (
    Chapter("palpation", "A simulated hand presses an instrument into a liver and feels it"),
    Chapter("nodule", "A hard lump under the surface"),
    Chapter("breathing", "An organ that breathes, touched by the whole instrument"),
    Chapter("guided", "Guidance: a vessel that the tool cannot enter, a path that leads it"),
    Chapter("bilateral", "The force of simulated tissue by the drives' torques, without a sensor"),
    Chapter("solids", "Solids without a mesh"),
    Chapter("two_hands", "Two hands: one holds the organ, the other palpates it"),
    Chapter("soft_liver", "A liver that deforms", 12.5),
    Chapter("soft_nodule", "A hard lump in soft tissue", 12.0),
    Chapter("peg_transfer", "Things to hold: simulated operators lift and hand over what they feel", 15.0),
)


def main(out: Path, seconds: float, size: tuple[int, int], chapters: tuple[Chapter, ...] = CHAPTERS) -> Path:
    """Film every chapter and write the gallery; returns the film.

    Args:
        out: folder; new files replace those of an earlier film.
        seconds: length of the film [s].
        size: its height and width, even numbers [pixels].
        chapters: its parts, with their shares of the length.
    """
    out.mkdir(parents=True, exist_ok=True)
    whole = sum(chapter.seconds for chapter in chapters)
    rows = ["<!doctype html><meta charset='utf-8'><title>Palpate</title>",
            "<video src='film.mp4' controls width='960'></video>"]  # fmt: skip

    def frames() -> Iterator[dict[Eye, Picture]]:
        for chapter in chapters:
            length = seconds * chapter.seconds / whole
            picture = out / f"{chapter.scene}.png"
            number = 0
            for frame in film(chapter, length, size, out / "runs"):
                number += 1
                if number == max(1, round(2 / 3 * length * FPS)):
                    frame.save(picture)
                yield {"left": np.asarray(frame)}
            rows.append(f"<figure><img src='{picture.name}' width='640'><figcaption>{html.escape(chapter.words)}<br>"
                        f"<code>{html.escape(chapter.command)}</code></figcaption></figure>")  # fmt: skip
            print(f"{chapter.scene}: {number} frames", flush=True)

    draft = out / ".film.part.mp4"  # a film that is cut off is no film
    films(frames(), {"left": draft}, {"left": size}, FPS)
    draft.replace(out / "film.mp4")
    (out / "index.html").write_text("\n".join(rows), encoding="utf-8")
    return out / "film.mp4"


def film(chapter: Chapter, seconds: float, size: tuple[int, int], runs: Path) -> Iterator[Image.Image]:
    """Run the scene for at least the chapter's seconds, and yield `seconds` of it from its first contact on."""
    length = max(seconds, chapter.seconds)
    folder = runs / chapter.scene
    shutil.rmtree(folder, ignore_errors=True)
    command = ["run", chapter.scene, "--headless", "--seed", "1", "--duration", str(length), "--out", str(folder)]
    if cli.main(command):
        sys.exit(f"tools/film.py: palpate {' '.join(command)} failed")
    (run,) = demonstrations(sorted(folder.iterdir()))
    forces = [np.linalg.norm(arm.ticks["F_H_L"], axis=1) for arm in run.arms]
    force = max(forces, key=np.max)  # of several hands, the one that feels most
    t = np.asarray(run.arms[0].ticks["t"])
    touching = np.flatnonzero(force > 0.05)
    begin = min(max(0.0, t[touching[0]] - 1.0 if touching.size else 0.0), max(0.0, t[-1] - seconds))
    drawn = Film(run, (round(SHARE * size[0]), size[1]))
    try:
        episode = episode_of(run, FPS)
        last = round(seconds * FPS)
        for k, (now, pictures) in enumerate(zip(episode.arms[0].frames.t, drawn.pictures(episode), strict=False)):
            first = round(begin * FPS)
            if first <= k < first + last:
                yield compose(chapter, pictures["left"], t, force, float(now), begin, seconds, size)
    finally:
        drawn.close()


def compose(
    chapter: Chapter,
    picture: Array,
    t: Array,
    force: Array,
    now: float,
    begin: float,
    seconds: float,
    size: tuple[int, int],
) -> Image.Image:
    """A frame: the picture, its words and command, and below them the force on the hand up to now."""
    height, width = size
    frame = Image.new("RGB", (width, height), (18, 18, 22))
    frame.paste(Image.fromarray(np.ascontiguousarray(picture)), (0, 0))
    draw = ImageDraw.Draw(frame)
    large, small = (ImageFont.truetype(FONT, max(8, round(share * height))) for share in (0.036, 0.026))
    margin = round(0.02 * width)
    draw.text((margin, margin), chapter.words, font=large, fill="white", stroke_width=2, stroke_fill="black")
    draw.text(
        (margin, round(0.72 * height)), chapter.command, font=small, fill="white", stroke_width=2, stroke_fill="black"
    )
    seen = (t >= begin) & (t <= now)
    top, bottom, most = (SHARE + 0.06) * height, 0.97 * height, max(1.0, 1.1 * float(force.max()))
    x = margin + (width - 2 * margin) * (t[seen] - begin) / seconds
    y = bottom - (bottom - top) * force[seen] / most
    every = max(1, len(x) // width)
    draw.line([(margin, bottom), (width - margin, bottom)], fill=(90, 90, 90))
    draw.line(
        list(zip(x[::every].tolist(), y[::every].tolist(), strict=True)),
        fill=(255, 170, 60),
        width=max(1, height // 240),
    )
    text = f"force on the hand {force[seen][-1]:.2f} N" if seen.any() else ""
    draw.text((margin, round((SHARE + 0.012) * height)), text, font=small, fill=(255, 170, 60))
    return frame


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("build/film"), help="folder of the film")
    parser.add_argument("--seconds", type=float, default=120.0, help="length of the film [s]")
    parser.add_argument("--size", type=int, nargs=2, default=(720, 1280), help="height and width [pixels]")
    words = parser.parse_args()
    if words.seconds <= 0 or any(side < 64 or side % 2 for side in words.size):
        sys.exit("tools/film.py: --seconds must be positive, --size two even numbers from 64")
    print(main(words.out, words.seconds, tuple(words.size)))
