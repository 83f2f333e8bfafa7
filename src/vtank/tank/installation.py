"""Installs the compiled callback in MuJoCo, where callbacks belong to the whole process, and takes it out again."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock

import mujoco

from .callbacks import callback

_lock = Lock()
_users = 0


def installed() -> bool:
    """Whether MuJoCo calls our callback now."""
    return mujoco.get_mjcb_control() is callback()


def install() -> None:
    """Install the callback, or count one more user of it; RuntimeError when another program's callback is there."""
    global _users
    with _lock:
        present = mujoco.get_mjcb_control()
        if present is not None and present is not callback():
            raise RuntimeError(
                f"MuJoCo's control callback is taken by {present!r}; "
                "call mujoco.set_mjcb_control(None) before using the tank"
            )
        mujoco.set_mjcb_control(callback())
        _users += 1


def uninstall() -> None:
    """Count one user less, and remove the callback with the last; one that somebody else has put there stays."""
    global _users
    with _lock:
        _users -= 1
        if _users == 0 and installed():
            mujoco.set_mjcb_control(None)


@contextmanager
def forces() -> Iterator[None]:
    """While this context lasts, every simulation that was prepared (`prepare`, `Tank`) feels the water.

    Contexts may be nested; models that are not ours step as ever.
    """
    install()
    try:
        yield
    finally:
        uninstall()
