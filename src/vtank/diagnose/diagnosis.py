"""The diagnosis as a whole: from runs and a nominal simulator to the document of schema vtank.diagnosis/2."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..effects.catalogue import CATALOGUE
from ..estimate.maximum_likelihood import told_apart
from ..estimate.observed import Observed
from ..plant.parameters import vector
from .baselines import baselines
from .budget import Budget, budget
from .foreign import explained
from .judged import judged
from .laws.found import Law, laws
from .likeness import Likeness, doubted
from .localise.where import WhereData, locate
from .next_experiment import next_experiment
from .noise_floor import plausible
from .selection import Selection, prepare, select
from .shrink import LeftOut, left_out, shrink
from .sizes import estimates, own_parameters
from .thinning import thinned
from .unnamed import unnamed
from .verdict import Verdict, cause_set, decide, probabilities

SCHEMA = "vtank.diagnosis/2"

ORDER = (
    "schema",
    "nominal",
    "verdict",
    "probabilities",
    "cause_set",
    "budget",
    "disturbance",
    "unexplained",
    "worse",
    "unnamed",
    "laws",
    "where",
    "shrink",
    "estimates",
    "absorbed",
    "tied",
    "next_experiment",
)


@dataclass(frozen=True, repr=False)
class Diagnosis:
    """Everything found about one data set; what takes time is worked out when it is first asked for.

    Attributes:
        selection: all hypotheses, weighed.
        probabilities: of every hypothesis, by name.
        verdict: what is said: kind, effects, rivals (what cannot be told from them), channel, probability.
        left_out: runs, or blocks of time of few runs, left out in turn and predicted by models fitted without them.
        budget: what the nominal's mean-square error on data left out is made of: lines that add to one, and intervals.
        seed: of the random parts.
        nominal: the simulator that the runs were compared with, by name; "none" where there is none.
        by_default: whether nobody chose it.
        mass_kg: moving mass of the vehicle, where it is known.
        considered: effects that alone were considered; all of the catalogue where empty.
        against: how like a simulator the nominal is that was fitted to its runs; None where the nominal was given.
        progress: told in a few words what is being worked out.
    """

    selection: Selection
    probabilities: dict[str, float]
    verdict: Verdict
    left_out: LeftOut
    budget: Budget
    seed: int
    progress: Callable[[str], None] | None = field(default=None, compare=False)
    nominal: str = "given parameters"
    by_default: bool = False
    mass_kg: float | None = None
    considered: tuple[str, ...] = ()
    against: Likeness | None = None

    def __repr__(self) -> str:
        """The verdict, its probability and the runs."""
        v, runs = self.verdict, ", ".join(run.name for run in self.selection.setting.runs)
        return f"Diagnosis({': '.join(filter(None, (v.kind, ', '.join(v.effects))))}, {v.probability:.2f}; {runs})"

    def failures(self) -> list[str]:
        """Fits that failed, in plain sentences."""
        fit, first = self.verdict.fit, "none" * self.selection.setting.foreign  # a first guess is no simulator
        lost = [name for name, value in self.log_evidence.items() if value == -np.inf and name != first]
        out = [f"simulators that run away on these recordings, and explain nothing: {', '.join(lost)}"] if lost else []
        if not fit.optimum.converged:
            out.append(f"the fit of {fit.hypothesis.name} did not settle: its sizes and their intervals are rough")
        return out

    @property
    def log_evidence(self) -> dict[str, float]:
        """Log evidence of every hypothesis that has a name [nats]; pairs are joined by `+`."""
        return {fit.hypothesis.name: fit.log_evidence for fit in self.selection.fits}

    @cached_property
    def where(self) -> WhereData:
        """Where the gap lies: channel, runs, windows of time, frequencies, regions of motion."""
        with self._stage("where the gap lies"):
            return locate(self.selection, self.verdict, self.probabilities)

    @cached_property
    def held_out(self) -> dict[str, Any]:
        """How far the gap shrinks on runs left out of selection and fit.

        Root mean square errors `nominal`, `refit`, `diagnosed` and the `floor` of noise ["unit", m or m/s]; the
        `fraction_closed` of what lies between refit and floor, with `interval90`.
        """
        with self._stage("how far it shrinks on runs left out"):
            return shrink(self.selection, self.verdict, self.seed, self.left_out)

    @cached_property
    def next_experiment(self) -> dict[str, Any]:
        """The experiment that is advised: `experiment`, `minutes`, `per_minute` [nats/min], `alternatives`."""
        with self._stage("next experiment"):
            return next_experiment(self.selection, self.verdict, self.probabilities)

    @cached_property
    def laws(self) -> tuple[Law, ...]:
        """For a cause without a name, up to three formulas that would be its law, the most probable first."""
        if self.verdict.kind != "unknown" or self.selection.beyond.windows():
            return ()  # what is there for a while only has a time, and no law
        selection = self.selection
        free = next(free for free in selection.free if free.fit is selection.refit)
        with self._stage("the missing law"):
            return laws(selection.setting, selection.refit, self.verdict.channel or "hydrodynamics", free.forces())

    @cached_property
    def document(self) -> dict[str, Any]:
        """The whole diagnosis as plain data, schema vtank.diagnosis/2."""
        with ThreadPoolExecutor(2) as pool:  # they do not need one another
            list(pool.map(partial(getattr, self), ("where", "next_experiment", "laws", "held_out")))
        left = self.budget.unexplained
        parts = self.summary() | {
            "budget": [line.document() for line in self.budget.lines],
            "unexplained": {"share": left.share, "interval90": list(left.interval90)},
            "worse": list(self.budget.worse),
            "where": self.where.document(),
            "shrink": self.held_out,
            "next_experiment": self.next_experiment,
            "laws": [law.document() for law in self.laws],
            "parameters": own_parameters(self.selection, self.verdict, self.mass_kg),
        }
        return {key: parts[key] for key in dict.fromkeys((*ORDER, *parts))}

    @contextmanager
    def _stage(self, text: str) -> Iterator[None]:
        if self.progress:
            self.progress(text)
        with told_apart(self.selection.setting.runs, "simulator's"):
            yield

    def summary(self) -> dict[str, Any]:
        """The parts of the document that take no time."""
        v, setting = self.verdict, self.selection.setting
        size, memory = setting.noise.sigma, setting.noise.correlation_time
        water: dict[str, Any] = {
            "sigma_m_s2": size,
            "memory_s": memory,
            "plausible": plausible(setting.noise, setting.usual),
        }
        if any(run.loud != 1.0 for run in setting.runs):
            water["by_run"] = {run.name: size * run.loud for run in setting.runs}
        return {
            "schema": SCHEMA,
            "nominal": self.nominal,
            "nominal_by_default": self.by_default,
            "verdict": v.document(),
            "probabilities": self.probabilities,
            "cause_set": list(cause_set(self.probabilities)),
            "disturbance": water,
            "unnamed": unnamed(self.selection, v),
            "estimates": estimates(v, self.mass_kg),
            "absorbed": [effect.name for effect in CATALOGUE if effect.standing == "absorbed"],
            "tied": [[effect.name, effect.same_as] for effect in CATALOGUE if effect.same_as],
            "considered": list(self.considered),
            "baselines": baselines(self.selection),
            "seed": self.seed,
            **({"against": self.against.document} if self.against else {}),
        }


def diagnose(
    runs: Sequence[Observed],
    nominal: np.ndarray | None,
    seed: int = 0,
    names: Sequence[str] | None = None,
    progress: Callable[[str], None] | None = None,
    against: Likeness | None = None,
) -> Diagnosis:
    """Diagnose the gap between runs and a nominal parameter vector, shape (P,).

    nominal: None for foreign vehicles, whose nominal is the recording's own refit of Model I.
    names: effects to consider, by default the whole catalogue. against: how like a simulator the nominal is that was
    fitted to its runs. InputError where the runs tell no parameters apart.
    """
    say = progress or (lambda text: None)
    with told_apart(runs, "simulator's"):
        if nominal is None:
            say("refit of the recording itself")
            selection = explained(runs, names, say)
        else:
            runs = thinned(runs)
            nominal = vector({"linear_input": 1.0} if runs[0].input_name == "thrust_N" else {}, nominal)
            selection = select(prepare(runs, nominal), names, say)
        chances = probabilities(selection)
        verdict = decide(selection, chances)
        say("runs left out one after the other")
        parts = left_out(selection, verdict)
        shares = budget(selection, verdict, seed, parts)
        verdict = judged(verdict, shares, selection.setting)
        if against:
            noise = float(np.sqrt(max(shares.share("noise"), 0.0)))
            against = against.beside(dict.fromkeys(against.columns, (shares.nominal, noise * shares.nominal)))
            verdict = doubted(verdict, against)
        name = "none" if nominal is None else Diagnosis.nominal
        chosen = tuple(names or ())
        found = Diagnosis(selection, chances, verdict, parts, shares, seed, progress, name, considered=chosen,
                          against=against)  # fmt: skip
    for text in found.failures():
        warnings.warn(text, stacklevel=2)
    return found
