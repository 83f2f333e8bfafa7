"""Runs and data sets, simulated or real: one record type from either source."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .atomic import NEW, cannot_write, clear_rooms, left_rooms, utf8, write_bytes, write_files, write_text
    from .columns import FIXED, MOTION, NAMED, Column, column
    from .dataset import CAMPAIGN, CAMPAIGN_RUNS, JOURNAL, DataSet, read_dataset, read_truth, write_dataset
    from .documents import json_text, jsonable, parse_json, read_json
    from .files import read_bytes, read_text, run_name, stem
    from .folder import Kind, new_folder, refuse_loss, results_folder
    from .lock import Held, locked
    from .manifest import FILE, DataSetWarning, Manifest, current_versions, manifest_text, sha256
    from .reader import read_run
    from .rules import PAUSE_S, content_fault
    from .run import INPUTS, OUTPUTS, TIME, Run
    from .table import GREATEST, Table, open_table
    from .toml import find_file, line_of, meant, parse, shown
    from .writer import DECIMALS, run_bytes, write_run

__all__ = facade(__name__)
