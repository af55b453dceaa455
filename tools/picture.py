"""Makes the README's picture: the shipped scene in the middle of a stroke, as the viewer shows it.

    uv run --group test python tools/picture.py [--scene SCENE.yaml] [--at SECONDS] [--out FILE.png]

Runs the scene in lockstep up to the instant, opens the replay viewer and photographs it with headless Chromium.
"""

from __future__ import annotations

import argparse
import shutil
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

from palpate import Scene, Session
from palpate.record.ticks import as_ticks
from palpate.viewer import ReplayViewer, stage_of

FLAGS = ["--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
CONSOLE = 284
"""Width of the replay panel, which is cropped from the picture [px]."""
HIDE = ".mantine-Notification-root, .mantine-Notifications-root { display: none !important }"


def photograph(url: str, out: Path, size: tuple[int, int]) -> None:
    """Save a screenshot of the page at `url`; `size` is its width and height [px]."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("no Chromium found (Debian: apt-get install chromium)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS)
        page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        page.goto(url, timeout=90_000)
        page.wait_for_selector("#palpate-force", timeout=90_000)
        page.add_style_tag(content=HIDE)
        time.sleep(8.0)  # software rendering is slow
        out.parent.mkdir(parents=True, exist_ok=True)
        clip = {"x": 0, "y": 0, "width": size[0] - CONSOLE, "height": size[1]}
        page.screenshot(path=out, clip=clip, timeout=90_000)
        browser.close()


def main() -> None:
    """Run the scene, show the instant, take the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="scenes/palpation.yaml")
    parser.add_argument("--at", type=float, default=4.6, help="instant of the picture [s]")
    parser.add_argument("--out", type=Path, default=Path("docs/images/palpation.png"))
    parser.add_argument("--size", type=int, nargs=2, default=(1720, 860), help="width and height of the page [px]")
    args = parser.parse_args()
    session = Session(Scene.load(args.scene))
    ticks = as_ticks(session.rig.simulation(session.seed).run(round(args.at * session.rate) + 1))
    viewer = ReplayViewer(ticks, stage_of(session.rig, "Palpation"), port=0)
    viewer.show_at(args.at)
    photograph(viewer.url, args.out, tuple(args.size))
    viewer.close()
    print(args.out)


if __name__ == "__main__":
    main()
