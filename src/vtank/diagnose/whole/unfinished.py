"""The steps of a long diagnosis, filed as they come, so that one which was interrupted goes on where it was.

A step is found again by the digest of all that goes into it: what has changed since is worked out anew. One line of
JSON each, appended whole, in the folder of the machine code; the file goes when the diagnosis is done.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from hashlib import blake2b
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from ... import compiled

T = TypeVar("T")
FILED: ContextVar[Filed | None] = ContextVar("FILED", default=None)


class Filed:
    """Steps by their digests, and the file in which they are."""

    def __init__(self, path: Path) -> None:
        self.path, self.steps = path, dict[str, Any]()
        with suppress(OSError):
            for line in path.read_text(encoding="utf-8").splitlines():
                with suppress(ValueError, TypeError):  # a line cut off by a kill
                    key, result = json.loads(line)
                    self.steps[key] = result

    def add(self, key: str, result: Any) -> None:
        """File a step; where nothing can be written the diagnosis goes on without."""
        self.steps[key] = result
        with suppress(OSError), open(self.path, "a", encoding="utf-8") as file:
            file.write(json.dumps([key, result]) + "\n")


@contextmanager
def filed(*told: object) -> Iterator[None]:
    """Steps within the block are filed, under what is told of it (texts, numbers, arrays); gone unless interrupted."""
    folder = compiled.FOLDER / "unfinished"
    with suppress(OSError):
        folder.mkdir(exist_ok=True)
    sources = [path.read_bytes() for path in sorted(compiled.PACKAGE.rglob("*.py"))]
    path = folder / f"{digest([*sources, *told])}.jsonl"
    token = FILED.set(Filed(path))
    try:
        yield
    except KeyboardInterrupt:
        raise
    except BaseException:
        path.unlink(missing_ok=True)
        raise
    else:
        path.unlink(missing_ok=True)
    finally:
        FILED.reset(token)


def step(told: Callable[[], str], make: Callable[[], T], plain: Callable[[T], Any], again: Callable[[Any], T]) -> T:
    """What `make` returns, or what it returned before; told: digest of all that goes into it.

    plain: as data of JSON, which gives floats back to the last bit. again: from these.
    """
    book = FILED.get()
    if book is None:
        return make()
    key = told()
    if key in book.steps:
        return again(book.steps[key])
    result = make()
    book.add(key, plain(result))
    return result


def digest(told: Iterable[object]) -> str:
    """Of texts, bytes, numbers and arrays."""
    found = blake2b(digest_size=16)
    for part in told:
        data = np.ascontiguousarray(part).tobytes() if isinstance(part, np.ndarray) else part
        data = data if isinstance(data, bytes) else repr(data).encode()
        found.update(len(data).to_bytes(8, "little") + data)
    return found.hexdigest()
