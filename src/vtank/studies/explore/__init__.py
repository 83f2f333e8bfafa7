"""The scientist's loop: plan the run that lowers the doubt most, fly it, diagnose all so far, and stop when decided."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .candidates import Candidate, candidates
    from .loop import Doubt, Explored, answer_of, explore
    from .planner import Plan, Planner
    from .sealed import SealedTank
    from .words import advice, document, told

__all__ = facade(__name__)
