"""Runs and data sets, simulated or real: one record type from either source."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .atomic import new_folder, write_bytes, write_text
    from .dataset import DataSet, read_dataset, read_truth, write_dataset
    from .manifest import FILE, DataSetWarning, Manifest, current_versions, manifest_text, read_json, sha256
    from .quantity import find_file
    from .reader import read_run
    from .rules import content_fault
    from .run import INPUTS, OUTPUTS, TIME, Run
    from .section import Section, line_of, meant, open_section
    from .writer import DECIMALS, run_bytes, write_run

__all__ = facade(__name__)
