"""The report of a diagnosis as one HTML file: nothing is loaded from anywhere, and a policy in the file forbids it."""

from __future__ import annotations

import json

from ..diagnose.diagnosis import Diagnosis
from ..diagnose.sizes import own_parameters
from .blocks import Details
from .document import html
from .sections import sections
from .words import Document

MOST_NAMES = 6  # runs named in the title


def report_html(diagnosis: Diagnosis, document: Document) -> str:
    """The report as HTML; parts that the document lacks (shrink, next_experiment) are said to be missing."""
    numbers = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    told = sections(
        {"parameters": own_parameters(diagnosis.selection, diagnosis.verdict, diagnosis.mass_kg)} | document,
        diagnosis.where,
    )
    return html(title(diagnosis), [*told, Details("All numbers (JSON)", numbers)], f"seed {diagnosis.seed}")


def title(diagnosis: Diagnosis) -> str:
    """What was diagnosed."""
    names = [run.name for run in diagnosis.selection.setting.runs]
    shown = ", ".join(names[:MOST_NAMES]) + (", \N{HORIZONTAL ELLIPSIS}" if len(names) > MOST_NAMES else "")
    return f"Gap diagnosis of {len(names)} run{'s' * (len(names) > 1)}: {shown}"
