"""Before the tank is booked: what a plan of experiments can tell, how well the estimators use it, and a better plan."""

from __future__ import annotations

from ...record.folder import Kind

RESULTS = Kind("results of vtank identifiability", "identifiability.json", "vtank-identifiability-1")
PLAN = Kind("a plan of vtank identifiability", "plan.json", "vtank.plan/1")
