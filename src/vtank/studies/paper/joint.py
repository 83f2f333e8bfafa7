"""Which true drag, and which sample time T, the four published sets (a, b, tau, s_e) stand for, judged together.

What the paper leaves unsaid is drawn: a world has its noise, thrust, lag and filter, and every run an amplitude (data
set 4 tachometer spikes besides). In each world, at each true drag and T, the four experiments are flown and identified
as the paper did. The print is taken for what one of them gave, each of its 16 numbers times a lognormal factor of
deviation h for whatever no world has; h is unknown too. With K the density of that factor, drag and T have likelihood

    mean over h and worlds of  product over data sets of  mean over repeats of  product over quantities of K(sim/print)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...estimate.paper import Array
from ...experiment import Plan, load_scenario, plan_run, simulate_surge
from ...plant import load_truth
from ...units import FOOT_M
from .campaign import SCENARIOS
from .published import SETS, brutzman_a_per_ft, published
from .records import louder
from .study import FAST, QUANTITIES, estimate_all

MULTIPLES = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)  # true drag over Brutzman's, log-uniform
STEPS_S = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5)  # T, log-uniform: whole numbers of pings
MISFITS = (0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1.0)  # h, log-uniform
OF_WORLD = {  # log-uniform between these; guesses, around those of the scenarios and of the physical truth
    "sonar.noise_m": (0.003, 0.03),
    "b_ft_per_rev2": (0.001, 0.0025),
    "tau_s": (0.1, 0.95),
    "filter.q_ft2_per_s5": (0.3, 30.0),
}
OF_RUN = {"amplitude": (0.5, 1.1), "effects.tachometer_spikes.size_rev_s": (0.5, 8.0)}  # as OF_WORLD; over a scenario's
REPEATS = 4
CLASSES = {  # name -> MULTIPLES; Table 2, taken at its word, has 26 to 56
    "Brutzman's drag (once or twice)": slice(0, 2),
    "one between (4 to 16 times)": slice(2, 5),
    "one as published (32 or 64 times)": slice(5, None),
}
LOW, BETWEEN, HIGH = CLASSES
READINGS = ("least_squares", "kalman")  # a Q that settles; the printed one taken literally
JUDGED = ("a", "b", "tau", "s_e")


@dataclass(frozen=True)
class Joint:
    """Estimates in every world: reading -> shape (drags, steps, worlds, REPEATS, SETS, QUANTITIES), in feet.

    The literal reading, which explains the print far worse, is tried in every third world only.
    """

    estimates: dict[str, Array]

    @cached_property
    def likelihoods(self) -> dict[str, Array]:
        """Reading -> likelihood of the print, prior of T and h included, shape (misfits, drags, steps, worlds)."""
        return {reading: self.likelihood(reading) for reading in READINGS}

    def likelihood(self, reading: str, judged: tuple[str, ...] = JUDGED) -> Array:
        """As `likelihoods`, of some of the printed quantities; a value of the wrong sign has none."""
        table, places = published()[2].values, [QUANTITIES.index(quantity) for quantity in judged]
        printed = np.stack([table["deviation" if quantity == "s_e" else quantity] for quantity in judged], axis=-1)
        ratio = self.estimates[reading][..., places] / printed
        off = np.log(np.where(ratio > 0.0, ratio, np.inf)) ** 2  # NaN, a run that diverged, is not above 0 either
        by_set = [
            np.exp(-0.5 * np.sum(off, axis=-1) / h**2).mean(axis=3) / (h * np.sqrt(2.0 * np.pi)) ** len(judged)
            for h in MISFITS
        ]
        return np.asarray(np.prod(by_set, axis=-1) * step_prior()[:, None])

    def over(self, reading: str, axis: str, judged: tuple[str, ...] = JUDGED) -> Array:
        """Posterior over "misfit", "drag", "step" or "world": shares that add to one."""
        p = self.likelihoods[reading] if judged == JUDGED else self.likelihood(reading, judged)
        others = tuple(i for i, name in enumerate(("misfit", "drag", "step", "world")) if name != axis)
        return np.asarray(p.sum(axis=others) / p.sum())

    def map(self, reading: str) -> Array:
        """Posterior over drag and T, shape (drags, steps)."""
        p = self.likelihoods[reading]
        return np.asarray(p.sum(axis=(0, 3)) / p.sum())

    def odds(self, reading: str, over: str, step: int | None = None, of: str = LOW) -> Array:
        """Likelihood of a drag of one of CLASSES over one of another, T unknown or at one step; shape (3,).

        In the middle, between the 5 % and 95 % quantiles of 400 draws of as many worlds from these.
        """
        p = self.likelihoods[reading].sum(axis=0)
        p = p.sum(axis=1) if step is None else p[:, step]
        pair = np.stack([p[CLASSES[name]].mean(axis=0) for name in (of, over)])
        again = np.random.default_rng(0).integers(pair.shape[1], size=(400, pair.shape[1]))
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = pair[0, again].sum(axis=-1) / pair[1, again].sum(axis=-1)
            low, high = np.nanquantile(ratio, (0.05, 0.95), method="nearest")
            return np.array([low, pair[0].sum() / pair[1].sum(), high])

    @property
    def preference(self) -> float:
        """Likelihood of a Q that settles over that of the literal one, everything else unknown."""
        one, other = (self.likelihoods[reading].sum(axis=(0, 1, 2)).mean() for reading in READINGS)
        return float(one / other) if other > 0.0 else np.inf


def judge(seed: int, worlds: int, advance: Callable[[str], None] = lambda note: None) -> Joint:
    """Fly and identify the four experiments in every world; `advance` is called once for each."""
    rng = np.random.default_rng(seed)
    shares = [(rng.permutation(worlds) + rng.random(worlds)) / worlds for _ in OF_WORLD]  # a Latin square's columns
    drawn = np.array([between(*of) for of in zip(OF_WORLD.values(), shares, strict=True)]).T.tolist()
    found: dict[str, list[Array]] = {reading: [] for reading in READINGS}
    for j, values in enumerate(drawn):
        world = dict(zip(OF_WORLD, values, strict=True))
        flat = simulate_surge(_plans(world, j, seed, rng))
        flown = [flat[k : k + SETS] for k in range(0, len(flat), SETS)]
        for reading in READINGS if j % 3 == 0 else READINGS[:1]:
            settings = replace(FAST[reading], filter_q_ft2_s5=world["filter.q_ft2_per_s5"])
            of_all = estimate_all(flown, settings, steps_s=STEPS_S)
            by_drag = of_all.reshape(len(STEPS_S), len(MULTIPLES), REPEATS, SETS, len(QUANTITIES))
            found[reading].append(by_drag.swapaxes(0, 1))
        advance(f"world {j + 1}")
    return Joint({reading: np.stack(of, axis=2) for reading, of in found.items()})


def step_prior() -> Array:
    """Share of each of STEPS_S in a T that is log-uniform from the first to the last, shape (steps,)."""
    logarithm = np.log(STEPS_S)
    edges = np.concatenate([logarithm[:1], 0.5 * (logarithm[1:] + logarithm[:-1]), logarithm[-1:]])
    return np.asarray(np.diff(edges) / (edges[-1] - edges[0]))


def between(limits: tuple[float, float], share: Array | float) -> Array:
    """The value that a share of a log-uniform distribution lies below."""
    return np.asarray(limits[0] * (limits[1] / limits[0]) ** share)


def _plans(world: dict[str, float], number: int, seed: int, rng: np.random.Generator) -> list[Plan]:
    """Plans by true drag, repeat and data set: the noise, amplitudes and spikes of a repeat are those of every drag."""
    physical, beta = load_truth("physical"), world["b_ft_per_rev2"] * FOOT_M
    loss = physical.gamma_per_rev * beta / physical.beta_m_per_rev2
    same = [f"{key}={world[key]!r}" for key in OF_WORLD if "." in key]
    scenarios = []
    for _ in range(REPEATS):
        for name in (*SCENARIOS[:-1], "paper-ds4-spikes"):
            own = {key: float(between(limits, rng.random())) for key, limits in OF_RUN.items()}
            spikes = [f"{key}={value!r}" for key, value in own.items() if "." in key and name.endswith("spikes")]
            scenarios.append(louder(load_scenario(name, [*same, *spikes]), own["amplitude"]))
    plans = []
    for multiple in MULTIPLES:
        alpha = multiple * brutzman_a_per_ft() / FOOT_M
        truth = replace(physical, alpha_per_m=alpha, beta_m_per_rev2=beta, gamma_per_rev=loss, tau_s=world["tau_s"])
        plans += [plan_run(s, number * REPEATS * SETS + i, seed, truth) for i, s in enumerate(scenarios)]
    return plans
