"""A blind case: what it is made of, drawn from a seed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...effects import BY_NAME, CATALOGUE, Effect
from ...errors import InputError
from ...plant import Truth, load_truth, slot, switched_on, vector
from ...record.toml import meant
from .cause import VARIED, Cause, draw_cause, log_uniform
from .experiment import Experiment, draw_experiment
from .fly import Trip
from .generator import EVERYWHERE, LOCAL, SENSOR, Scene, choose
from .outside import OUTSIDE
from .vehicles import FLEET

# Kinds of cases -> mean of their hidden frequencies, in arbitrary units, and how many causes they have
KINDS = {
    "none": (3.0, 0),
    "parameters": (1.0, 0),
    "varying": (1.5, 1),
    "single": (3.0, 1),
    "pair": (1.5, 2),
    "triple": (1.0, 3),
    "random": (2.5, 1),
    "local": (2.0, 1),
    "sensor": (1.2, 1),
    "outside": (1.0, 1),
    "left_out": (0.6, 1),
}
CAUSES: dict[str, Iterable[str]] = {
    "varying": VARIED,
    "random": EVERYWHERE,
    "local": LOCAL,
    "sensor": SENSOR,
    "outside": OUTSIDE,
}
UNKNOWN = ("random", "local", "sensor", "outside", "left_out")  # kinds of which the right answer is "unknown"
SPREAD = 0.15  # [-] deviation of the logarithm of the true parameters over the nominal's; a choice
SMALLEST = 0.01  # [-] the same, least of the cases in which nothing else is wrong
WANTED = (3.0, 200.0)  # post-refit signal-to-noise ratios, drawn log-uniformly
DECOYS = 0.1  # share of the other cases from which an effect is withheld that is not their cause


@dataclass(frozen=True)
class Case:
    """One case.

    Attributes:
        kind: one of KINDS.
        craft: the vehicle.
        truth: the hull's own true parameters.
        causes: what the nominal leaves out.
        withheld: effects that the diagnosis must do without here.
        experiment: runs, noise.
        wanted: signal-to-noise ratio that the sizes are chosen for, one for each cause.
        seed: of the noise in all its runs.
    """

    kind: str
    craft: str
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
        for cause in self.causes:
            for name, factor in cause.factors(run).items():
                p[slot(name)] *= factor
        return Trip(scenario, self.truth, p, self.seed, run, scenario.name, self.causes, self.experiment.noise)

    @property
    def nominal(self) -> Truth:
        """The simulator that the diagnosis is given."""
        return FLEET[self.craft].truth

    def sized(self, sizes: Sequence[float]) -> Case:
        """The same case with its causes at other sizes."""
        return replace(self, causes=tuple(c.sized(s) for c, s in zip(self.causes, sizes, strict=True)))


@dataclass(frozen=True)
class Frequencies:
    """How often each kind comes up, and in each kind each cause; drawn from the seed, and not disclosed."""

    kinds: dict[str, float]
    causes: dict[str, dict[str, float]]


def draw_frequencies(seed: int, kinds: Sequence[str] = tuple(KINDS), names: Sequence[str] | None = None) -> Frequencies:
    """Dirichlet-distributed frequencies; InputError for names that do not exist."""
    effects = [effect.name for effect in CATALOGUE if effect in able(load_truth(FLEET["phoenix"].nominal))]
    every = [name for causes in CAUSES.values() for name in causes]
    _check(kinds, tuple(KINDS), "kind of case")
    _check(names or (), (*effects, *every), "effect")
    random = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(0,)))

    def drawn(weights: dict[str, float]) -> dict[str, float]:
        return dict(zip(weights, random.dirichlet(4.0 * np.array(list(weights.values()))).tolist(), strict=True))

    def chosen(causes: Sequence[str]) -> dict[str, float]:
        return drawn(dict.fromkeys([name for name in causes if names is None or name in names] or causes, 1.0))

    causes = {kind: chosen(list(CAUSES.get(kind, effects))) for kind in kinds if KINDS[kind][1]}
    return Frequencies(drawn({kind: KINDS[kind][0] for kind in kinds}), {"decoy": chosen(effects), **causes})


def able(nominal: Truth) -> list[Effect]:
    """Effects that this nominal does not know yet."""
    known = switched_on(nominal.vector())
    return [effect for effect in CATALOGUE if effect not in known]


def draw_case(seed: int, number: int, attempt: int, frequencies: Frequencies, familiar: bool = False) -> Case:
    """Case `number`; an attempt keeps kind, causes, vehicle and wanted sizes and draws everything else anew."""
    what = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1, number)))
    sequence = np.random.SeedSequence(seed, spawn_key=(2, number, attempt))
    how = np.random.default_rng(sequence)
    kind = choose(what, frequencies.kinds)
    craft = "phoenix" if familiar else choose(what, {name: craft.share for name, craft in FLEET.items()})
    nominal = FLEET[craft].truth
    names = _names(what, kind, frequencies, nominal)
    wanted = tuple(log_uniform(what, *WANTED) for _ in names)
    withheld = _withheld(what, kind, names, frequencies)
    spread = {"none": 0.0, "parameters": log_uniform(what, SMALLEST, 2.0 * SPREAD)}.get(kind, SPREAD)
    alpha, beta, tau = np.exp(spread * how.normal(size=3))
    truth = replace(
        nominal, name="case", source="blind trial", alpha_per_m=nominal.alpha_per_m * float(alpha),
        beta_m_per_rev2=nominal.beta_m_per_rev2 * float(beta), tau_s=nominal.tau_s * float(tau),
    )  # fmt: skip
    experiment = draw_experiment(how, truth, FLEET[craft], familiar)
    scene = Scene(truth, 0.6 * experiment.top_rev_s, experiment.durations_s, experiment.given)
    causes = tuple(draw_cause(name, how, scene) for name in names)
    noise_seed = int(sequence.generate_state(1, np.uint64)[0] >> 1)
    return Case(kind, craft, truth, causes, withheld, experiment, wanted, noise_seed)


def tied(name: str) -> str:
    """The name under which an effect is scored: effects that are one and the same to a sonar share the first's."""
    return (BY_NAME[name].same_as if name in BY_NAME else "") or name


def label(case: Case) -> str:
    """The right answer: none, parameters, varying, unknown, an effect, or several joined by `+` in sorted order."""
    if case.kind in UNKNOWN:
        return "unknown"
    if case.kind == "varying":
        return "varying"
    names = {tied(c.name) for c in case.causes if c.known and BY_NAME[c.name].standing != "absorbed"}
    return "+".join(sorted(names)) or ("none" if case.kind == "none" else "parameters")


def _names(random: np.random.Generator, kind: str, frequencies: Frequencies, nominal: Truth) -> tuple[str, ...]:
    """Causes of a case; absorbed effects are no second cause and cannot be missed, and tied ones are one."""
    names: list[str] = []
    for _ in range(KINDS[kind][1]):
        left = dict(frequencies.causes[kind])
        if kind in ("single", "pair", "triple", "left_out"):
            new = {e.name for e in able(nominal) if kind == "single" or e.standing != "absorbed"}
            new = {name for name in new if tied(name) not in map(tied, names)}
            left = {name: f for name, f in left.items() if name in new}
        if not left:
            raise InputError(f"--effects: a {kind} needs {KINDS[kind][1]} different effects that the nominal lacks")
        names.append(choose(random, left))
    return tuple(names)


def _withheld(random: np.random.Generator, kind: str, names: tuple[str, ...], f: Frequencies) -> tuple[str, ...]:
    """The cause and all that is tied to it where it is left out; in some other cases an effect that is no cause."""
    draw, decoy = random.random(), choose(random, f.causes["decoy"])
    decoyed = draw < DECOYS and tied(decoy) not in map(tied, names) and kind not in UNKNOWN
    missing = names[0] if kind == "left_out" else decoy if decoyed else ""
    return tuple(effect.name for effect in CATALOGUE if tied(effect.name) == tied(missing))


def _check(names: Sequence[str], known: Sequence[str], what: str) -> None:
    for name in names:
        if name not in known:
            raise InputError(f"no {what} '{name}'{meant(name, known)}")


def given(case: Case) -> list[Trip]:
    """Plans of the runs that are given."""
    return [case.plan(k) for k in range(case.experiment.given)]
