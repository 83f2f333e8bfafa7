"""Logs of vehicles, middleware and spreadsheets as runs, and what can be decided from a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .decidable import Decidable, decidable
    from .importing import Imported, import_log
    from .map_file import read_mapping
    from .mapping import Mapping

__all__ = facade(__name__)
