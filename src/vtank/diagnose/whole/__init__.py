"""Diagnosis of a whole vehicle: which effect at which axis, thruster or sensor parts recordings from its simulator."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .diagnosis import WholeDiagnosis, diagnose
    from .foreseen import Foreseen, Hypothesis, drop_of_doubt, fitted, foreseen, own_numbers, possible
    from .model_file import model_text, slots_of
    from .oracle import Known, free_gap, known_fits

__all__ = facade(__name__)
