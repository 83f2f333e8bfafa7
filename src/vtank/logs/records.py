"""Records of logs: found again after damage, decompressed as far as they go, never larger than their file."""

from __future__ import annotations

import bz2
import re
from collections.abc import Callable
from typing import BinaryIO

from .log import library

BLOCK = 2**16  # bytes that are searched at once; a choice
LARGE = 2**20  # bytes; a record that claims more is held against the end of the file; a choice


def read_up_to(file: BinaryIO, size: int) -> bytes:
    """As many bytes, or what is left: a size that is damaged asks for no memory."""
    if size > LARGE:
        here = file.tell()
        size = min(size, file.seek(0, 2) - here)
        file.seek(here)
    return file.read(size)


def next_mark(file: BinaryIO, marks: re.Pattern[bytes], start: int) -> int | None:
    """Where bytes that begin a record come next, from a place on; None where none come. Two bytes at most."""
    file.seek(start)
    while block := file.read(BLOCK):
        if found := marks.search(block):
            return start + found.start()
        if len(block) == 1:
            return None
        start += len(block) - 1
        file.seek(start)
    return None


def decompressed(data: bytes, method: str) -> bytes:
    """The bytes of a chunk, fewer where it is cut off; ValueError for a method that is not known, or broken data."""
    if method in ("", "none"):
        return data
    open_by: dict[str, Callable[[], object]] = {"bz2": bz2.BZ2Decompressor, "lz4": _lz4, "zstd": _zstd}
    if method not in open_by:
        raise ValueError(f"compression '{method}' is not known")
    try:
        return bytes(open_by[method]().decompress(data))  # type: ignore[attr-defined]
    except (OSError, RuntimeError, EOFError) as error:
        raise ValueError(str(error)) from None


def _lz4() -> object:
    return library("lz4.frame", "lz4", "a chunk in LZ4").LZ4FrameDecompressor()


def _zstd() -> object:
    module = library("zstandard", "zstandard", "a chunk in Zstandard")
    opened = module.ZstdDecompressor().decompressobj()

    class Decompressor:
        def decompress(self, data: bytes) -> bytes:
            try:
                return bytes(opened.decompress(data))
            except module.ZstdError as error:
                raise ValueError(str(error)) from None

    return Decompressor()
