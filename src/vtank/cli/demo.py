"""`vtank demo`: the four experiments, their identification and the paper's tables and figures, end to end."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from .checks import at_least
from .reproduce import DEFAULT_SEED, TRUTHS

if TYPE_CHECKING:
    from ..experiment import Result
    from ..present.blocks import Block


@dataclass
class Demo:
    """What the steps share and leave: where to write, what was flown, and what the last page will say."""

    out: Path
    seed: int
    flights: dict[str, list[Result]] = field(default_factory=dict)
    page: list[Block] = field(default_factory=list)
    links: list[tuple[str, str]] = field(default_factory=list)


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `demo [--out DIR] [--seed N]`."""
    text = "simulate the paper's experiments, identify Models I to III and compare with the truth (about two minutes)"
    parser = subparsers.add_parser("demo", help=text, description=text)
    parser.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="folder to write (default: out)")
    parser.add_argument("--seed", type=int, default=DEFAULT_SEED, metavar="N", help="seed of all noise")


def run(args: argparse.Namespace) -> int:
    """Take the steps, then say what was made, what it says and where to look."""
    from ..present.blocks import Heading, Links
    from ..present.document import html, markdown, plain
    from ..record.folder import Kind, results_folder

    at_least(0, seed=args.seed)
    start, kind = time.monotonic(), Kind("what vtank demo makes", "demo.json", "vtank.demo/1")
    with results_folder(args.out, kind, {"seed": args.seed}) as folder:
        demo = Demo(folder, args.seed)
        for step in STEPS:
            step(demo)
        page = [Heading("vtank demo", 1), *demo.page, Heading("What was made"), Links(tuple(demo.links))]
        (folder / "index.html").write_text(html("vtank demo", page), encoding="utf-8")
        (folder / "index.md").write_text(markdown(page), encoding="utf-8")
    print("\n" + plain(*page))
    print(f"\nMade in {time.monotonic() - start:.0f} s in {args.out}: start at {args.out / 'index.html'}")
    return 0


# --- the steps, in order -------------------------------------------------------------------------------------------


def fly_experiments(demo: Demo) -> None:
    """Data sets of the four experiments with each truth, through the tank."""
    from ..studies.paper.run import fly, write_flights
    from .progress import percent

    with percent("simulating the experiments") as report:
        demo.flights = fly(TRUTHS, demo.seed, report)
    write_flights(demo.out / "data", demo.flights)
    told = "data set of the four experiments, truth {} (told in truth.json alone)"
    demo.links += [(f"data/{truth}", told.format(truth)) for truth in TRUTHS]


def picture_tank(demo: Demo) -> None:
    """A picture of vehicle and tank."""
    from ..present.blocks import Picture
    from ..tank.render import picture
    from ..tank.world import load_model

    how = picture(demo.out / "tank.png", load_model())
    demo.page.append(Picture("tank.png", "The Phoenix in the virtual tank, ten feet from the wall ahead."))
    demo.links.append(("tank.png", f"the Phoenix in the tank, {how}"))


def identify_and_reproduce(demo: Demo) -> None:
    """Models I to III identified and compared with the truth; the paper's tables and figures; a brief study."""
    from ..present.blocks import Heading, Paragraph
    from ..record.folder import results_folder
    from ..studies.paper.findings import summary
    from ..studies.paper.overview import overview
    from ..studies.paper.run import BRIEF, FULL, REPRODUCTION, reproduce
    from .progress import progress

    about = {"seed": demo.seed, "truths": list(TRUTHS), "quick": True}
    with results_folder(demo.out / "reproduction", REPRODUCTION, about) as folder:
        results = reproduce(folder, demo.flights, demo.seed, BRIEF, progress)
    brief = f"From a brief study, in {BRIEF.worlds} worlds; vtank reproduce takes {FULL.worlds}."
    demo.page += [Heading("Identified and true (feet, as in the paper)"), overview(results.campaigns)]
    demo.page += [Heading("The paper's estimator"), Paragraph(f"{summary(results)} {brief}")]
    told = "findings, study, and Tables 1 to 4 and Figures 1 to 12 of each truth"
    demo.links.append(("reproduction/index.html", told))


def diagnose_blind_case(demo: Demo) -> None:
    """A case with a withheld effect, its diagnosis and report, and only then the truth."""
    import io
    import json
    from contextlib import redirect_stdout

    from ..errors import InputError
    from ..present.blocks import Heading, Paragraph
    from ..present.words import hypothesis, percent
    from . import main

    blind, truth = demo.out / "blind", demo.out / "blind-truth"
    report, found = demo.out / "diagnosis.html", demo.out / "diagnosis.json"
    make = ["blind", "make", "--trials", "1", "--seed", str(demo.seed), "--kinds", "single", "--no-separations"]
    diagnose = ["diagnose", str(blind / "case_0001"), "--report", str(report), "--json", str(found)]
    print("\nA blind case: four runs in the tank with an effect that the diagnosis is not told.\n")
    with redirect_stdout(io.StringIO()):  # it tells where it writes, a folder that gets its name at the end
        failed = main([*make, "--out", str(blind), "--truth-out", str(truth)])
    if failed or main(diagnose):
        raise InputError(f"the blind case of seed {demo.seed} failed")
    sealed = json.loads((truth / "case_0001.json").read_text(encoding="utf-8"))["truth"]
    verdict = json.loads(found.read_text(encoding="utf-8"))["verdict"]
    said, true = (hypothesis(name) for name in ("+".join(verdict["effects"]) or verdict["kind"], sealed["label"]))
    line = f"The diagnosis says {said} ({percent(verdict['probability'])}); the sealed truth is {true}."
    demo.page += [Heading("A blind case: four runs in the tank with an effect withheld"), Paragraph(line)]
    demo.links.append(("diagnosis.html", "the diagnosis of the blind case; runs in blind/, truth in blind-truth/"))


STEPS: tuple[Callable[[Demo], None], ...] = (
    diagnose_blind_case,
    fly_experiments,
    picture_tank,
    identify_and_reproduce,
)
