"""Simulation: plans flown in the MuJoCo tank or on the surge model, with the same pilot on board.

plans = [plan_run(load_scenario("paper-ds1"), run=i) for i in range(400)]
results = simulate_surge(plans)            # or simulate_tank(plans, nthread=2)
results[0].run, results[0].true            # what was recorded, what was true
"""

from __future__ import annotations

from .plan import Plan, plan_run
from .result import Result
from .surge_model import simulate_surge
from .tank_model import simulate_tank

__all__ = ["Plan", "Result", "plan_run", "simulate_surge", "simulate_tank"]
