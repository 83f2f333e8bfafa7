"""What a formula is worth on stretches that did not choose its numbers: closed form, without fitting again.

At an optimum the fit without a stretch is one Gauss-Newton step away; the stretch is then predicted, for the ranking by
the density of its innovations, which knows how sure the numbers are that the other stretches tell (Geisser and Eddy, J.
Am. Stat. Assoc. 74, 1979), and in pure simulation for the gap that is closed.
"""

from __future__ import annotations

import numpy as np

from ..evidence import Fitted, Setting
from ..holdout import Model, Prediction, targets_of

ENOUGH = 3  # runs from which whole runs are left out; below, each is cut in halves, or one into four; a choice


class Left:
    """A fit with each stretch left out in turn.

    Attributes:
        cost: minus the log predictive density of all stretches, each without itself, but for a constant [nats].
    """

    def __init__(self, fit: Fitted) -> None:
        """Linearise once, and take every stretch out."""
        problem, theta = fit.problem, fit.optimum.theta
        residual, J = problem.linearise(theta, fit.filtered)
        information = J.T @ J + np.diag(fit.prior.weight)
        volume = np.linalg.slogdet(information)[1]
        gradient = J.T @ residual + fit.prior.weight * (theta - fit.prior.mean)
        self.fit, self.cost, self.stretches, self.theta = fit, 0.0, list[tuple[int, np.ndarray]](), list[np.ndarray]()
        rows = np.cumsum([0] + [f.innovation.size for f in fit.filtered])
        parts = 1 if len(problem.runs) >= ENOUGH else 4 // len(problem.runs)
        for k in range(len(problem.runs)):
            for here in np.array_split(np.arange(rows[k], rows[k + 1]), parts):
                j, r, told = J[here], residual[here], np.ones(theta.size, bool)
                told[problem.own_slice(k)] = parts > 1  # a whole run begins by itself
                move, rest = np.zeros(theta.size), information - j.T @ j
                move[told] = -np.linalg.lstsq(rest[np.ix_(told, told)], (gradient - j.T @ r)[told], rcond=None)[0]
                e, own = r + j @ move, j[:, ~told]
                seen = float((j.T @ e) @ np.linalg.solve(information, j.T @ e))
                self.cost += 0.5 * (float(e @ e) - seen + volume - np.linalg.slogdet(rest)[1])
                move[~told] = -np.linalg.lstsq(own, e, rcond=None)[0] if parts == 1 else 0.0
                self.stretches.append((k, here - rows[k]))
                self.theta.append(np.clip(theta + move, fit.prior.low, fit.prior.high))

    def squares(self, setting: Setting) -> np.ndarray:
        """Squared error of pure simulation at all measurements that count, each by the fit without its stretch."""
        out, targets = [], targets_of(setting)
        for (k, own), theta in zip(self.stretches, self.theta, strict=True):
            target, p = targets[k], self.fit.problem.model(theta, k)[0]
            scored = np.isin(np.flatnonzero(target.scored), own)
            out.append(Prediction(Model(p), target).errors()[scored] ** 2)
        return np.concatenate(out)


def floor(setting: Setting, fit: Fitted) -> float:
    """Mean square error of a model that knows all but noise and disturbance [m2]."""
    parts = [Prediction(Model(fit.problem.model(fit.optimum.theta, k)[0]), target).floor_squares()
             for k, target in enumerate(targets_of(setting))]  # fmt: skip
    return float(np.mean(np.concatenate([noise + disturbed for noise, disturbed in parts])))


def closed(before: np.ndarray, after: np.ndarray, least: float) -> float:
    """Share of what lies between the squared errors before and the floor that is closed: at most 1, at the floor."""
    gap = float(np.mean(before)) - min(least, float(np.mean(after)))
    return float(np.clip((np.mean(before) - np.mean(after)) / gap, -1.0, 1.0)) if gap > 0.0 else 0.0
