"""Installs compiled callbacks in MuJoCo, where they belong to the whole process, and takes them out again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

import mujoco

from ..errors import InputError
from .control import callback

_lock = Lock()
_users: Counter[str] = Counter()


def present(kind: str) -> Any:
    """MuJoCo's callback of a kind, such as "control" for mjcb_control; None where there is none."""
    return getattr(mujoco, f"get_mjcb_{kind}")()


def _put(kind: str, function: Any) -> None:
    getattr(mujoco, f"set_mjcb_{kind}")(function)


def install(callbacks: dict[str, Any]) -> None:
    """Install callbacks by kind, or count one more user of them; InputError where another program's is there."""
    with _lock:
        for kind, ours in callbacks.items():
            if (found := present(kind)) is not None and found is not ours:
                raise InputError(
                    f"MuJoCo's {kind} callback is taken by {found!r}; "
                    f"expected none: call mujoco.set_mjcb_{kind}(None) before stepping in water"
                )
        for kind, ours in callbacks.items():
            _put(kind, ours)
            _users[kind] += 1


def uninstall(callbacks: dict[str, Any]) -> None:
    """Count one user less, and remove the callbacks with the last; those that somebody else has put there stay."""
    with _lock:
        for kind, ours in callbacks.items():
            _users[kind] -= 1
            if _users[kind] == 0 and present(kind) is ours:
                _put(kind, None)


@contextmanager
def forces() -> Iterator[None]:
    """While this context lasts, every model with wet bodies feels the water, however it is stepped.

    Contexts may be nested; other models step as ever. Raises InputError where MuJoCo's control callback is taken.
    """
    ours = {"control": callback()}
    install(ours)
    try:
        yield
    finally:
        uninstall(ours)
