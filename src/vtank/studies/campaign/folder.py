"""What spans all runs in a folder of CSV files: the table runs.csv and the manifest, written as a stream."""

from __future__ import annotations

import csv
import json
from textwrap import indent
from typing import Any

from ...record import FILE, Manifest, manifest_text
from .campaign import Campaign
from .journal import DATA, ROWS, Journal, whole
from .table import FAILED, Row, cell, columns

NO_RUNS = "[]"


def write_folder(journal: Journal, campaign: Campaign) -> int:
    """Write data/manifest.json and runs.csv; returns the number of failed runs."""
    head, tail = manifest_text(Manifest()).rsplit(NO_RUNS, 1)  # campaign.json holds all files, which tell the truth
    with whole(journal.out / DATA / FILE) as file:
        file.write(head)
        lead = "[\n"
        for row in journal.rows():
            if "sha256" in row:
                file.write(lead + entry(row))
                lead = ",\n"
        file.write((NO_RUNS if lead == "[\n" else "\n  ]") + tail)
    return write_table(journal, campaign)


def entry(row: Row) -> str:
    """One run in the manifest, as `record.manifest` writes it."""
    run: dict[str, Any] = {"file": f"{row['run']}.csv", "sha256": row["sha256"], "rows": row["samples"]}
    return indent(json.dumps(run, indent=2), "    ")


def write_table(journal: Journal, campaign: Campaign) -> int:
    """Write runs.csv; returns the number of failed runs."""
    names, failed = columns(campaign), 0
    with whole(journal.out / ROWS) as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        for row in journal.rows():
            failed += row["status"] == FAILED
            writer.writerow([cell(row.get(name)) for name in names])
    return failed
