"""Before the tank is booked: what a plan of experiments can tell, how well the estimators use it, and a better plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...facade import facade

if TYPE_CHECKING:
    from .document import document
    from .examined import PLAN, RESULTS, examine, write_findings, write_plan
    from .findings import Findings
    from .montecarlo import monte_carlo, trials_sheet
    from .study import PAPER
    from .whole import WholeFindings, examine_whole, write_whole

__all__ = facade(__name__)
