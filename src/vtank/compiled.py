"""Numba compilation shared by every law and kernel: one decorator, and a cache that cannot go stale.

Numba's on-disk cache looks only at the file that holds a function, not at the files it calls into, and slot numbers and
constants are baked into the machine code: a changed effect would leave the cached equation of motion as it was. The
cache therefore lies in a folder of its own that is named after the digest of every source it depends on, of numba and
of MuJoCo: code that is older than its law is never found. It is a folder of the user's (VTANK_CACHE_DIR,
NUMBA_CACHE_DIR or XDG_CACHE_HOME, else ~/.cache); nothing is written or deleted inside the installed package.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from types import FunctionType
from typing import Any

import numba

PACKAGE = Path(__file__).parent
OPTIONS = {"nogil": True, "error_model": "numpy"}  # IEEE arithmetic is kept: a null effect changes nothing, bit for bit
BORROWED = {"_nrt": False}  # no array is made, so none is counted: half the time of a function of a few hundred flops
FORGOTTEN_S = 30 * 86400.0  # [s] machine code of other versions that nobody has used for so long is cleared away


def law(function: Callable[..., Any]) -> Any:
    """Compile a physical law, or a kernel of such laws, with numba (nopython, cached on disk, GIL released)."""
    with cache_folder():
        return numba.njit(cache=True, **OPTIONS)(function)


def lean(function: Callable[..., Any]) -> Any:
    """As `law`, of a function that makes no array: it works on those that its caller holds. Numba refuses any other."""
    with cache_folder():
        return numba.njit(cache=True, **OPTIONS, **BORROWED)(function)


def term(function: Callable[..., Any]) -> Any:
    """As `law`, but merged into its caller, where a call would cost more than the few operations in it."""
    return numba.njit(forceinline=True, **OPTIONS)(function)


def bind(template: Callable[..., Any], name: str, laws: Mapping[str, Any], make: Callable[..., Any] = law) -> Any:
    """Compile a copy of `template` in which the names of `laws` mean these: how a kernel is made for a plant.

    name: of the copy, one for every set of laws, since the cache is found by it; make: `law` or `term`.
    """
    assert isinstance(template, FunctionType)
    copy = FunctionType(template.__code__, {**template.__globals__, **laws}, name, template.__defaults__)
    copy.__qualname__, copy.__module__ = name, template.__module__
    return make(copy)


@contextmanager
def cache_folder() -> Iterator[None]:
    """While a function is decorated, numba's cache is the folder of these sources."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(FOLDER)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def digest() -> str:
    """Digest of every file beside a compiled law, of numba and of MuJoCo, in hexadecimal."""
    found = hashlib.sha256(f"{sys.version}{numba.__version__}{version('mujoco')}".encode())
    sources = {path: path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))}
    compiled = {path.parent for path, text in sources.items() if b"compiled import" in text}
    for path, text in sources.items():
        if path.parent in compiled:
            found.update(path.relative_to(PACKAGE).as_posix().encode() + b"\0" + text)
    return found.hexdigest()[:32]


def _folder() -> Path:
    """The cache folder of these sources, made where it does not exist; one that goes with the process if it must."""
    given = os.environ.get("VTANK_CACHE_DIR") or os.environ.get("NUMBA_CACHE_DIR")
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    root = (Path(given) if given else home) / "vtank"
    try:
        (root / digest()).mkdir(parents=True, exist_ok=True)
        os.utime(root / digest())
        if not os.access(root / digest(), os.W_OK):
            raise PermissionError
        _forget(root)
        return root / digest()
    except OSError:
        return Path(tempfile.mkdtemp(prefix="vtank-"))


def _forget(root: Path) -> None:
    """Clear away folders of other digests that nobody has used for a month."""
    for other in root.iterdir():
        ours = len(other.name) == 32 and set(other.name) <= set("0123456789abcdef")
        if ours and time.time() - other.stat().st_mtime > FORGOTTEN_S:
            shutil.rmtree(other, ignore_errors=True)


FOLDER = _folder()
if not any(FOLDER.rglob("*.nbi")) and sys.stderr.isatty():
    print("vtank: compiling the equations of motion (once, a minute or two) ...", file=sys.stderr)
