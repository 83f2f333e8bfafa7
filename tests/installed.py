"""An installed vtank, tried outside of the checkout and without a network: run by `make wheel-test`.

python tests/installed.py DIST...     each a wheel or a source package, into an empty environment of its own
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

OFFLINE = ("unshare", "--map-root-user", "--net")
COMMANDS = (
    "--version",
    "effects --json",
    "run paper-ds1 paper-ds4 --set duration_s=30 --set effects.linear_drag.c_per_s=0.1 --out data",
    "check-data data",
    "identify data --model II --method ml",
    "diagnose data --nominal paper-ii --report gap.html --model gap.toml",
    "predict gap.toml data/paper-ds1.csv",
    "import data/paper-ds1.csv --preview",
    "run whole/zigzag --set vehicle=remus100 --set duration_s=10 --out zigzag",
    "campaign own.toml --out many --threads 1",
    "view zigzag/zigzag.csv --vehicle remus100 --film zigzag.mp4",
    "explore zigzag --nominal remus100 --write-plan next.toml",
    "demo --out story",
)
CAMPAIGN = 'model = "surge"\nrepeats = 2\n[grid]\nscenario = ["paper-ds1"]\nduration_s = 5.0\n'
INSIDE = (
    "import vtank, vtank.resources as r, pathlib; here = pathlib.Path(vtank.__file__); "
    "assert 'site-packages' in here.parts, here; assert (r.models_dir() / 'phoenix.toml').is_file(); "
    "assert (r.scenarios_dir() / 'paper-ds1.toml').is_file(); assert (here.parent / 'py.typed').is_file()"
)


def offline() -> tuple[str, ...]:
    """What runs a command without a network; nothing where the system does not allow it, and it is said."""
    try:
        allowed = subprocess.run([*OFFLINE, "true"], capture_output=True, check=False).returncode == 0
    except OSError:
        allowed = False
    if not allowed:
        print("this system shuts off no network: tried with it")
    return OFFLINE if allowed else ()


def try_out(dist: Path) -> None:
    """Install it where nothing is, and run its commands in an empty folder."""
    with tempfile.TemporaryDirectory() as folder:
        home, work = Path(folder) / "env", Path(folder) / "work"
        venv.create(home, with_pip=True)
        work.mkdir()
        (work / "own.toml").write_text(CAMPAIGN)
        python = str(home / "bin" / "python")
        subprocess.run(
            [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", f"{dist}[film]"], check=True
        )
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VTANK"))}
        environment = kept | {"VTANK_CACHE_DIR": str(Path(folder) / "cache")}
        for words in (("-c", INSIDE), *(("-m", "vtank", *command.split()) for command in COMMANDS)):
            line = [*offline(), python, *words]
            done = subprocess.run(line, cwd=work, env=environment, capture_output=True, text=True, check=False)
            if done.returncode:
                sys.exit(f"{dist.name}: {' '.join(words)}: exit {done.returncode}\n{done.stdout}{done.stderr}")
        network = "without" if offline() else "with"
        print(f"{dist.name}: {len(COMMANDS)} commands in an empty environment, {network} a network")


if __name__ == "__main__":
    for name in sys.argv[1:]:
        try_out(Path(name).resolve())
