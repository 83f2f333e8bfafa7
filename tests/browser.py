"""A headless browser for the tests of pages; None where there is none."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import numpy as np
from matplotlib.image import imread

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
QUIET = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--no-first-run", "--hide-scrollbars", "--enable-logging=stderr",
         "--host-resolver-rules=MAP * ~NOTFOUND")  # fmt: skip


@cache
def find_browser() -> str | None:
    """Path of a Chromium that starts, or None; VTANK_BROWSER names another one."""
    names = [os.environ["VTANK_BROWSER"]] if "VTANK_BROWSER" in os.environ else NAMES
    for name in names:
        path = shutil.which(name)
        if path and subprocess.run([path, "--version"], capture_output=True, check=False).returncode == 0:
            return path
    return None


def open_page(browser: str, profile: Path, page: Path, *options: str) -> tuple[str, list[str]]:
    """What the browser prints, and the messages of the page's console."""
    command = [browser, *QUIET, f"--user-data-dir={profile}", *options, page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=90, check=True)
    return done.stdout, [line for line in done.stderr.splitlines() if "CONSOLE" in line]


def overflow(browser: str, folder: Path, page: Path, width: int) -> tuple[int, list[str]]:
    """By how many pixels a page is wider than a window of that width, and what its console says.

    `folder` is for the browser's own.
    """
    probe = page.with_name(f"probe-{page.name}")
    tell = "parent.postMessage(document.documentElement.scrollWidth - document.documentElement.clientWidth, '*')"
    told = page.read_text(encoding="utf-8").replace("</body>", f"<script>{tell}</script></body>")
    probe.write_text(told, encoding="utf-8")
    listen = "onmessage = message => { document.title = 'overflow ' + message.data }"
    outer = framed(probe, width, f"<title></title><script>{listen}</script>")
    try:
        printed, console = open_page(browser, folder / "profile", outer, "--dump-dom", "--virtual-time-budget=3000")
    finally:
        probe.unlink()
        outer.unlink()
    return int(re.findall(r"<title>overflow (-?\d+)</title>", printed)[0]), console


def shot(browser: str, folder: Path, page: Path, width: int) -> np.ndarray:
    """The top of a page in a window of that width and 900 pixels high, shape (900, width, 3) [0 to 1]."""
    outer, picture = framed(page, width, "<style>* { margin: 0; border: 0 }</style>"), folder / "shot.png"
    try:
        open_page(browser, folder / "profile", outer, f"--screenshot={picture}", f"--window-size={max(width, 600)},900")
    finally:
        outer.unlink()
    return np.asarray(imread(picture)[:, :width, :3])


def framed(page: Path, width: int, head: str) -> Path:
    """A page beside another, which shows it in a frame: no window of a browser gets as narrow as a telephone."""
    outer = page.with_name(f"frame-{page.name}")
    frame = f'<iframe src="{page.name}" style="width: {width}px; height: 900px"></iframe>'
    outer.write_text(f"{head}{frame}", encoding="utf-8")
    return outer
