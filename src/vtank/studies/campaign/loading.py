"""Campaign files: what they may say, and a trial of every value before any run."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from ...errors import InputError
from ...experiment import Scenario, load_scenario
from ...plant import Truth, load_truth, null_vector, slot
from ...record import GREATEST, Table, find_file, meant, open_table, parse, read_text, shown
from ...resources import scenarios_dir
from .axes import MOST_RUNS, read_draws, read_grid, refusal
from .campaign import BESIDE, LUMPED, SCENARIO, SEED, TRUTH, Campaign

MODELS = ("tank", "surge")
WANTED: dict[str, tuple[str, Callable[[float], bool]]] = {
    SEED: ("whole numbers of at least 0", lambda seed: isinstance(seed, int) and seed >= 0),
    LUMPED[0]: ("numbers below 0", lambda alpha: -GREATEST <= alpha < 0.0),
    LUMPED[1]: ("numbers above 0", lambda beta: 0.0 < beta <= GREATEST),
}
T = TypeVar("T")


class Varied(NamedTuple):
    """A key of [grid] or [draw], and the values of it to try."""

    section: Table
    key: str
    values: tuple[Any, ...]


def load_campaign(name_or_path: str | Path) -> Campaign:
    """The campaign of that name in scenarios/campaigns, or of that TOML file.

    Every value of the grid and the ends of every draw are tried: InputError names file, line and key of one that no
    scenario takes. What goes wrong only in combination is found, and recorded, in the run.
    """
    path = find_file(name_or_path, scenarios_dir() / "campaigns", "campaign")
    file = open_table(path)
    file.text("description", "")
    model = file.choice("model", MODELS, "tank")
    seed, repeats = file.integer("seed", 0), file.integer("repeats", 1, low=1)
    tables = file.table("grid"), file.table("draw")
    file.close()
    grid, draws = read_grid(tables[0]), read_draws(tables[1])
    varied = [Varied(tables[0], axis.key, axis.values) for axis in grid]
    varied += [Varied(tables[1], draw.key, draw.ends) for draw in draws]
    _check_keys(path, varied)
    campaign = Campaign(path.stem, read_text(path), model, seed, repeats, grid, draws, *_sources(path, varied))
    if len(campaign) > MOST_RUNS:
        raise InputError(f"{path}: {len(campaign):,} runs; expected {MOST_RUNS:,} at most")
    tried = list(_tried(campaign, varied))
    effects = {slot(name) for scenario in tried for name in scenario.effects}
    preset = {int(i) for truth in campaign.truths.values() for i in np.flatnonzero(truth.vector() != null_vector())}
    longest, periods = max(scenario.samples for scenario in tried), {scenario.period_s for scenario in tried}
    return replace(campaign, samples=longest, periods=frozenset(periods), slots=frozenset(effects | preset))


def _check_keys(path: Path, varied: Sequence[Varied]) -> None:
    keys = [key for _, key, _ in varied]
    if SCENARIO not in keys:
        raise InputError(f'{path}: grid.scenario: missing; expected names of scenarios, such as ["paper-ds1"]')
    for section, key, values in varied:
        if section.name == "draw" and keys.count(key) > 1:
            raise refusal(section, key, "stands in [grid] too")
        if section.name == "draw" and key == SEED:
            raise refusal(
                section, key, "cannot be drawn: give seeds in [grid], or only `seed` and `repeats` at the top"
            )
        if key.startswith("lumped.") and key not in LUMPED:
            also = "; gamma and tau are effects.thrust_loss.gamma_per_rev and effects.thrust_lag.tau_s"
            raise refusal(section, key, "unknown key" + meant(key, LUMPED) + also)
        for value in values if key in WANTED else ():
            expected, fits = WANTED[key]
            if isinstance(value, bool) or not isinstance(value, int | float) or not fits(value):
                raise refusal(section, key, f"expected {expected}, found {shown(value)}")


def _sources(path: Path, varied: Sequence[Varied]) -> tuple[dict[str, str], dict[str, Truth], dict[str, str]]:
    """Texts of all scenarios, all truths, and paths of vehicle and walls files, by the names given to them."""
    scenarios: dict[str, str] = {}
    truths: dict[str, Truth] = {}
    files: dict[str, str] = {}
    for section, key, names in varied:
        for name in names if key in (SCENARIO, TRUTH, *BESIDE) else ():
            if not isinstance(name, str):
                raise refusal(section, key, f"expected names in quotes, found {shown(name)}")
            place = path.parent / name if name.endswith((".toml", ".xml")) else name
            try:
                if key == SCENARIO:
                    base = load_scenario(place)
                    scenarios[name] = text = read_text(base.path)
                    own = parse(text, base.path)
                    _keep(truths, own.get(TRUTH, base.truth), load_truth(base.truth))
                    for word in BESIDE:
                        _keep(files, own.get(word), getattr(base, word))
                elif key == TRUTH:
                    _keep(truths, name, load_truth(place))
                elif place != name:
                    _keep(files, name, os.path.abspath(place))
            except InputError as reason:
                raise refusal(section, key, str(reason)) from None
    return scenarios, truths, {name: file for name, file in files.items() if name != file}


def _keep(kept: dict[str, T], name: str | None, found: T) -> None:
    """Keep what goes by a name; one name in two folders would be two things."""
    if name is not None and kept.setdefault(name, found) != found:
        raise InputError(f"'{name}' is the name of two different files: rename one of them")


def _tried(campaign: Campaign, varied: Sequence[Varied]) -> Iterator[Scenario]:
    """The scenarios of every value that varies, all others at their first."""
    first = {key: values[0] for _, key, values in varied}
    for name in campaign.scenarios:
        base = first | {SCENARIO: name}
        try:
            yield campaign.scenario(base)
        except InputError as reason:
            blamed = (v for v in varied if v.key == SCENARIO or _works_without(campaign, base, v.key))
            section, key, _ = min(blamed, key=lambda v: v.key == SCENARIO)
            raise refusal(section, key, f"{shown(base[key])}: {reason}") from None
        for section, key, values in varied:
            for value in values[1:] if key != SCENARIO else ():
                try:
                    yield campaign.scenario(base | {key: value})
                except InputError as reason:
                    raise refusal(section, key, f"{shown(value)}: {reason}") from None


def _works_without(campaign: Campaign, choice: dict[str, Any], key: str) -> bool:
    """Whether it is this key that the scenario does not take."""
    try:
        campaign.scenario({name: value for name, value in choice.items() if name != key})
    except InputError:
        return False
    return True
