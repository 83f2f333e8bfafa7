"""Which effects at which places explain the gap: score tests over all, fits of the promising, alone and together."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...rigid.filtered import STILL, Filtered, Noise, shaken
from ...rigid.fit import Fit, level
from ...rigid.layout import Layout
from ...rigid.noise import first_noise
from ...rigid.places import Placed, Sizes, catalogue
from ...rigid.recorded import Recorded
from .echoes import Echoes, heard, still_heard
from .gross import mistaken
from .lesser import lessened, trusted_in, without
from .model import Model, at_noise, blank, even, refit
from .odds import imitated, imperfect, log_prior, nameless, prior_odds, worth
from .own import EACH, Unknown, own_unknowns
from .retained import retained
from .score import Promise, based, promises
from .settling import flowing, forgetful, reformed, rightly_begun, settled, trusting
from .sizes import sizes_of
from .unnamed import NAMELESS, QUIETER, Block, at_place, calmed, unnamed

Array = NDArray[np.float64]
Start = tuple[Model, Array, list[Filtered]]  # of a fit beside it: a model, its J, and its filter
FITTED = 6  # promising effects that are fitted, beside all that promise nearly as much; a choice
ALWAYS, HOPELESS = 3, 0.3  # so many are fitted always, others where they promise this share of the best's gain; choices
NEAR = 6.0  # log evidence behind the best promise within which an effect is fitted besides, up to twice FITTED
STRONGEST = 24  # in every round of score tests, which are tried again as rivals; a choice
NEARER = (1.0, 0.3, 0.1, 0.03)  # of what a score test says, where a fit begins; choices
LOST = 50.0  # log evidence that no number of an effect costs: a fit that lies so far behind ran away; a choice
STEADIEST = 3  # that promise most beside one that does not, and are fitted; a choice
LIKELIER = 4.6  # log evidence from which a noise sought afresh takes the place of one sought on the way; a choice
LEAPS = 4  # from one best fit to a better one beside it, at most; a choice
MOST = 3  # effects that are named together
BADLY = 2.0  # log-likelihood that a model has by another's filter for its own, from which it is fitted anew; a choice
FAR_OFF = 1.0  # prior deviations from which own parameters have gone far; a choice
AGREE = 0.03  # width of priors, over the widest, within which own parameters are said to be the file's; a choice
SURELY_OFF = 3.0  # deviations of the fit by which an own parameter is surely off; a choice
DIFFER = 0.1  # width of priors, over the widest, from which own parameters are said to be others than the file has
ALIKE = 1e-3  # [-] by which the gains of thrusters differ that are alike; a choice


@dataclass(frozen=True, eq=False)
class Selection:
    """What was found.

    Attributes:
        layout, runs, sizes: what was looked at. nominal, own: fits without effects, at the final noise.
        best: of the sets that were fitted. sets: all of them, by names joined with +. blocks: free-form parts beside
            the best, blocks_alone: beside own parameters alone. probabilities: by name.
    """

    layout: Layout
    runs: tuple[Recorded, ...]
    sizes: Sizes
    nominal: Model
    own: Model
    best: Model
    sets: dict[str, Model]
    blocks: list[Block]
    blocks_alone: list[Block]
    probabilities: dict[str, float]

    @cached_property
    def found(self) -> list[Filtered]:
        """The filter at the best."""
        return self.best.fit.filter(self.best.vector())

    @property
    def disturbance(self) -> Array:
        """Deviation of the disturbance of each axis beside the best, as an acceleration [m/s2, rad/s2], (6,)."""
        return shaken(self.best.fit.noise, self.found)

    def lesser(self, name: str) -> Model:
        """The best without one of its effects."""
        placed = next(placed for placed in self.best.effects if placed.name == name)
        return without(self.best, self.layout, [placed], self.found)


def select(
    layout: Layout, runs: tuple[Recorded, ...], effects: Sequence[str] | None = None,
    progress: Callable[[str], None] | None = None, mimicry: Mapping[str, float] | None = None,
) -> Selection:  # fmt: skip
    """Forward selection, with the noise level found anew beside every effect that is taken in.

    mimicry: log evidence, which is taken off what is found: by EFFECT@PLACE there, of NAMELESS everywhere.
    """
    say = progress or (lambda text: None)
    say("noise of the recordings")
    noise = first_noise(runs)
    floor = noise.variance
    own = own_unknowns(layout, runs)
    known = _asked_for(catalogue(layout, runs[0].moves, Sizes.unit(layout)), effects)
    best, found = _begin(layout, Fit(runs, noise), own, mistaken(layout, runs, noise, known), floor)
    best, found = reformed(*rightly_begun(best, found, floor), floor)
    best, found = trusting(*flowing(best, found, floor), own)
    sizes, less = sizes_of(best, found), mimicry or {}
    candidates = catalogue(layout, runs[0].moves, sizes)
    candidates = tuple(replace(c, mimicry=less.get(f"{c.effect}@{c.place}", 0.0)) for c in candidates)
    candidates = _asked_for(candidates, effects)
    if echoes := heard(best.fit.runs, found, candidates):
        best, found = settled(replace(best, fit=replace(best.fit, runs=echoes.runs)), floor, alone=True)
        best, found = trusting(best, found, own)
    strongest = set[str]()

    def grown(best: Model, found: list[Filtered]) -> Model:
        for _ in range(MOST - len(best.effects)):
            own_alone = without(best, layout, best.effects, found)
            fitted, strong = _wider(best, found, own, layout, candidates, say)
            strongest.update(strong)
            steady, strong = steadied(forgetful(best, floor), best, layout, candidates, floor)
            strongest.update(strong)
            fitted += steady
            fitted.sort(key=lambda m: -m.log_evidence)
            form = _form(best, found, sizes) if best.effects else 0.0
            if not fitted or worth(fitted[0], best, own_alone, candidates, form) < 0.0:
                break
            best, found = trusting(*settled(fitted[0], floor, alone=True), own)
            best, found = _afresh(best, own, noise, floor) or (best, found)
            best, found = trusting(*flowing(best, found, floor), own)
        return best

    def judged(best: Model) -> Selection:
        again = tuple(placed for placed in candidates if placed.name in strongest)
        return _judged(best, own, candidates, strong=again, sizes=sizes, less=less, echoes=echoes, say=say)

    best = grown(best, found)
    del found  # as large as all that is judged by; it is made anew where it is needed
    selection = judged(best)
    named, strong = _as_quiet(selection, candidates, floor)
    strongest.update(strong)
    if named:
        return judged(grown(*trusting(named, named.fit.filter(named.vector()), own)))
    return selection


def _as_quiet(selection: Selection, candidates: tuple[Placed, ...], floor: Array) -> tuple[Model | None, set[str]]:
    """The best with one more effect, tried at far less of a disturbance, which may stand for what it does.

    And the names of the strongest there.
    """
    best, layout = selection.best if selection.best.effects else selection.own, selection.layout
    noise = best.fit.noise
    if len(best.effects) == MOST or not np.any(noise.sigma > STILL):
        return None, set()
    tried, strong = steadied([at_noise(best, calmed(noise, QUIETER**2))], best, layout, candidates, floor)
    top = max(tried, key=evidence, default=best)
    return top if top is not best and worth(top, best, selection.own, candidates, 0.0) > 0.0 else None, strong


def _asked_for(candidates: tuple[Placed, ...], effects: Sequence[str] | None) -> tuple[Placed, ...]:
    if effects is None:
        return candidates
    return tuple(placed for placed in candidates if {placed.effect, placed.name} & set(effects))


def _begin(
    layout: Layout, fit: Fit, own: list[Unknown], mistake: Placed | None, floor: Array
) -> tuple[Model, list[Filtered]]:
    """The refit without effects, or with a gross mistake if that is likelier; InputError where both diverge."""
    begins, why = [], ""
    for effects in [(), (mistake,)] if mistake else [()]:
        try:
            model = blank(fit, layout, effects, own)
            begins.append(settled(refit(model, fit.filter(model.vector()), model.theta), floor))
        except InputError as error:
            why = str(error)
    if not begins:
        raise InputError(why)
    return max(begins, key=lambda pair: pair[0].log_evidence)


def _afresh(best: Model, own: Sequence[Unknown], noise: Noise, floor: Array) -> tuple[Model, list[Filtered]] | None:
    """The best at a noise sought from that before anything was fitted, where that is likelier.

    The noise that stood for what has just been found may hold on to itself. None where none is left, and where a filter
    at it loses its way: instruments that agree as hardly any do are no place to begin from.
    """
    if best.fit.noise.quiet:
        return None
    try:
        other, found = settled(replace(best, fit=replace(best.fit, noise=noise)), floor, rival=best.log_evidence)
    except InputError:
        return None
    return trusting(other, found, own) if other.log_evidence > best.log_evidence + LIKELIER else None


def _wider(
    best: Model, found: list[Filtered], own: Sequence[Unknown], layout: Layout, candidates: Sequence[Placed],
    say: Callable[[str], None],
) -> tuple[list[Model], set[str]]:  # fmt: skip
    """The best with what promises most beside it, fitted one at a time; and the names of the strongest."""
    say(f"score tests of {len(candidates)} effects at their places")
    begins = [(model, found) for model in (best, *_as_the_file_has_it(best, found, own))]
    ranked, where = _from_all([*begins, *even(best)], layout, candidates)
    fitted: list[Model] = []
    near = _near(ranked)
    fitting = _counted(say, "fitting", len(near))
    for promise in near:
        fitting(promise.placed.name)
        if not _hopeless(promise, fitted, best):
            fitted.append(extended(*where[promise.placed.name], layout, promise.placed, promise.begin))
    fitted += (weak := _weakest(best, found, layout, candidates))
    return fitted, {*(p.placed.name for p in ranked[:STRONGEST]), *(model.effects[-1].name for model in weak)}


def _counted(say: Callable[[str], None], what: str, total: int) -> Callable[[str], None]:
    """To be called before each of so many pieces of work, with its name; says the count and the time left of them."""
    start, done = time.monotonic(), 0

    def tell(name: str) -> None:
        nonlocal done
        left = f", {(time.monotonic() - start) / done * (total - done):.0f} s left" if done else ""
        done += 1
        say(f"{what} {name}, {done} of {total}{left}")

    return tell


def steadied(
    begins: Sequence[tuple[Model, list[Filtered]]], best: Model, layout: Layout, candidates: Sequence[Placed],
    floor: Array,
) -> tuple[list[Model], set[str]]:  # fmt: skip
    """Models with what promises most beside them, at less of a disturbance, each at the noise it then settles to.

    But for those that lie far behind the first of them at the noise that they have before; and the names of the
    strongest. best: of the likeliest noise; what lies far behind it is not settled further.
    """
    found, strong = list[Model](), set[str]()
    for calm, there in begins:
        promising, J = _promising(calm, there, layout, candidates)
        promising = [promise for promise in promising if promise.gain > 0.0]
        strong.update(promise.placed.name for promise in promising[:STRONGEST])
        tried = [extended(calm, J, there, layout, promise.placed, promise.begin) for promise in promising[:STEADIEST]]
        del J
        first = max((other.log_evidence for other in tried), default=0.0)
        near = [other for other in tried if other.log_evidence > first - NEAR]
        found += [settled(other, floor, alone=True, rival=best.log_evidence)[0] for other in near]
    return found, strong


def extended(
    model: Model, held: Array, found: Sequence[Filtered], layout: Layout, placed: Placed, begin: Sequence[float]
) -> Model:
    """The model with one more effect, fitted from where its score test says, or nearer where it runs away there.

    held: as of `refit`.
    """
    own = trusted_in(model)
    wider = blank(model.fit, layout, (*model.effects, placed), own)
    free = np.array([b for number, b in zip(placed.parameters, begin, strict=True) if number.scale > 0.0])
    for share in NEARER:
        fitted = refit(wider, found, np.concatenate([model.theta, share * free]), held)
        if fitted.log_evidence > model.log_evidence - LOST:
            break
    if fitted.strayed(model.theta):  # own parameters, so far that their slopes are others
        fitted = max(fitted, refit(fitted, found, fitted.theta), key=lambda fit: fit.log_evidence)
    return leapt(fitted, found, held)


def leapt(model: Model, found: Sequence[Filtered], held: Array) -> Model:
    """The fit, or a better one a grain or two beside it, for as long as there is one; held: as of `refit`."""
    grains = {f"{placed.name}.{number.name}": number.grain for placed in model.effects for number in placed.parameters}
    for i, unknown in enumerate(model.unknowns):
        grain = grains.get(unknown.name, 0.0)
        for _ in range(LEAPS if grain else 0):
            beside = [model.theta + k * grain * (np.arange(model.theta.size) == i) for k in (-2, -1, 1, 2)]
            beside = [theta for theta in beside if unknown.low <= theta[i] <= unknown.high]
            e = model.fit.residuals([model.vector(theta) for theta in beside], found)
            best = beside[int(np.argmin(np.sum(e * e, axis=0)))]
            there = refit(model, found, best, held)
            if there.log_evidence <= model.log_evidence:
                break
            model = there
    return model


def _elsewhere(
    best: Model, layout: Layout, found: Sequence[Filtered], candidates: Sequence[Placed]
) -> list[tuple[Model, float]]:
    """The best with one effect at another place, and how much less likely the recordings are with the same numbers.

    What acts alike at two places is as likely at either, and no score test from afar need lead there.
    """
    own, moved = trusted_in(best), list[Model]()
    for k, placed in enumerate(best.effects):
        for other in candidates:
            if other.effect == placed.effect and other.name not in best.names and _free(other) == _free(placed):
                moved.append(blank(best.fit, layout, (*best.effects[:k], other, *best.effects[k + 1 :]), own))
    vectors = [replace(model, theta=best.theta).vector() for model in (best, *moved)]
    e = best.fit.residuals(vectors, found)
    behind = 0.5 * np.sum(e * e, axis=0)
    return [(model, float(cost - behind[0])) for model, cost in zip(moved, behind[1:], strict=True)]


def _free(placed: Placed) -> list[str]:
    """Names of the numbers of an effect that are fitted."""
    return [number.name for number in placed.parameters if number.scale > 0.0]


def _promising(
    model: Model, found: Sequence[Filtered], layout: Layout, candidates: Sequence[Placed]
) -> tuple[list[Promise], Array]:
    """Score tests of all candidates that the model has not, the most promising first; and its J.

    Nothing else of a linearisation is kept, which takes as much as all filters together.
    """
    taken = {slot for placed in model.effects for number in placed.parameters for slot in number.slots}
    some = [c for c in candidates if not taken & {slot for number in c.parameters for slot in number.slots}]
    base = based(model, found)
    return promises(model, base, layout, some), base.J


def _as_the_file_has_it(best: Model, found: Sequence[Filtered], own: Sequence[Unknown]) -> list[Model]:
    """The model with own parameters as the file has them, if they have gone far, where a search begins a second time.

    What is turned round, in another unit or late drives own parameters so far away that mending it alone helps little.
    """
    moved = best.theta[: len(own)] / [u.scale for u in own]
    if not moved.size or np.max(np.abs(moved)) < FAR_OFF:
        return []
    return [refit(best, found, np.concatenate([np.zeros(len(own)), best.theta[len(own) :]]), steps=0)]


def _weakest(best: Model, found: Sequence[Filtered], layout: Layout, candidates: Sequence[Placed]) -> list[Model]:
    """The model with a weak thruster in place of the gain that is farthest below the middle one of the others.

    The rest of them may differ as they did, or be alike. No score test need lead there: as own parameters have it, it
    lacks nothing.
    """
    taken = {slot for placed in best.effects for number in placed.parameters for slot in number.slots}
    weak = {c.place: c for c in candidates if c.effect == "thruster_dead" and f"lost@{c.place}" not in taken}
    each = [i for i, u in enumerate(best.unknowns) if u.name.startswith(f"{EACH}@")]
    below = list[tuple[float, int, int, list[int]]]()
    for kind, u in enumerate(best.unknowns):
        alike = [i for i in each if best.unknowns[i].slots[0] in u.slots] if u.name.startswith("gain@") else []
        below += [(float(best.theta[i] - np.median([best.theta[j] for j in alike if j != i])), i, kind, alike)
                  for i in alike if len(alike) > 1]  # fmt: skip
    below = [one for one in below if best.unknowns[one[1]].name.partition("@")[2] in weak]
    if not below:
        return []
    off, k, kind, alike = min(below)
    if -off < max(float(best.sd[k]), ALIKE):
        return []
    theta, place = best.theta.copy(), best.unknowns[k].name.partition("@")[2]
    usual = float(theta[k]) - off  # of the others
    theta[kind] += usual
    theta[alike] -= usual
    share, theta[k] = -off / (layout.null[best.unknowns[k].slots[0]] + theta[kind]), 0.0
    narrow = tuple(replace(u, scale=min(u.scale, ALIKE)) if i in alike else u for i, u in enumerate(best.unknowns))
    models = []
    for unknowns in (best.unknowns, narrow):
        own = [u for u in unknowns if u.name.rpartition(".")[0] not in best.names]
        wider = blank(best.fit, layout, (*best.effects, weak[place]), own)
        models.append(refit(wider, found, np.append(theta, np.clip(share, 0.0, 1.0))))
    return models


def _from_all(
    begins: Sequence[tuple[Model, list[Filtered]]], layout: Layout, candidates: Sequence[Placed]
) -> tuple[list[Promise], dict[str, Start]]:
    """Promises of all candidates over the first model, the most promising first, and from which model each is."""
    best, where = dict[str, Promise](), dict[str, Start]()
    for model, found in begins:
        behind = model.log_evidence - begins[0][0].log_evidence
        promising, J = _promising(model, found, layout, candidates)
        for promise in promising:
            name = promise.placed.name
            if name not in best or promise.gain + behind > best[name].gain:
                best[name], where[name] = replace(promise, gain=promise.gain + behind), (model, J, found)
    return sorted(best.values(), key=lambda promise: -promise.gain), where


def _near(ranked: Sequence[Promise]) -> Sequence[Promise]:
    """Those that are fitted."""
    if not ranked:
        return []
    near = [promise for promise in ranked if promise.gain > ranked[0].gain - NEAR]
    return ranked[: max(FITTED, min(len(near), 2 * FITTED))]


def _hopeless(promise: Promise, fitted: Sequence[Model], model: Model) -> bool:
    """Whether its fit would not bring it to the front: it promises nothing, or others gained so much more."""
    gains = sorted(other.log_evidence - model.log_evidence for other in fitted)
    return len(fitted) >= ALWAYS and promise.gain < max(HOPELESS * gains[-1] - NEAR, 0.0)


def _judged(
    best: Model, own: list[Unknown], candidates: tuple[Placed, ...], *,
    strong: tuple[Placed, ...], sizes: Sizes, less: Mapping[str, float], echoes: Echoes | None,
    say: Callable[[str], None],
) -> Selection:  # fmt: skip
    """All sets near the best at its noise, and free-form parts beside it; posterior probabilities.

    strong: candidates that did well in any round, which are tried again as rivals.
    """
    runs, layout, found = best.fit.runs, best.fit.runs[0].layout, best.fit.filter(best.vector())
    say("rivals")
    refitted = without(best, layout, best.effects, found)
    mine = refitted.unknowns
    seen = [replace(u, scale=max(u.scale, DIFFER * w.scale)) for u, w in zip(mine, own, strict=True)]
    differing = [refit(blank(best.fit, layout, (), seen), found, refitted.theta)]
    if differ(refitted, own):  # some of them, and others as little as the file has it
        differing.append(refitted)
    loose = [u for u in best.unknowns[: len(own)] if not u.stated]
    nominal = lessened(best, layout, (), loose, found)  # what no file states is not the simulator's
    agreeing = [replace(u, scale=AGREE * w.scale) if u.stated else u for u, w in zip(mine, own, strict=True)]
    begin = np.zeros(len(own))
    begin[[not u.stated for u in mine]] = nominal.theta
    least = max(nominal.log_evidence, best.log_evidence - LOST)
    honest = refit(blank(best.fit, layout, (), agreeing), found, begin, least=least)  # programs of one file differ
    sets = {"none": max(nominal, honest, key=evidence), _key(best): best, "parameters": max(differing, key=evidence)}
    smaller = [without(best, layout, [placed], found) for placed in best.effects]
    lesser = smaller + [without(two, layout, [placed], found) for two in smaller if len(two.effects) > 1
                        for placed in two.effects]  # fmt: skip
    for model in lesser:
        sets.setdefault(_key(model), model)
    for parent in _parents(best, smaller, layout, found) or [refitted]:
        promising, J = _promising(parent, found, layout, strong)
        beside = [model for model in (best, *lesser) if set(parent.names) < set(model.names)]
        near = _near(promising)
        fitting = _counted(say, f"rivals beside {'+'.join(parent.names) or 'own parameters'}:", len(near))
        for promise in near:
            fitting(promise.placed.name)
            if _hopeless(promise, beside, parent):
                continue
            model = extended(parent, J, found, layout, promise.placed, promise.begin)
            beside.append(model)
            if model.log_evidence > sets.get(_key(model), nominal).log_evidence or _key(model) not in sets:
                sets[_key(model)] = model
        del J
    for model, behind in _elsewhere(best, layout, found, candidates):
        if best.log_evidence - behind > sets.get(_key(model), nominal).log_evidence:
            sets[_key(model)] = refit(model, found, best.theta)
    least = best.log_evidence - LOST
    judged = {model: by_itself(model, found, least) for model in dict.fromkeys([*sets.values(), nominal, refitted])}
    sets = {name: judged[model] for name, model in sets.items()}
    best, nominal, refitted = sets[_key(best)], judged[nominal], judged[refitted]
    if sets["none"].log_evidence > sets["parameters"].log_evidence:
        sets["parameters"] = max(sets["parameters"], begun_at(sets["none"], seen), key=evidence)
    forms = {name: _form(sets[name], found, sizes) for name in {_key(best), *map(_key, lesser)} - {"parameters"}}
    weights = prior_odds(sets, refitted, nominal, candidates, forms)
    for name in {_key(model) for model in lesser} - {"parameters"}:
        weights[name] += imperfect(forms[name], sets[name], refitted)
    top = sets[max(sets, key=lambda name: weights[name])]
    if top is not best:
        best = top
        found = best.fit.filter(best.vector())
    echoes = echoes and still_heard(echoes, best.fit, best.vector(), candidates)
    if echoes:
        heard_too = replace(best, effects=(*best.effects, echoes.placed), log_evidence=best.log_evidence + echoes.gain)
        late = echoes.gain + log_prior(heard_too, candidates) - log_prior(best, candidates)
        if late > 0.0:
            weights[_key(heard_too)] = weights[_key(best)] + late
            best = sets[_key(heard_too)] = heard_too
    say("what has no name")

    def free_form(model: Model, there: list[Filtered]) -> list[Block]:
        every = unnamed(model, there, based(model, there), sizes, best.log_evidence - model.log_evidence)
        every = [replace(block, gain=block.gain - less.get(NAMELESS, 0.0)) for block in every]
        return sorted(every, key=lambda block: -block.gain)

    blocks = alone = free_form(best, found)
    del found
    ground, mimicry = best, -np.inf
    if best.effects:
        there = refitted.fit.filter(refitted.vector())
        ground = refit(refitted, there, refitted.theta, steps=0)  # by its own filter, by which its free-form parts gain
        alone = free_form(ground, there)
        rest = max((block for block in blocks if block.visible), key=lambda block: block.gain, default=None)
        left = rest.gain if rest else -np.inf
        mimicry = weights[_key(best)] + imitated(left, best, refitted)
        weights[_key(best)] += imperfect(left, best, refitted)
        if rest and rest.repeats and not echoes:
            there = best.fit.filter(best.vector())
            gone = {*best.names} - retained(best, rest.place, layout, there, sizes)
            if gone < {*best.names}:  # what is left has a cause of its own beside those that stay
                stays = _less(sets, _key(best), gone, layout, there)
                weights[stays], mimicry = float(np.logaddexp(weights.get(stays, -np.inf), mimicry)), -np.inf
                if gone:
                    best = sets[stays]
                    blocks = free_form(best, best.fit.filter(best.vector()))
    weights |= nameless(alone, ground, nominal, mimicry)
    most = max(weights.values())
    total = sum(np.exp(w - most) for w in weights.values())
    chances = {name: float(np.exp(w - most) / total) for name, w in weights.items()}
    return Selection(
        layout=layout, runs=runs, sizes=sizes, nominal=nominal, own=refitted, best=best,
        sets=sets, blocks=blocks, blocks_alone=alone, probabilities=chances,
    )  # fmt: skip


def _parents(best: Model, smaller: Sequence[Model], layout: Layout, found: Sequence[Filtered]) -> list[Model]:
    """The best without each of its effects, from which rivals are sought: trusted as beside it, near what is true.

    And trusted anew, where that is far likelier.
    """
    parents = list[Model]()
    for placed, anew in zip(best.effects, smaller, strict=True):
        stay = [other for other in best.effects if other is not placed]
        parents.append(lessened(best, layout, stay, trusted_in(best), found))
        if anew.log_evidence > parents[-1].log_evidence + LOST:
            parents.append(anew)
    return parents


def begun_at(none: Model, own: Sequence[Unknown]) -> Model:
    """Own parameters fitted from those that agree with the file, by whose filter they are judged.

    They hold what agrees as well, and may have been led elsewhere by an effect that is none.
    """
    there, layout = none.fit.filter(none.vector()), none.fit.runs[0].layout
    agreed = {unknown.name: value for unknown, value in zip(none.unknowns, none.theta, strict=True)}
    begin = np.array([agreed.get(unknown.name, 0.0) for unknown in own])
    return by_itself(refit(blank(none.fit, layout, (), own), there, begin), there)


def differ(model: Model, own: Sequence[Unknown]) -> bool:
    """Whether a number that the file states is surely farther off than those that are said to agree with it."""
    off = np.abs(model.theta[: len(own)]) - SURELY_OFF * model.sd[: len(own)]
    return any(o > AGREE * u.scale for o, u in zip(off, own, strict=True) if u.stated)


def evidence(model: Model) -> float:
    """Log evidence of a model."""
    return model.log_evidence


def by_itself(model: Model, found: Sequence[Filtered], least: float = -np.inf) -> Model:
    """A model that was fitted by the filter of another, judged by its own; as it was where that leaves it below least.

    Another's gains may suit it badly: where a force goes with a place that nobody has told yet, speeds tell of it.
    One that runs away by its own is no rival. What no file states may have been led astray by these, and begins anew
    as well.
    least: log evidence from which it is a rival.
    """

    def likelihood(model: Model, there: Sequence[Filtered]) -> float:
        e = model.fit.residuals([model.vector()], there)[:, 0]
        return level(there) - 0.5 * float(e @ e)

    def ahead(model: Model, there: Sequence[Filtered]) -> float:
        try:
            return likelihood(model, model.fit.filter(model.vector())) - likelihood(model, there)
        except InputError:  # by which it runs away
            return -np.inf

    judged, gained = model, ahead(model, found)
    if gained == -np.inf:
        return replace(model, log_evidence=-np.inf)
    if 2.0 * gained < least - model.log_evidence:  # it is behind for other reasons
        return model
    for _ in range(LEAPS):
        if abs(gained) < BADLY or gained == -np.inf:
            break
        found = judged.fit.filter(judged.vector())
        held = np.where([u.stated for u in judged.unknowns], judged.theta, 0.0)
        judged = max((refit(judged, found, begin) for begin in (judged.theta, held)), key=evidence)
        gained = ahead(judged, found)
    judged = replace(judged, log_evidence=judged.log_evidence + gained)
    return judged if judged.log_evidence > least else model


def narrowed(selection: Selection, hidden: set[str]) -> Selection:
    """The selection without effects that nobody could see: sets that differ by them alone are one."""
    before, sets = selection.probabilities, dict(selection.sets)
    plain = max(("none", "parameters"), key=lambda name: before.get(name, 0.0))

    def seen(name: str) -> str:
        return _less(sets, name, hidden, selection.layout, selection.found, plain)

    chances: dict[str, float] = {}
    for name, chance in before.items():
        name = seen(name) if name in selection.sets and selection.sets[name].effects else name
        chances[name] = chances.get(name, 0.0) + chance
    return replace(selection, best=sets[seen(_key(selection.best))], sets=sets, probabilities=chances)


def _less(
    sets: dict[str, Model], name: str, gone: set[str], layout: Layout, found: Sequence[Filtered],
    plain: str = "parameters",
) -> str:  # fmt: skip
    """Name of a set without some of its effects, fitted where it was not; plain: of one without any."""
    left = "+".join(part for part in name.split("+") if part not in gone) or plain
    if left not in sets:
        model = sets[name]
        sets[left] = without(model, layout, [placed for placed in model.effects if placed.name in gone], found)
    return left


def _form(model: Model, found: Sequence[Filtered], sizes: Sizes) -> float:
    """Gain of log evidence if the law of one of a model's effects has a form of its own, at the place of the effect."""
    base = based(model, found)
    gains = [block.gain for placed in model.effects for block in at_place(base, sizes, placed.place)]
    return max(gains, default=-np.inf)


def _key(model: Model) -> str:
    return "+".join(sorted(model.names)) or "parameters"
