"""Where the models and the scenarios lie: beside the package in a wheel, at the top of the repository in a checkout."""

from __future__ import annotations

import functools
from pathlib import Path

from .errors import InputError

NOMINAL = "paper-ii"  # truth preset that is the simulator where none is named
TRUTHS = ("paper-ii", "paper-iii", "physical")  # presets that the paper's study is made with
_PACKAGE = Path(__file__).resolve().parent
_CHECKOUT = _PACKAGE.parents[1]


def models_dir() -> Path:
    """Folder of the MJCF models, vehicle files and truth presets."""
    return _folder("models")


def scenarios_dir() -> Path:
    """Folder of the scenarios that come with vtank."""
    return _folder("scenarios")


@functools.cache
def _folder(name: str) -> Path:
    for parent in (_PACKAGE, _CHECKOUT):
        if (parent / name).is_dir():
            return parent / name
    raise InputError(
        f"the folder '{name}' of vtank is missing: looked in {_PACKAGE} and {_CHECKOUT}; install vtank again"
    )
