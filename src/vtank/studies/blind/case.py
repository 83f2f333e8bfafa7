"""A blind case: what it is made of, drawn from a seed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...effects import BY_NAME, CATALOGUE
from ...errors import InputError
from ...plant import Truth, load_truth, switched_on, vector
from .cause import RUNS, Cause, draw_cause, log_uniform
from .experiment import Experiment, draw_experiment
from .fly import Trip
from .outside import OUTSIDE

NOMINAL = "paper-ii"
KINDS = ("none", "parameters", "single", "pair", "outside", "left_out")
WEIGHTS = (2.0, 1.5, 7.0, 2.0, 1.5, 1.0)  # mean of the hidden frequencies of KINDS, in arbitrary units
SPREAD = 0.15  # [-] deviation of the logarithm of the true parameters over the nominal's; a choice
SMALLEST = 0.01  # [-] the same, least of the cases in which nothing else is wrong
WANTED = (3.0, 200.0)  # post-refit signal-to-noise ratios, drawn log-uniformly
DECOYS = 0.1  # share of the other cases from which an effect is withheld that is not their cause


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes:
        kind: one of KINDS.
        truth: the hull's own true parameters.
        causes: what the nominal leaves out.
        withheld: effects that the diagnosis must do without here.
        experiment: runs, noise.
        wanted: signal-to-noise ratio that the sizes are chosen for, one for each cause.
        seed: of the noise in all its runs.
    """

    kind: str
    truth: Truth
    causes: tuple[Cause, ...]
    withheld: tuple[str, ...]
    experiment: Experiment
    wanted: tuple[float, ...]
    seed: int

    def plan(self, run: int) -> Trip:
        """The plan of one run, held-out ones from RUNS on."""
        scenario = self.experiment.scenarios[run]
        slots = {name: value for cause in self.causes for name, value in cause.slots(run).items()}
        p = vector({"standoff": scenario.standoff_m, **slots}, base=self.truth.vector())
        memory = self.experiment.sonar_memory_s
        return Trip(scenario, self.truth, p, self.seed, run, scenario.name, self.causes, memory)

    def sized(self, sizes: Sequence[float]) -> Case:
        """The same case with its causes at other sizes."""
        return replace(self, causes=tuple(c.sized(s) for c, s in zip(self.causes, sizes, strict=True)))


@dataclass(frozen=True)
class Frequencies:
    """How often each kind, effect and outside law comes up; drawn from the seed, and not disclosed."""

    kinds: dict[str, float]
    effects: dict[str, float]
    outside: dict[str, float]


def draw_frequencies(seed: int, kinds: Sequence[str] = KINDS, effects: Sequence[str] | None = None) -> Frequencies:
    """Dirichlet-distributed frequencies; InputError for names that do not exist."""
    _check(kinds, KINDS, "kind of case")
    able = tuple(effect.name for effect in CATALOGUE if effect not in switched_on(load_truth(NOMINAL).vector()))
    effects = able if effects is None else effects
    _check(effects, (*able, *OUTSIDE), "effect")
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0,)))
    weights = 4.0 * np.array([WEIGHTS[KINDS.index(kind)] for kind in kinds])
    named, laws = [e for e in effects if e in BY_NAME], [e for e in effects if e in OUTSIDE] or list(OUTSIDE)
    named = named or list(able)
    return Frequencies(
        dict(zip(kinds, random.dirichlet(weights).tolist(), strict=True)),
        dict(zip(named, random.dirichlet(np.full(len(named), 4.0)).tolist(), strict=True)),
        dict(zip(laws, random.dirichlet(np.full(len(laws), 4.0)).tolist(), strict=True)),
    )


def draw_case(seed: int, number: int, attempt: int, frequencies: Frequencies, familiar: bool = False) -> Case:
    """Case `number`; an attempt keeps kind, causes and wanted sizes and draws everything else anew."""
    what = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1, number)))
    sequence = np.random.SeedSequence(seed, spawn_key=(2, number, attempt))
    how = np.random.default_rng(sequence)
    kind = _choose(what, frequencies.kinds)
    names = _names(what, kind, frequencies)
    wanted = tuple(log_uniform(what, *WANTED) for _ in names)
    withheld = _withheld(what, kind, names, frequencies)
    nominal = load_truth(NOMINAL)
    spread = {"none": 0.0, "parameters": log_uniform(what, SMALLEST, 2.0 * SPREAD)}.get(kind, SPREAD)
    alpha, beta, tau = np.exp(spread * how.normal(size=3))
    truth = replace(
        nominal, name="case", source="blind trial", alpha_per_m=nominal.alpha_per_m * float(alpha),
        beta_m_per_rev2=nominal.beta_m_per_rev2 * float(beta), tau_s=nominal.tau_s * float(tau),
    )  # fmt: skip
    experiment = draw_experiment(how, truth, familiar)
    causes = tuple(draw_cause(name, how) for name in names)
    return Case(kind, truth, causes, withheld, experiment, wanted, int(sequence.generate_state(1, np.uint64)[0] >> 1))


def tied(name: str) -> str:
    """The name under which an effect is scored: effects that are one and the same to a sonar share the first's."""
    return (BY_NAME[name].same_as if name in BY_NAME else "") or name


def label(case: Case) -> str:
    """The right answer: none, parameters, an effect, two joined by `+` in alphabetical order, or unknown."""
    if case.kind in ("outside", "left_out"):
        return "unknown"
    names = {tied(c.name) for c in case.causes if c.name in BY_NAME and BY_NAME[c.name].standing != "absorbed"}
    return "+".join(sorted(names)) or ("none" if case.kind == "none" else "parameters")


def _names(random: np.random.Generator, kind: str, frequencies: Frequencies) -> tuple[str, ...]:
    if kind in ("none", "parameters"):
        return ()
    if kind == "outside":
        return (_choose(random, frequencies.outside),)
    effects = dict(frequencies.effects)
    if kind in ("pair", "left_out"):  # absorbed effects are no second cause, and cannot be missed
        effects = {n: f for n, f in effects.items() if BY_NAME[n].standing != "absorbed"} or effects
    first = _choose(random, effects)
    if kind != "pair":
        return (first,)
    rest = {name: f for name, f in effects.items() if tied(name) != tied(first)}
    if not rest:
        raise InputError(f"--effects {first}: a pair needs two different effects")
    return first, _choose(random, rest)


def _withheld(random: np.random.Generator, kind: str, names: tuple[str, ...], f: Frequencies) -> tuple[str, ...]:
    """The cause and all that is tied to it where it is left out; in some other cases an effect that is no cause."""
    draw, decoy = random.random(), _choose(random, f.effects)
    decoyed = draw < DECOYS and tied(decoy) not in map(tied, names) and kind != "outside"
    missing = names[0] if kind == "left_out" else decoy if decoyed else ""
    return tuple(effect.name for effect in CATALOGUE if tied(effect.name) == tied(missing))


def _choose(random: np.random.Generator, frequencies: dict[str, float]) -> str:
    names, weights = list(frequencies), np.array(list(frequencies.values()))
    return names[int(random.choice(len(names), p=weights / weights.sum()))]


def _check(names: Sequence[str], known: Sequence[str], what: str) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"no {what} '{name}'; there are: {', '.join(known)}")


def given(case: Case) -> list[Trip]:
    """Plans of the runs that are given."""
    return [case.plan(k) for k in range(RUNS)]
