"""Records of logs: found again after damage, decompressed as far as they go, none larger than is stated here."""

from __future__ import annotations

import bz2
import re
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

from .log import library

LEAST, BLOCK = 2**12, 2**20  # bytes that are searched at once: at first, doubled up to the last; choices
LARGE = 2**20  # bytes; a record that claims more is held against the end of the file; a choice
CHUNK_BYTES = 2**28  # of a record, or a chunk when it is decompressed: 256 MB, far above any picture's; a choice
TIMES = 100  # the size of a file that all its chunks hold together, beside one of the largest; a choice
TOO_MUCH = (
    f"holds too much: expected {CHUNK_BYTES >> 20} MB at most, and {TIMES} times the size of the file in all chunks"
)


class CutOff(Exception):
    """A log ends in the middle of a record, or holds none from here on."""

    def __init__(self, what: str = "it ends within a record") -> None:
        """`what` is told of the log."""
        super().__init__(what)


def read_up_to(file: BinaryIO, size: int) -> bytes:
    """As many bytes, or what is left: a size that is damaged asks for no memory. CutOff above CHUNK_BYTES."""
    if size > LARGE:
        here = file.tell()
        size = min(size, file.seek(0, 2) - here)
        file.seek(here)
    if size > CHUNK_BYTES:
        raise CutOff(f"a record of {size >> 20} MB, expected {CHUNK_BYTES >> 20} MB at most")
    return file.read(size)


def next_mark(file: BinaryIO, marks: re.Pattern[bytes], start: int) -> int | None:
    """Where bytes that begin a record come next, from a place on; None where none come. Two bytes at most, not zero."""
    file.seek(start)
    size = LEAST
    while block := file.read(size):
        blank = block == bytes(len(block))  # quicker than a search: a log may have gigabytes of them
        if not blank and (found := marks.search(block)):
            return start + found.start()
        if len(block) == 1:
            return None
        start += len(block) - 1
        file.seek(start)
        size = min(2 * size, BLOCK)
    return None


class Chunks:
    """Opens the chunks of one file, which may hold CHUNK_BYTES each, and together TIMES the size of the file more."""

    def __init__(self, path: Path) -> None:
        """None opened yet."""
        self.left = CHUNK_BYTES + TIMES * path.stat().st_size

    def opened(self, data: bytes, method: str) -> bytes:
        """The bytes of a chunk, fewer where it is cut off; ValueError for an unknown method, broken data, too much."""
        if method in ("", "none"):
            return data
        if method not in METHODS:
            raise ValueError(f"compression '{method}' is not known")
        most = min(CHUNK_BYTES, self.left)
        try:
            found = METHODS[method](data, most + 1)
        except (OSError, RuntimeError, EOFError) as error:
            raise ValueError(str(error)) from None
        self.left = max(self.left - len(found), 0)
        if len(found) > most:
            raise ValueError(TOO_MUCH)
        return found


def _bz2(data: bytes, most: int) -> bytes:
    return bz2.BZ2Decompressor().decompress(data, most)


def _lz4(data: bytes, most: int) -> bytes:
    opened = library("lz4.frame", "lz4", "a chunk in LZ4").LZ4FrameDecompressor()
    return bytes(opened.decompress(data, most))


def _zstd(data: bytes, most: int) -> bytes:
    module = library("zstandard", "zstandard", "a chunk in Zstandard")
    try:
        return bytes(module.ZstdDecompressor().stream_reader(data).read(most))
    except module.ZstdError as error:
        raise ValueError(str(error)) from None


METHODS: dict[str, Callable[[bytes, int], bytes]] = {"bz2": _bz2, "lz4": _lz4, "zstd": _zstd}  # of bytes up to a size
