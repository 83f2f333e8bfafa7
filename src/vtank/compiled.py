"""Numba compilation shared by every law: one decorator, and a cache that cannot go stale.

Numba's on-disk cache looks only at the file that holds a function, not at the files it calls into, so a changed
effect would leave the cached equation of motion as it was. `law` therefore compares the package's sources with
those that filled the cache and empties it when they differ. The first call of a law after that compiles it
(seconds, once); a one-line notice says so on an interactive terminal.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba

PACKAGE = Path(__file__).parent
STAMP = PACKAGE / "__pycache__" / "compiled-laws.sha256"


def law(function: Callable[..., Any]) -> Any:
    """Compile a scalar physical law or a kernel of such laws with numba (nopython, cached on disk, GIL released).

    IEEE arithmetic is kept (no fastmath), so that a null effect changes nothing, bit for bit.
    """
    return numba.njit(cache=True, nogil=True, error_model="numpy")(function)


def _sources_digest() -> str:
    """Digest of every file beside a compiled law: slot numbers and constants are baked into the machine code too."""
    digest = hashlib.sha256(numba.__version__.encode())
    sources = {path: path.read_bytes() for path in sorted(PACKAGE.rglob("*.py"))}
    compiled = {path.parent for path, text in sources.items() if b"compiled import" in text}
    for path, text in sources.items():
        if path.parent in compiled:
            digest.update(text)
    return digest.hexdigest()


def _refresh_cache() -> None:
    """Empty the compile cache when the laws' sources have changed; leave it alone where it cannot be written."""
    digest = _sources_digest()
    try:
        if STAMP.exists() and STAMP.read_text() == digest:
            return
        for pattern in ("*.nbi", "*.nbc"):
            for stale in PACKAGE.rglob(pattern):
                stale.unlink(missing_ok=True)
        STAMP.parent.mkdir(exist_ok=True)
        STAMP.write_text(digest)
    except OSError:
        return
    if sys.stderr.isatty():
        print("vtank: compiling the equations of motion (once, up to a minute) ...", file=sys.stderr)


_refresh_cache()
