"""Logs of vehicles, middleware and spreadsheets as runs, and what can be decided from a recording."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .decidable import Decidable, decidable
    from .importing import Imported, import_log
    from .mapping import Mapping, read_mapping

__all__ = facade(__name__)
