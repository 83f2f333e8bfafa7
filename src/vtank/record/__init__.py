"""Runs and data sets, simulated or real: one record type from either source."""

from __future__ import annotations

from .dataset import DataSet, read_dataset, read_truth, write_dataset
from .manifest import DataSetWarning, Manifest
from .reader import read_run
from .run import INPUTS, OUTPUTS, Run
from .writer import write_run

__all__ = [
    "INPUTS",
    "OUTPUTS",
    "DataSet",
    "DataSetWarning",
    "Manifest",
    "Run",
    "read_dataset",
    "read_run",
    "read_truth",
    "write_dataset",
    "write_run",
]
