"""`vtank view`: a flight in MuJoCo's viewer or as a film, with the recording as a ghost beside the simulation."""

from __future__ import annotations

import argparse
from pathlib import Path


def add_parser(subparsers: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Declare `view SCENARIO|RUN`."""
    text = "look at a scenario as it is simulated, or at a recording beside the simulation of its own commands"
    parser = subparsers.add_parser("view", help=text, description=text)
    parser.add_argument(
        "flight", metavar="SCENARIO|RUN", help="name or .toml file of a scenario, or .csv file of a run"
    )
    parser.add_argument("--ghost", type=Path, metavar="RUN.csv", help="recording beside a scenario")
    parser.add_argument("--vehicle", metavar="VEHICLE", help="of a run: name or .toml file of the vehicle")
    parser.add_argument(
        "--truth",
        metavar="NAME",
        help="along one axis: truth preset, or path of one or of a diagnosed model, that flies",
    )
    parser.add_argument("--film", type=Path, metavar="OUT.mp4", help="write a film instead; needs no window")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="override a key of a scenario")


def run(args: argparse.Namespace) -> int:
    """Simulate, then show or film."""
    from ..tank.film import refuse_film, refuse_window
    from ..viewed import refuse_strange, view
    from .checks import check_outputs, refuse_unwritable
    from .progress import progress

    check_outputs(args, "film")
    refuse_strange(args.flight)
    refuse_unwritable(args.film)
    refuse_film(args.film) if args.film else refuse_window()
    with progress() as say:
        say(f"simulating {args.flight}")
        seen = view(args.flight, args.ghost, args.vehicle, args.set, args.truth)
        if args.film is None:
            say("until the window is closed")
            seen.show()
            return 0
        say(f"rendering {args.film}")
        how = seen.film(args.film)
    print(f"{args.film}: {how}")
    return 0
