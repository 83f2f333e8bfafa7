"""Installs compiled callbacks in MuJoCo, where they belong to the whole process, and takes them out again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import mujoco

from ..errors import InputError
from .control import callback

Make = Callable[[], dict[str, Any]]  # the callbacks by kind, such as "control" for mjcb_control; the same at every call

_lock = Lock()
_users: Counter[str] = Counter()


def present(kind: str) -> Any:
    """MuJoCo's callback of a kind; None where there is none."""
    return getattr(mujoco, f"get_mjcb_{kind}")()


def _put(kind: str, function: Any) -> None:
    getattr(mujoco, f"set_mjcb_{kind}")(function)


@contextmanager
def installed(make: Make) -> Iterator[None]:
    """While this context lasts, MuJoCo calls these callbacks; InputError where another program's is there.

    Contexts may be nested, and end in any order and thread: the last one removes the callbacks, unless somebody else
    has put his there.
    """
    with _lock:  # compiles, and keeps what was compiled, only once
        callbacks = make()
        for kind, ours in callbacks.items():
            if (found := present(kind)) is not None and found is not ours:
                raise InputError(
                    f"MuJoCo's {kind} callback is taken by {found!r}; "
                    f"expected none: call mujoco.set_mjcb_{kind}(None) before stepping in water"
                )
        for kind, ours in callbacks.items():
            _put(kind, ours)
            _users[kind] += 1
    try:
        yield
    finally:
        with _lock:
            for kind, ours in callbacks.items():
                _users[kind] -= 1
                if _users[kind] == 0 and present(kind) is ours:
                    _put(kind, None)


def _water() -> dict[str, Any]:
    return {"control": callback()}


def forces() -> Any:
    """A context in which every model with wet bodies feels the water, however it is stepped; others step as ever.

    Contexts may be nested. Raises InputError where MuJoCo's control callback is taken.
    """
    return installed(_water)
