"""The whole comparison: nominal, refit, every single effect, promising pairs, and what has no name."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ..errors import InputError
from ..estimate.observed import Observed
from ..estimate.problem import FLAGGED, Noise
from ..plant.parameters import slot
from ..rigid.thinned import scatter
from . import outliers
from .bursts import UNLIKE, uneven, unlike
from .evidence import STATES, Fitted, Setting, Start, evaluate, first_guesses
from .freeform import OWN, WORTHWHILE, Freeform, pursue
from .hypothesis import Hypothesis, about_their_mean, candidates
from .lone_speeds import with_lone_speeds
from .noise_floor import noise_at, settle
from .prior import weight
from .rest import still_sigma
from .score import linearise, scan, score

FIRST_NOISE = Noise(sigma=0.01, correlation_time=1.0)  # where the search for the noise level starts; a guess
# Share of an effect's gap that survives a refit, which is all that is seen where the nominal is a refit: 3 to 5 % for
# linear drag, dry friction, dead-band and thrust loss on a generic surge model (simulated)
SURVIVES = 0.05
LEADERS = 3  # single effects that are tried in pairs with all others
PAIR_GAIN = 3.0  # log evidence a single effect must gain on the refit, and a pair promise over it, to be fitted
MOST_PAIRS = 6  # pairs that are fitted, and larger sets
HOPELESS = 50.0  # log evidence behind the best at which no other noise level helps; a choice
LARGEST = 3  # effects together at most
# Share of an own parameter by which it differs, where others do, a guess that the fit corrects; and more than nothing
ALSO, LEAST = 0.02, 1e-9
TURNS, SETTLED = 4, 1.0  # of own parameters that vary and their spread, at most, and log evidence another must gain
Report = Callable[[str], None]


@dataclass(frozen=True)
class Selection:
    """All hypotheses weighed at one noise level.

    Attributes:
        setting: runs, nominal, noise.
        nominal, refit: the simulator as it is, and with its own parameters refitted.
        named: single effects and pairs, the best first.
        free: what has no name, on top of the refit and of the best of all above.
    """

    setting: Setting
    nominal: Fitted
    refit: Fitted
    named: tuple[Fitted, ...]
    free: tuple[Freeform, ...] = ()

    def __repr__(self) -> str:
        """How many hypotheses, the best of them, and the runs."""
        runs = ", ".join(run.name for run in self.setting.runs)
        return f"Selection(best of {len(self.named) + 2} hypotheses: {self.best.hypothesis.name}; {runs})"

    @property
    def fits(self) -> tuple[Fitted, ...]:
        """All that have a name."""
        return (self.nominal, self.refit, *self.named)

    @property
    def singles(self) -> int:
        """Number of effects that were considered."""
        return sum(len(fit.hypothesis.effects) == 1 for fit in self.named)

    @property
    def best(self) -> Fitted:
        """The most probable explanation that has a name."""
        return max(self.fits, key=lambda fit: weight(fit, self.singles))

    @property
    def beyond(self) -> Freeform:
        """What has no name, on top of what it goes best with."""
        return max(self.free, key=lambda free: weight(free.fit, self.singles) + free.gain)


def prepare(runs: Sequence[Observed], nominal: np.ndarray, foreign: bool = False) -> Setting:
    """Flags, first noise level and size of the gap; foreign: the nominal is only a first guess (wide priors)."""
    runs = with_lone_speeds(runs)
    flags = tuple(outliers.long_ranges(run) for run in runs)
    weight = tuple(np.where(flag, FLAGGED, 1.0) for flag in flags)
    noise = first_noise(runs)
    setting = Setting(runs, nominal, noise, 1.0, flags, weight, foreign)
    quiet = setting.with_noise(noise.calm())
    gap = _gap(evaluate(quiet, Hypothesis(refit=foreign)))
    return replace(setting, gap=gap / SURVIVES if foreign else gap)


def first_noise(runs: Sequence[Observed]) -> Noise:
    """Where the search for the noise level starts, and the ratio of the channels' variances, which it keeps.

    That is of what is faster than the vehicle can move, and no less than of rounding.
    """
    variance = np.array(FIRST_NOISE.variance)
    values = {kind: [run.value[run.kind == kind] for run in runs if np.any(run.kind == kind)]
              for kind in np.unique(np.concatenate([run.kind for run in runs]))}  # fmt: skip
    fastest = {kind: max(float(np.median([*map(scatter, some)])), max(map(outliers.resolution, some)) / np.sqrt(12.0))
               for kind, some in values.items()}  # fmt: skip
    for kind, deviation in fastest.items():
        variance[kind] *= (deviation / fastest[min(fastest)]) ** 2
    return replace(FIRST_NOISE, variance=tuple(variance.tolist()))


def _gap(fit: Fitted) -> float:
    """Root mean square of the simulation error of a fit without process noise [m or m/s]."""
    e = np.concatenate([f.innovation[fit.problem.used(k)] for k, f in enumerate(fit.filtered)])
    return float(np.sqrt(np.mean(e**2)))


def select(setting: Setting, names: Sequence[str] | None = None, say: Report = lambda text: None) -> Selection:
    """Weigh everything; names: the effects to consider (default: the catalogue)."""
    effects = candidates(setting.nominal, setting.runs, names)
    say("refit of the nominal's own parameters")
    refit = evaluate(setting, Hypothesis())
    usual = np.inf if setting.foreign else setting.usual
    setting = setting.with_noise(noise_at(refit.problem, refit.optimum.theta, usual))
    refit = evaluate(setting, Hypothesis(), [refit.start()])
    setting = replace(setting, usual=still_sigma(refit))
    say(f"{len(effects)} effects, one by one")
    singles = [Hypothesis(refit=False), Hypothesis(), *(Hypothesis((effect,)) for effect in effects)]
    fits = weigh_all(setting, singles, [_near(setting, refit, h) for h in singles])
    say("noise level")
    setting, likely = settle(setting, fits)
    if (louder := unlike(setting, max(fits, key=lambda f: f.log_evidence))) is not setting:
        louder, more = settle(louder, again(louder, fits))
        if more > likely + UNLIKE:
            setting, likely = louder, more
    fits = _with_larger(setting, again(setting, fits), say)
    asked = ""
    while len((best := max(fits, key=lambda f: f.log_evidence).hypothesis).effects) > 1 and best.name != asked:
        say("noise level beside several effects")
        asked, before = best.name, setting.noise
        setting, likely = settle(setting, fits, likely)
        fits = fits if setting.noise == before else _with_larger(setting, again(setting, fits), say)
    say("what has no name")
    found = Selection(setting, fits[0], fits[1], tuple(sorted(fits[2:], key=lambda f: -f.log_evidence)))
    if found.best.log_evidence == -np.inf:
        listed = ", ".join(run.name for run in setting.runs)
        raise InputError(
            f"run {listed}: no simulator follows these recordings, whatever its drag and thrust; "
            "expected numbers that a vehicle driven by its input could reach, in SI units"
        )
    return _with_own_noise(with_nameless(found), likely)


def _with_own_noise(selection: Selection, likely: float) -> Selection:
    """Everything weighed again at the noise level of own parameters that vary, where that is likelier than `likely`."""
    varying = [free.fit for free in selection.free if free.fit.hypothesis.varying]
    if not varying or selection.setting.foreign:
        return selection
    setting, _ = settle(selection.setting, varying, likely)
    if setting.noise == selection.setting.noise:
        return selection
    nominal, refit, *named = again(setting, selection.fits)
    named.sort(key=lambda f: -f.log_evidence)
    return with_nameless(replace(selection, setting=setting, nominal=nominal, refit=refit, named=tuple(named)))


def with_nameless(selection: Selection) -> Selection:
    """The selection, with what has no name laid over the refit, the best explanation, and parameters that vary."""
    bases = {id(fit): fit for fit in (selection.refit, selection.best)}.values()
    swells = [_swell(selection.best), None]
    with ThreadPoolExecutor(2) as pool:
        free = tuple(pool.map(partial(_pursued, selection.setting), bases, swells))
    if by_run := free[0].by_run():
        free = (*free, pursue(_varying(selection, by_run)))
    return replace(selection, free=free)


def _swell(fit: Fitted) -> float | None:
    """Frequency of a fit's wave [rad/s], None without one."""
    wave = next((effect.wave for effect in fit.hypothesis.effects if effect.wave), None)
    return float(fit.vector()[slot(wave[1])]) if wave else None


def _pursued(setting: Setting, fit: Fitted, swell: float | None) -> Freeform:
    """What has no name beside a fit, and how well uneven water would do instead; swell: as of `pieces`.

    That comes and goes as it likes: it is no rival of what mostly repeats.
    """
    free = pursue(fit, swell=swell)
    if setting.foreign or not free.components or free.mostly_repeats:
        return free
    return replace(free, uneven=uneven(fit, setting.usual))


def _varying(selection: Selection, by_run: Mapping[str, np.ndarray]) -> Fitted:
    """Own parameters of every run, and others that differ as well if that is likelier: what changes one changes more.

    by_run: their values to first order.
    """
    refit = selection.refit
    best = _spread(selection.setting, about_their_mean(by_run), {**refit.start(), **by_run})
    rest = [name for name in OWN.values() if name in refit.problem.free and name not in by_run]
    while rest and np.isfinite(best.log_evidence):
        start, own = best.start(), best.hypothesis.varying
        also = [(name, float(start[name]), max(ALSO * abs(float(start[name])), LEAST)) for name in rest]
        wider = [_spread(selection.setting, (*own, one), start) for one in also]
        gains = [fit.log_evidence - _learnt(best, name) for fit, name in zip(wider, rest, strict=True)]
        if not max(gains) >= best.log_evidence + WORTHWHILE:
            break
        best = wider[int(np.argmax(gains))]
        rest = [name for name in rest if name not in best.problem.per_run]
    return best


def _learnt(fit: Fitted, name: str) -> float:
    """Log evidence that an own parameter of all runs pays for its prior, as its mean over the runs does not."""
    i = fit.problem.free.index(name)
    weight, off = fit.prior.weight[i], fit.optimum.theta[i] - fit.prior.mean[i]
    return 0.5 * float(weight * off**2 - np.log(weight * fit.covariance()[i, i]))


def _spread(setting: Setting, about: tuple[tuple[str, float, float], ...], start: Start) -> Fitted:
    """Own parameters of every run, fitted about their mean and spread, which are worked out anew from the fit.

    about: as of `Hypothesis`. Where they differ much, what is told to first order is far from what fits.
    """
    best = evaluate(setting, Hypothesis(varying=about), [start])
    for _ in range(TURNS):
        start = best.start()
        about = about_their_mean({name: np.asarray(start[name]) for name, _, _ in about})
        if min(spread for _, _, spread in about) <= 0.0:
            break
        fit = evaluate(setting, Hypothesis(varying=about), [start])
        gained, best = fit.log_evidence - best.log_evidence, max(best, fit, key=lambda f: f.log_evidence)
        if gained < SETTLED:
            break
    return best


def _near(setting: Setting, refit: Fitted, hypothesis: Hypothesis) -> list[Start]:
    """First guesses of a hypothesis beside the refit's parameters and initial states."""
    if not hypothesis.refit:
        return [{STATES: refit.start()[STATES]}]
    wave = hypothesis.effects[0].wave if len(hypothesis.effects) == 1 else None
    own = [start for _, start in scan(linearise(refit), wave)] if wave else first_guesses(setting, hypothesis)
    return [{**refit.start(), **start} for start in own]


def weigh_all(
    setting: Setting, hypotheses: Sequence[Hypothesis], starts: Sequence[Sequence[Start] | None]
) -> list[Fitted]:
    """Fit all hypotheses; the compiled kernels release the interpreter, so two threads help."""
    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(partial(evaluate, setting), hypotheses, starts))


def again(setting: Setting, fits: Sequence[Fitted]) -> list[Fitted]:
    """All hypotheses weighed again at another noise level; what is hopeless is not fitted to the end."""
    best = max(f.log_evidence for f in fits)

    def of(fit: Fitted) -> Fitted:
        hopeless = bool(fit.hypothesis.effects) and fit.log_evidence < best - HOPELESS
        return evaluate(setting, fit.hypothesis, [fit.start()], rough=hopeless)

    with ThreadPoolExecutor(2) as pool:
        return list(pool.map(of, fits))


def _with_larger(setting: Setting, fits: list[Fitted], say: Report) -> list[Fitted]:
    """All hypotheses, and the sets of two and three effects that promise more than any of them."""
    for count in range(2, LARGEST + 1 - setting.foreign):  # there, more are added one by one
        more = _larger(setting, fits, count)
        if more:
            say(f"{len(more)} sets of {count} effects")
        fits = fits + weigh_all(setting, [h for h, _ in more], [[start] for _, start in more])
    return fits


def _larger(setting: Setting, fits: Sequence[Fitted], count: int) -> list[tuple[Hypothesis, Start]]:
    """Leaders among the sets of count - 1 effects, each with the effects whose score on top of it is promising."""
    refit, singles = fits[1].log_evidence, [f for f in fits if len(f.hypothesis.effects) == 1]
    smaller = [f for f in fits if len(f.hypothesis.effects) == count - 1 and f.log_evidence > refit + PAIR_GAIN]
    ranked = sorted(smaller, key=lambda f: -f.log_evidence)
    known = {frozenset(e.name for e in f.hypothesis.effects) for f in fits}
    found: dict[frozenset[str], tuple[float, Hypothesis, Start]] = {}
    for leader in ranked[:LEADERS]:
        near = linearise(leader)
        for second in singles:
            names = frozenset(e.name for e in (*leader.hypothesis.effects, *second.hypothesis.effects))
            if len(names) == count and names not in found and names not in known:
                larger = Hypothesis((*leader.hypothesis.effects, *second.hypothesis.effects))
                gain, start = score(setting, near, second, refit)
                found[names] = leader.log_evidence + gain, larger, {**second.start(), **start, **leader.start()}
    best = max((f.log_evidence for f in fits), default=0.0)
    promising = sorted((f for f in found.values() if f[0] > best + PAIR_GAIN), key=lambda f: -f[0])
    return [(larger, start) for _, larger, start in promising[:MOST_PAIRS]]
