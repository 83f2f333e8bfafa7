"""Simulation: plans flown in the MuJoCo tank or on the surge model, with the same pilot on board.

plans = [plan_run(load_scenario("paper-ds1"), run=i) for i in range(400)]
results = simulate_surge(plans)            # or simulate_tank(plans, nthread=2)
results[0].run, results[0].true            # what was recorded, what was true
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from . import flight, noise
    from .clearance import MARGIN_M, check_motion, clearances
    from .excitation import Excitation
    from .fly import fly, plan_all, write_results
    from .plan import Plan, plan_run
    from .result import Result
    from .scenario import Scenario, Sonar, Tachometer, Turbulence, load_scenario, read_scenario
    from .sonar_filter import steady_state, transition
    from .surge_model import drive, simulate_surge
    from .tank_model import Chunk, simulate_tank
    from .tick import stamp, tick
    from .whole import fly_vehicle
    from .written import as_toml, provenance

__all__ = facade(__name__)
