"""Pursuit: what is missing, one thing after the other, for as long as one gains evidence.

The innovations are linear in all columns, and each group's coefficients are Gaussian with one size, so that its
evidence is closed form; the size is integrated over a grid, and what was looked through is paid for: the groups share
a prior probability of one. A group that is found joins the parameters, and later ones explain what it leaves.
Brynjarsdottir, O'Hagan, Inverse Problems 30 (2014), on what such a discrepancy can mean; Gross, Vitells, Eur. Phys. J.
C 70 (2010), on looking elsewhere.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import Any

import numpy as np
from scipy.linalg import block_diag, cholesky, solve_triangular

from ...estimate.problem import Problem
from ...plant.parameters import LAG, slot
from ..evidence import Fitted
from ..holdout import held
from ..score import Linearised, linearise
from .dictionary import CHANNELS, SHARPER, Piece, changes, pieces, pitching, scaled, sharper

SIZES = np.logspace(
    1.0, 2.5, 4
)  # [-] whitened norm of a group's change: from what can be seen to what cannot be missed
TAKEN_UP = 1e-4  # share of a group's square that must survive the refit; less is rounding of the derivatives
WORTHWHILE = 3.0  # log evidence that a further group must gain, as a named effect must
BEYOND_DOUBT = 3.0  # deviations from which a moment of a wandering term counts as off
BLUNT = 0.5  # share of the best's gain from which the ends of a window are sought between those of bins; a choice
SHARPENED, FINER = 6, 2  # windows of which they are, at most, and how often; choices
MOST = 12  # groups found at most; for the time it takes
KINDS = ("function", "run", "window", "event", "stall", "line")  # each has an even share of the prior
OWN = {"drag": "alpha", "thrust": "beta", "lag": LAG}  # own parameter that goes with a term


@dataclass(frozen=True)
class Component:
    """A group that was found missing.

    Attributes:
        kind: "function", "run" (a term that differs by run), "wander" (from moment to moment), "window" or "line".
        channel: "hydrodynamics", "actuator" or "sensor".
        about: what it goes with.
        gain: log evidence it added.
        windows: (run, from, to) in which it shows [s]; none where it is there all the time.
        frequency: of a line [rad/s].
        force: whether a force, else an error of the readings.
        functions: per run, whose sum by coefficients is the force [m/s2], shape (I, K), or the error, shape (M, K).
        columns: change of all whitened innovations per unit of each, shape (sum M, K).
        deviation: of the coefficients beforehand.
        coefficients: that explain most, shape (K,).
        sd: their deviations, shape (K,).
    """

    kind: str
    channel: str
    about: str
    gain: float
    windows: tuple[tuple[int, float, float], ...]
    frequency: float | None
    force: bool
    functions: tuple[np.ndarray, ...]
    columns: np.ndarray
    deviation: float
    coefficients: np.ndarray
    sd: np.ndarray

    @cached_property
    def fitted(self) -> tuple[np.ndarray, ...]:
        """Per run, force at the input's stamps [m/s2], shape (I,), or error at the measurements [m or m/s], (M,)."""
        return tuple(functions @ self.coefficients for functions in self.functions)

    @property
    def own(self) -> bool:
        """Whether it is an own parameter of the simulator that differs from run to run."""
        return self.kind == "run" and self.about in OWN

    @property
    def repeats(self) -> bool:
        """Whether it would come again in another run: a function of the motion does."""
        return self.kind == "function"


@dataclass(frozen=True)
class Freeform:
    """What a fitted model lacks.

    Attributes:
        near: the model, linearised where it was fitted.
        components: in the order in which they were found.
        left: log evidence that one more thing, whichever, gains: below zero where there is none.
        shift: of the fit's unknowns beside the components, shape (size,).
        pitching: as `gain`, beside a hull that pitches a little, which is no gap; of a model without effects.
        uneven: log evidence of a disturbance that is louder for a while instead.
        swell: as of `pieces`.
    """

    near: Linearised
    components: tuple[Component, ...]
    left: float
    shift: np.ndarray
    pitching: float = np.inf
    uneven: float = 0.0
    swell: float | None = None

    @property
    def fit(self) -> Fitted:
        """The model."""
        return self.near.fit

    @property
    def gain(self) -> float:
        """Log evidence, over the model alone, of something missing; of one more thing where nothing was found."""
        return sum(c.gain for c in self.components) or self.left

    @property
    def mostly_repeats(self) -> bool:
        """Whether most of it repeats from run to run."""
        return sum(c.gain for c in self.components if c.repeats) > 0.5 * abs(self.gain)

    @property
    def own(self) -> bool:
        """Whether all that is missing are own parameters that differ from run to run."""
        return bool(self.components) and all(c.own for c in self.components)

    def by_run(self) -> dict[str, np.ndarray]:
        """Own parameters that differ from run to run, by slot: their values in every run, shape (R,)."""
        p = self.fit.vector()
        out: dict[str, np.ndarray] = {}
        for c in self.components:
            if c.own:
                name = OWN[c.about]
                factor = {"drag": 1.0, "thrust": p[slot(name)], "lag": -1.0}[c.about]  # a longer lag: less of dz/dt
                there = np.array([np.any(functions, axis=0) for functions in c.functions])
                out[name] = out.get(name, p[slot(name)]) + factor * (there @ c.coefficients)
        return out

    @cached_property
    def channels(self) -> dict[str, float]:
        """Probability of each channel, as if all that is missing were in one: by the evidence of what is found there.

        A share of the gain would belong to whatever was found first, which others may explain as well.
        """
        found = {c.channel: -np.inf for c in self.components}
        if len(found) < 2:
            return dict.fromkeys(found or ("none",), 1.0)
        start = _Pursuit(self.fit, self.swell)
        gains = {channel: start.followed(wandering=False, channels=[channel]).gain for channel in CHANNELS}
        most = max(gains.values())
        total = sum(np.exp(gain - most) for gain in gains.values())
        return {channel: float(np.exp(gain - most) / total) for channel, gain in gains.items()}

    def windows(self) -> list[dict[str, Any]]:
        """Where most of it is local in time, its windows: run, from, to [s], and the log evidence they share."""
        local, names = [c for c in self.components if c.windows], [run.name for run in self.fit.problem.runs]
        if sum(c.gain for c in local) < 0.5 * self.gain:
            return []
        return [
            {"run": names[k], "from": start, "to": stop, "log_likelihood_gain": c.gain / len(c.windows)}
            for c in local
            for k, start, stop in c.windows
        ]

    @property
    def channel(self) -> str:
        """That of the greatest share."""
        shares = self.channels
        return max(shares, key=lambda name: shares[name])

    def forces(self) -> tuple[np.ndarray, ...]:
        """Missing force at every run's input stamps [m/s2], shapes (I,)."""
        return self._summed(True, [run.input_time_s.size for run in self.fit.problem.runs])

    def errors(self) -> tuple[np.ndarray, ...]:
        """Error of every run's readings [m or m/s], shapes (M,)."""
        return self._summed(False, [run.time_s.size for run in self.fit.problem.runs])

    def _summed(self, force: bool, sizes: Sequence[int]) -> tuple[np.ndarray, ...]:
        """Sum of the components of one sort in every run, shapes (sizes[k],)."""
        parts = [c.fitted for c in self.components if c.force is force]
        return tuple(sum((part[k] for part in parts), np.zeros(size)) for k, size in enumerate(sizes))

    def without(self, rows: np.ndarray) -> Freeform:
        """What would have been found from the measurements `rows` alone, shape (sum M,) of bool, to first order.

        Only what would come again in another run is kept.
        """
        shift, parts = solve(self.near, self.components, rows)
        found = zip(self.components, parts, strict=True)
        kept = tuple(replace(c, coefficients=mean, sd=sd) for c, (mean, sd) in found)
        return replace(self, components=kept, shift=shift).repeating()

    def repeating(self) -> Freeform:
        """Only what would come again in another run."""
        return replace(self, components=tuple(c for c in self.components if c.repeats))

    def problem(self) -> Problem:
        """The fit's problem with the missing force added and the error taken off the readings."""
        pairs = zip(self.fit.problem.runs, self.errors(), strict=True)
        runs = tuple(replace(run, value=run.value - error) for run, error in pairs)
        return replace(self.fit.problem, runs=runs, forcing=self.forces())

    def cleared(self) -> Problem:
        """The fit's problem, its readings as they would be, to first order, if nothing were missing."""
        problem, theta = self.fit.problem, self.fit.optimum.theta
        before, after = problem.simulate(theta), self.problem().simulate(theta + self.shift)
        changes = (held(a.innovation) - held(b.innovation) for a, b in zip(after, before, strict=True))
        runs = tuple(replace(run, value=run.value + change) for run, change in zip(problem.runs, changes, strict=True))
        return replace(problem, runs=runs)


def _followed(columns: np.ndarray) -> np.ndarray:
    """Columns, shape (M, L), without those along which the simulation runs away: they explain nothing."""
    return np.where(np.isfinite(columns).all(axis=0), columns, 0.0)


@dataclass(frozen=True)
class _Group:
    """One candidate: per run that it touches, how its coefficients combine a piece's columns, shape (K, C).

    columns: of a piece of its own in its one run, shape (M, C); else they are with those of all pieces.
    """

    kind: str
    piece: Piece
    combine: tuple[tuple[int, np.ndarray], ...]
    window: tuple[int, float, float] | None = None
    frequency: float | None = None
    columns: np.ndarray | None = None


@dataclass(frozen=True)
class _Tried:
    """Groups side by side: their gains and deviations, shapes (G,), each when it is asked for, and how many there were.

    Those that were left out beforehand have been looked at as well. bins: whether they are windows in bins of time.
    """

    gains: np.ndarray
    sizes: np.ndarray
    group: Callable[[int], _Group]
    looked: int
    bins: bool = False


class _Pursuit:
    """Normal equations of all columns beside the parameters and groups found so far."""

    def __init__(self, fit: Fitted, swell: float | None = None) -> None:
        self.near = linearise(fit)
        self.pieces = pieces(fit, swell)
        self.columns = [_followed(C) for C in changes(fit, self.pieces)]
        self.rows = np.cumsum([0] + [f.innovation.size for f in fit.filtered])
        self.where = self._layout(len(self.columns))
        root = cholesky(self.near.information, lower=True)
        self.W = solve_triangular(root, self.near.jacobian.T, lower=True).T
        offset = fit.prior.weight * (fit.optimum.theta - fit.prior.mean)
        self.g = solve_triangular(root, self.near.jacobian.T @ self.near.residual + offset, lower=True)
        self.pull = [C.T @ self._row(self.near.residual, k) for k, C in enumerate(self.columns)]
        self.taken = [C.T @ self._row(self.W, k) for k, C in enumerate(self.columns)]
        self.squares = [self._squares(piece, i) for i, piece in enumerate(self.pieces)]
        self.found: list[tuple[_Group, float, float, np.ndarray]] = []
        self.wandering = True
        self.channels: Sequence[str] = CHANNELS

    def _row(self, a: np.ndarray, k: int) -> np.ndarray:
        return a[self.rows[k] : self.rows[k + 1]]

    def _layout(self, runs: int) -> list[list[slice | None]]:
        """Per piece and run, its columns: forces come first, as in `changes`."""
        out: list[list[slice | None]] = [[None] * runs for _ in self.pieces]
        for k in range(runs):
            done = 0
            for force in (True, False):
                for i, piece in enumerate(self.pieces):
                    if piece.force is force and (functions := piece.functions[k]) is not None:
                        out[i][k] = slice(done, done := done + functions.shape[1])
        return out

    def _own(self, i: int, k: int) -> np.ndarray:
        """Columns of a piece in a run, shape (M, K)."""
        return self.columns[k][:, self.where[i][k]]

    def _runs(self, i: int) -> list[int]:
        return [k for k, own in enumerate(self.where[i]) if own is not None]

    def _squares(self, piece: Piece, i: int) -> np.ndarray:
        """Products of a piece's columns within its groups, shape (R or 1, G, K, K); bins of windows all in one."""
        parts = []
        for k in self._runs(i):
            own = self._own(i, k)
            each = own.shape[1] if piece.kind == "window" else piece.each
            split = own.reshape(own.shape[0], -1, each).transpose(1, 2, 0)
            parts.append(split @ split.transpose(0, 2, 1))
        return np.array(parts) if piece.kind != "function" else np.sum(parts, axis=0)[None]

    def _left(self, i: int) -> tuple[np.ndarray, np.ndarray]:
        """Per piece: what remains of its products, and the pull on its coefficients, groups first."""
        piece, g = self.pieces[i], self.g
        runs = self._runs(i)
        E = [self.taken[k][self.where[i][k]] for k in runs]
        q = [self.pull[k][self.where[i][k]] for k in runs]
        each = E[0].shape[0] if piece.kind == "window" else piece.each
        if piece.kind == "function":
            E, q = [np.sum(E, axis=0)], [np.sum(q, axis=0)]
        split = np.array([e.reshape(-1, each, e.shape[1]) for e in E])  # R, G, K, P
        b = np.array([(e @ g - v).reshape(-1, each) for e, v in zip(E, q, strict=True)])
        if piece.kind == "line":  # coefficients of all runs side by side: R, G, K -> G, RK
            R, G, K, P = split.shape
            S = np.zeros((G, R * K, R * K))
            for r in range(R):
                S[:, r * K : (r + 1) * K, r * K : (r + 1) * K] = self.squares[i][r]
            flat = split.transpose(1, 0, 2, 3).reshape(G, R * K, P)
            return S - flat @ flat.transpose(0, 2, 1), b.transpose(1, 0, 2).reshape(G, R * K)
        return self.squares[i][0] - split[0] @ split[0].transpose(0, 2, 1), b[0]

    def likeliest(self) -> Freeform:
        """All that is found, with terms that wander or without, whichever has more evidence.

        Such a term can pass for nearly anything, and what is found one by one cannot undo it.
        """
        free = self.followed(wandering=True)
        if all(c.kind != "wander" for c in free.components):
            return free
        return max(free, self.followed(wandering=False), key=lambda found: found.gain)

    def pitched(self) -> None:
        """Let a hull that pitches a little join the parameters."""
        self._join(np.concatenate([_followed(C) for C in changes(self.near.fit, [pitching(self.near.fit)])]), 1.0)

    def followed(self, wandering: bool, channels: Sequence[str] = CHANNELS) -> Freeform:
        """What is found from here on in some channels, one after the other.

        wandering: with terms that come and go without a rule.
        """
        path = copy(self)
        path.found, path.wandering, path.channels = [], wandering, channels
        while True:
            gain, size, group, together = path.best()
            if gain < WORTHWHILE or len(path.found) == MOST:
                return path.solved(together)
            path.add(group, gain, size)

    def best(self) -> tuple[float, float, _Group, float]:
        """The group with the largest gain: gain, its coefficients' deviation, itself; and all groups' gain together."""
        tried: dict[str, list[_Tried]] = {kind: [] for kind in KINDS}
        for i, piece in enumerate(self.pieces):
            if piece.channel in self.channels:
                tried[piece.kind].append(self._windows(i) if piece.kind == "window" else self._groups(i))
        tried["run"] = self._by_run()
        weighed = []
        for some in tried.values():
            paid = float(np.log(len(KINDS) * max(sum(one.looked for one in some), 1)))
            weighed += [(one.gains - paid, one, paid) for one in some if one.gains.size]
        gains, one, _ = max(weighed, key=lambda weighed: float(np.max(weighed[0])))
        j = int(np.argmax(gains))
        together = float(np.logaddexp.reduce(np.concatenate([gains for gains, *_ in weighed])))
        best = float(gains[j]), float(one.sizes[j]), one.group(j)
        blunt = [(float(np.max(g)), paid, one) for g, one, paid in weighed if one.bins]
        for wide, paid, windows in sorted(blunt, key=lambda one: -one[0])[:SHARPENED]:
            if wide > max(BLUNT * gains[j], WORTHWHILE):
                i = int(np.argmax(windows.gains))
                sharp = self._sharpened(wide, float(windows.sizes[i]), windows.group(i), paid)
                best = max(best, sharp, key=lambda found: found[0])
        return *best, together

    def _groups(self, i: int) -> _Tried:
        """The groups of a piece: functions of all runs together, lines of each on their own."""
        piece, runs = self.pieces[i], self._runs(i)
        A, b = self._left(i)
        level = piece.lines.level if piece.lines else np.ones(A.shape[0])
        raw = np.sum(np.trace(self.squares[i], axis1=2, axis2=3), axis=0) / level
        gains, sizes = evidence(A / level[:, None, None], b / level[:, None], raw)

        looked = piece.events.looked if piece.events else gains.size
        if piece.events:  # an outlier is none: what ranks do not show counts for no more than they say
            by_ranks = evidence(*_alone(piece.events.lean))[0]
            shown = np.isinf(piece.events.lean) | (by_ranks > np.log(len(KINDS) * looked) + WORTHWHILE)
            gains = np.where(shown, gains, np.minimum(gains, by_ranks))
        if piece.lines:
            c = np.linalg.solve(A + np.eye(A.shape[1]) / np.square(sizes)[:, None, None], b[..., None])
            loudest = np.max(np.hypot(c[:, ::2, 0], c[:, 1::2, 0]), axis=1)
            gains, looked = np.where(loudest > piece.rounding, gains + piece.lines.log_share, -np.inf), 1

        def group(j: int) -> _Group:
            pick = np.zeros((piece.each, self._own(i, runs[0]).shape[1]))
            pick[:, j * piece.each : (j + 1) * piece.each] = np.eye(piece.each)
            if piece.events:
                return _Group("window", piece, ((runs[0], pick),), (runs[0], *piece.events.spans[j]))
            if piece.kind == "function":
                return _Group("function", piece, tuple((k, pick) for k in runs))
            assert piece.lines
            apart = np.eye(len(runs))
            combine = tuple((k, np.kron(apart[n][:, None], pick)) for n, k in enumerate(runs))
            return _Group("line", piece, combine, frequency=float(piece.lines.rad_s[j]))

        return _Tried(gains, sizes, group, looked)

    def _windows(self, i: int) -> _Tried:
        """All windows of a term in one run."""
        piece, (k,) = self.pieces[i], self._runs(i)
        A, b = self._left(i)
        lo, hi = spans(b[0].size).T
        gains, sizes = _over_spans(A[0], b[0], self.squares[i][0][0], lo, hi)
        return _Tried(gains, sizes, lambda j: _window(piece, k, int(lo[j]), int(hi[j])), gains.size, bins=True)

    def _sharpened(self, gain: float, size: float, group: _Group, paid: float) -> tuple[float, float, _Group]:
        """A window in bins, or one with ends between those of bins: its gain, its coefficient's deviation, itself.

        gain, size: of the group; paid: for looking through all windows in bins. So is what is looked through here.
        """
        (k, pick), best, fit = group.combine[0], (gain, size, group), self.near.fit
        start, stop = group.piece.edges[np.flatnonzero(np.diff(pick[0], prepend=0.0, append=0.0))]
        width = float(np.diff(group.piece.edges[:2])[0])
        for _ in range(FINER):
            ahead, paid = best[0], paid + 2.0 * float(np.log(2 * SHARPER))
            piece, width = sharper(group.piece, k, start, stop, width, fit), width / SHARPER
            own = _followed(changes(fit, [piece])[k])
            E, products = own.T @ self._row(self.W, k), own.T @ own
            pull = E @ self.g - own.T @ self._row(self.near.residual, k)
            first, last = np.triu_indices(pull.size + 1, 1)
            gains, sizes = _over_spans(products - E @ E.T, pull, products, first, last)
            j = int(np.argmax(gains))
            if gains[j] - paid < ahead + WORTHWHILE:
                break
            sharp = replace(_window(piece, k, int(first[j]), int(last[j])), columns=own)
            best = float(gains[j]) - paid, float(sizes[j]), sharp
            start, stop = piece.edges[[first[j], last[j]]]
        return best

    def _by_run(self) -> list[_Tried]:
        """Own terms, each with a factor of its own in every run."""
        by_term: dict[str, list[int]] = {}
        for i, piece in enumerate(self.pieces):
            if piece.kind == "window" and piece.force and piece.channel in self.channels:
                by_term.setdefault(piece.about, []).append(i)
        count, g = len(self.columns), self.g
        apart = [tuple(range(count)), *((k,) for k in range(count))] if count > 1 else []  # all of them, or one alone
        varying = [self._varying(members, runs, g) for members in by_term.values() for runs in apart]
        wandering = [self._wandering(by_term["thrust"], g)] if self.wandering and "thrust" in by_term else []
        return varying + wandering

    def _varying(self, members: list[int], runs: Sequence[int], g: np.ndarray) -> _Tried:
        """An own term, by run its piece, with a factor of its own in each of some runs."""
        pairs = [(k, members[k]) for k in runs]
        E = np.array([self.taken[k][self.where[i][k]].sum(axis=0) for k, i in pairs])
        q = np.array([self.pull[k][self.where[i][k]].sum() for k, i in pairs])
        raw = np.array([self.squares[i][0][0].sum() for _, i in pairs])
        gains, sizes = evidence((np.diag(raw) - E @ E.T)[None], (E @ g - q)[None], np.array([raw.sum()]))
        own = zip(pairs, np.eye(len(pairs)), strict=True)
        combine = tuple((k, np.outer(row, np.ones(self._own(i, k).shape[1]))) for (k, i), row in own)
        return _Tried(gains, sizes, lambda j: _Group("run", self.pieces[pairs[0][1]], combine), 1)

    def _wandering(self, members: list[int], g: np.ndarray) -> _Tried:
        """An own term with a factor of its own in every bin of every run: what comes and goes without a rule."""
        E = np.vstack([self.taken[k][self.where[i][k]] for k, i in enumerate(members)])
        q = np.concatenate([self.pull[k][self.where[i][k]] for k, i in enumerate(members)])
        raw = block_diag(*(self.squares[i][0][0] for i in members))
        gains, sizes = evidence((raw - E @ E.T)[None], (E @ g - q)[None], np.array([np.trace(raw)]))
        ends = np.cumsum([0] + [self._own(i, k).shape[1] for k, i in enumerate(members)])
        apart = np.eye(ends[-1])
        combine = tuple((k, apart[:, ends[k] : ends[k + 1]]) for k in range(len(members)))
        return _Tried(gains, sizes, lambda j: _Group("wander", self.pieces[members[0]], combine), 1)

    def _columns_of(self, group: _Group) -> np.ndarray:
        """Whitened columns of a group, shape (sum M, K)."""
        out = np.zeros((self.rows[-1], group.combine[0][1].shape[0]))
        for k, weights in group.combine:
            if group.columns is not None:
                self._row(out, k)[:] = group.columns @ weights.T
                continue
            i = self._piece_in(group, k)
            self._row(out, k)[:] = self._own(i, k) @ weights.T
        return out

    def _piece_in(self, group: _Group, k: int) -> int:
        """Index of the piece that holds a group's functions in a run; run terms have one for each run."""
        if group.kind not in ("run", "wander"):
            return next(i for i, p in enumerate(self.pieces) if p is group.piece)
        return next(
            i
            for i, p in enumerate(self.pieces)
            if p.kind == "window" and p.about == group.piece.about and p.force and self.where[i][k] is not None
        )

    def add(self, group: _Group, gain: float, size: float) -> None:
        """Let a group join the parameters."""
        C = self._columns_of(group)
        self._join(C, size)
        self.found.append((group, gain, size, C))

    def _join(self, C: np.ndarray, size: float) -> None:
        """Let columns (sum M, K) join the parameters, each coefficient of deviation `size` beforehand."""
        taken = self.W.T @ C
        m = cholesky(C.T @ C + np.eye(C.shape[1]) / size**2 - taken.T @ taken, lower=True)
        new = solve_triangular(m, (C - self.W @ taken).T, lower=True).T
        self.W = np.hstack([self.W, new])
        pull = C.T @ self.near.residual - taken.T @ self.g
        self.g = np.concatenate([self.g, solve_triangular(m, pull, lower=True)])
        self.taken = [np.hstack([E, self.columns[k].T @ self._row(new, k)]) for k, E in enumerate(self.taken)]

    def solved(self, left: float) -> Freeform:
        """All groups found and the parameters together."""
        found: list[Component] = []
        for group, gain, deviation, C in self.found:
            functions = tuple(self._functions(group, k) for k in range(len(self.columns)))
            rest = gain, (), group.frequency, group.piece.force, functions, C, deviation, np.empty(0), np.empty(0)
            found.append(Component(group.kind, group.piece.channel, group.piece.about, *rest))
        shift, parts = solve(self.near, found)
        components = []
        for (group, *_), component, (mean, sd) in zip(self.found, found, parts, strict=True):
            windows = (group.window,) if group.window else self._shown(group, mean, sd)
            components.append(replace(component, windows=windows, coefficients=mean, sd=sd))
        return Freeform(self.near, tuple(components), left, shift)

    def _functions(self, group: _Group, k: int) -> np.ndarray:
        """A group's functions in a run, shape (I, K) or (M, K)."""
        run, combine = self.near.fit.problem.runs[k], dict(group.combine)
        if k in combine:
            piece = group.piece if group.columns is not None else self.pieces[self._piece_in(group, k)]
            functions = piece.functions[k]
            assert functions is not None
            made = functions @ combine[k].T
            return made if group.piece.force else scaled(run, made)
        rows = run.input_time_s.size if group.piece.force else run.time_s.size
        return np.zeros((rows, group.combine[0][1].shape[0]))

    def _shown(self, group: _Group, mean: np.ndarray, sd: np.ndarray) -> tuple[tuple[int, float, float], ...]:
        """Windows in which a term that wanders is off beyond doubt, neighbours joined."""
        out: list[tuple[int, float, float]] = []
        for k, weights in group.combine if group.kind == "wander" else ():
            edges = self.pieces[self._piece_in(group, k)].edges
            for b in np.flatnonzero((np.abs(mean) > BEYOND_DOUBT * sd) @ weights):
                if out and out[-1][0] == k and out[-1][2] == edges[b]:
                    out[-1] = (k, out[-1][1], float(edges[b + 1]))
                else:
                    out.append((k, float(edges[b]), float(edges[b + 1])))
        return tuple(out)


def solve(
    near: Linearised, components: Sequence[Component], rows: np.ndarray | None = None
) -> tuple[np.ndarray, list[tuple[np.ndarray, np.ndarray]]]:
    """Shift of a fit's unknowns, shape (size,), and mean and deviation of each component's coefficients, all at once.

    rows: which measurements count, shape (sum M,) of bool; all by default. Without those of a run, this is what would
    have been found without it, to first order.
    """
    keep = np.ones(near.residual.size, bool) if rows is None else rows
    J = np.hstack([near.jacobian, *(c.columns for c in components)])[keep]
    prior = np.concatenate([near.fit.prior.weight, *(np.full(c.columns.shape[1], c.deviation**-2) for c in components)])
    scale = np.sqrt(np.sum(J**2, axis=0) + prior)
    inverse = np.linalg.inv((J / scale).T @ (J / scale) + np.diag(prior / scale**2)) / np.outer(scale, scale)
    offset = np.zeros(prior.size)
    size = near.information.shape[0]
    offset[:size] = prior[:size] * (near.fit.optimum.theta - near.fit.prior.mean)
    solution, sd = -inverse @ (J.T @ near.residual[keep] + offset), np.sqrt(np.diag(inverse))
    ends = np.cumsum([size, *(c.columns.shape[1] for c in components)])
    parts = [(solution[a:b], sd[a:b]) for a, b in zip(ends[:-1], ends[1:], strict=True)]
    return solution[:size], parts


def _window(piece: Piece, k: int, first: int, last: int) -> _Group:
    """A term of run k in the bins from first to last."""
    count = piece.edges.size - 1
    pick = np.zeros((1, count))
    pick[0, first:last] = 1.0
    if first == 0 and piece.about != "force":  # own parameters take up what is always off: told from its change
        first, last = last, count
    return _Group("window", piece, ((k, pick),), (k, float(piece.edges[first]), float(piece.edges[last])))


@cache
def spans(count: int) -> np.ndarray:
    """First and last bin of all windows over `count` bins but the whole, shape (W, 2)."""
    found = np.column_stack(np.triu_indices(count + 1, 1))
    return found[found[:, 1] - found[:, 0] < count]


def _over_spans(
    A: np.ndarray, b: np.ndarray, raw: np.ndarray, lo: np.ndarray, hi: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """`evidence` of windows from bin lo to bin hi, shapes (W,); A, b, raw: of bins, shapes (B, B), (B,), (B, B)."""
    return evidence(inside(A, lo, hi)[:, None, None], along(b, lo, hi)[:, None], inside(raw, lo, hi))


def along(values: np.ndarray, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Sum of values (B,) over the bins from lo to hi, shape (W,)."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    return np.asarray(total[hi] - total[lo])


def inside(products: np.ndarray, lo: np.ndarray, hi: np.ndarray) -> np.ndarray:
    """Sum of products (B, B) over the square of bins from lo to hi, shape (W,)."""
    total = np.zeros((products.shape[0] + 1,) * 2)
    total[1:, 1:] = np.cumsum(np.cumsum(products, axis=0), axis=1)
    return np.asarray(total[hi, hi] - total[lo, hi] - total[hi, lo] + total[lo, lo])


def _alone(deviations: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Single coefficients that are off by so many deviations, for `evidence`."""
    return np.ones((deviations.size, 1, 1)), deviations[:, None], np.ones(deviations.size)


def evidence(A: np.ndarray, b: np.ndarray, raw: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Log Bayes factors of G groups of K Gaussian coefficients against none, and the deviations that suit best.

    A, b: what remains of the products of their columns, shape (G, K, K), and of their pull, shape (G, K);
    raw: sum of squares before, shape (G,).
    """
    known = np.isfinite(A).all(axis=(1, 2)) & np.isfinite(b).all(axis=1)  # else the motion with it runs away
    A, b = np.where(known[:, None, None], A, 0.0), np.where(known[:, None], b, 0.0)
    trace = np.trace(A, axis1=1, axis2=2)
    seen = known & (trace > TAKEN_UP * np.maximum(raw, 1e-300))
    scale = np.sqrt(np.where(seen, trace, 1.0))
    values, vectors = np.linalg.eigh(A / (scale**2)[:, None, None])
    values = np.maximum(values, 0.0)
    projected = np.einsum("gkj,gk->gj", vectors, b) / scale[:, None]
    square = (SIZES**2)[:, None, None]
    gains = 0.5 * np.sum(projected**2 * square / (1.0 + square * values) - np.log1p(square * values), axis=2)
    total = np.where(seen, np.logaddexp.reduce(gains, axis=0) - np.log(SIZES.size), -np.inf)
    return total, SIZES[np.argmax(gains, axis=0)] / scale


def pursue(fit: Fitted, pitching: bool = True, swell: float | None = None) -> Freeform:
    """Everything that a fitted model lacks.

    pitching: and how much of it beside a hull that pitches a little. swell: as of `pieces`.
    """
    start = _Pursuit(fit, swell)
    free = replace(start.likeliest(), swell=swell)
    if not pitching or not free.components or fit.hypothesis.effects:
        return free
    start.pitched()
    return replace(free, pitching=start.likeliest().gain)
