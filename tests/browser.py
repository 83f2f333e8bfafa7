"""A headless browser for the report's tests; None where there is none."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
QUIET = ("--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
         "--disable-sync", "--no-first-run", "--hide-scrollbars", "--enable-logging=stderr",
         "--host-resolver-rules=MAP * ~NOTFOUND")  # fmt: skip


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
