"""Campaign files: what they may say, and a trial of every value before any run."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ...experiment import Scenario, load_scenario
from ...plant import Truth, load_truth, null_vector, slot
from ...record import Section, find_file, meant, open_section
from ...resources import scenarios_dir
from .axes import Axis, Draw, read_draws, read_grid, refusal
from .campaign import LUMPED, SCENARIO, SEED, TRUTH, Campaign

MODELS = ("tank", "surge")


def load_campaign(name_or_path: str | Path) -> Campaign:
    """The campaign of that name in scenarios/campaigns, or of that TOML file.

    Every value of the grid and the ends of every draw are tried: InputError names file, line and key of one that no
    scenario takes. What goes wrong only in combination is found, and recorded, in the run.
    """
    path = find_file(name_or_path, scenarios_dir() / "campaigns", "campaign")
    section = open_section(path)
    section.text("description", "")
    model = section.choice("model", MODELS, "tank")
    seed, repeats = section.integer("seed", 0), section.integer("repeats", 1, low=1)
    tables = section.section("grid"), section.section("draw")
    section.close()
    grid, draws = read_grid(tables[0]), read_draws(tables[1])
    _check_keys(tables[0], tables[1], grid, draws)
    scenarios, truths = _sources(path, tables, grid, draws)
    text = path.read_text(encoding="utf-8")
    campaign = Campaign(path.stem, text, model, seed, repeats, grid, draws, scenarios=scenarios, truths=truths)
    tried = list(_tried(campaign, *tables))
    effects = {slot(name) for scenario in tried for name in scenario.effects}
    preset = {int(i) for truth in truths.values() for i in np.flatnonzero(truth.vector() != null_vector())}
    longest, periods = max(scenario.samples for scenario in tried), {scenario.period_s for scenario in tried}
    return replace(campaign, samples=longest, periods=frozenset(periods), slots=frozenset(effects | preset))


def _check_keys(grid: Section, draw: Section, axes: tuple[Axis, ...], draws: tuple[Draw, ...]) -> None:
    drawn = [entry.key for entry in draws]
    for axis in axes:
        if axis.key in drawn:
            raise refusal(draw, axis.key, "stands in [grid] too")
    if SCENARIO not in drawn and SCENARIO not in [axis.key for axis in axes]:
        raise InputError(f'{grid.path}: grid.scenario: missing; expected names of scenarios, such as ["paper-ds1"]')
    if SEED in drawn:
        raise refusal(draw, SEED, "cannot be drawn: give seeds in [grid], or only `seed` and `repeats` at the top")
    for section, key, values in _settings(grid, draw, axes, draws):
        if key.startswith("lumped.") and key not in LUMPED:
            also = "; gamma and tau are effects.thrust_loss.gamma_per_rev and effects.thrust_lag.tau_s"
            raise refusal(section, key, "unknown key" + meant(key, tuple(LUMPED)) + also)
        expected = {"lumped.alpha_per_m": "numbers below 0", "lumped.beta_m_per_rev2": "numbers above 0"}.get(key)
        expected = "whole numbers of at least 0" if key == SEED else expected
        for value in values if expected else ():
            if not _fits(key, value):
                raise refusal(section, key, f"expected {expected}, found {value!r}")


def _fits(key: str, value: Any) -> bool:
    """Whether a seed, alpha or beta is one."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    if key == SEED:
        return isinstance(value, int) and value >= 0
    return value < 0.0 if key == "lumped.alpha_per_m" else value > 0.0


def _settings(
    grid: Section, draw: Section, axes: tuple[Axis, ...], draws: tuple[Draw, ...]
) -> Iterator[tuple[Section, str, tuple[Any, ...]]]:
    """Where it stands, key and values to try of all that varies."""
    yield from ((grid, axis.key, axis.values) for axis in axes)
    yield from ((draw, entry.key, entry.ends) for entry in draws)


def _sources(
    path: Path, tables: tuple[Section, Section], grid: tuple[Axis, ...], draws: tuple[Draw, ...]
) -> tuple[dict[str, str], dict[str, Truth]]:
    """Texts of all scenarios and all truths, by the name that the campaign or a scenario has for them."""
    scenarios, truths = {}, {}
    for section, key, names in _settings(*tables, grid, draws):
        for name in names if key in (SCENARIO, TRUTH) else ():
            if not isinstance(name, str):
                raise refusal(section, key, f"expected names in quotes, found {name!r}")
            place = path.parent / name if name.endswith(".toml") else name
            try:
                if key == SCENARIO:
                    base = load_scenario(place)
                    scenarios[name], truths[base.truth] = base.path.read_text(encoding="utf-8"), load_truth(base.truth)
                else:
                    truths[name] = load_truth(place)
            except InputError as reason:
                raise refusal(section, key, str(reason)) from None
    return scenarios, truths


def _tried(campaign: Campaign, grid: Section, draw: Section) -> Iterator[Scenario]:
    """The scenarios of every value that varies, all others at their first."""
    settings = list(_settings(grid, draw, campaign.grid, campaign.draws))
    first = {key: values[0] for _, key, values in settings}
    for name in campaign.scenarios:
        base = first | {SCENARIO: name}
        try:
            yield campaign.scenario(base)
        except InputError as reason:
            section, key = next(((s, k) for s, k, _ in settings if _works_without(campaign, base, k)), (grid, SCENARIO))
            raise refusal(section, key, f"{base[key]!r}: {reason}") from None
        for section, key, values in settings:
            for value in values[1:] if key != SCENARIO else ():
                try:
                    yield campaign.scenario(base | {key: value})
                except InputError as reason:
                    raise refusal(section, key, f"{value!r}: {reason}") from None


def _works_without(campaign: Campaign, choice: dict[str, Any], key: str) -> bool:
    """Whether it is this key that the scenario does not take."""
    if key == SCENARIO:
        return False
    try:
        campaign.scenario({name: value for name, value in choice.items() if name != key})
    except InputError:
        return False
    return True
