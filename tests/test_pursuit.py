"""The numbers of the pursuit against plain dense algebra: marginal likelihoods, after additions, with rows left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from recorded import NOISE, NOISE_M, NOMINAL, record, recordings, sine
from scipy.stats import multivariate_normal

from vtank.diagnose.evidence import Fitted, evaluate
from vtank.diagnose.freeform import pursuit as made
from vtank.diagnose.freeform.dictionary import PROBE_M_S2
from vtank.diagnose.freeform.functions import FUNCTIONS, LENGTH, PRODUCTS, functions_of, products_of
from vtank.diagnose.freeform.motion import faded
from vtank.diagnose.freeform.pursuit import SIZES, Freeform, _Group, _Pursuit, _Tried, evidence, pursue, solve, spans
from vtank.diagnose.hypothesis import Hypothesis
from vtank.diagnose.score import Linearised
from vtank.diagnose.selection import prepare


@pytest.fixture(scope="module")
def fit() -> Fitted:
    """Two short runs that lack a force in place of the first and a line of the second: something for every kind."""
    drives = ((0.9, 12.0, lambda t, u, n: 0.02 * (9.0 < t < 15.0)), (0.6, 9.0, lambda t, u, n: 0.02 * np.sin(1.7 * t)))
    runs = [record(f"run_{k}", sine(w, n, 30.0), NOMINAL, NOISE_M, k, push) for k, (w, n, push) in enumerate(drives)]
    return evaluate(prepare(runs, NOMINAL).with_noise(NOISE), Hypothesis())


@pytest.fixture(scope="module")
def found(fit: Fitted) -> Freeform:
    """What is found missing there."""
    return pursue(fit)


@pytest.fixture(scope="module")
def right() -> _Pursuit:
    """Two runs that lack nothing."""
    return _Pursuit(evaluate(prepare(recordings()[:2], NOMINAL).with_noise(NOISE), Hypothesis()))


def log_density(near: Linearised, *added: tuple[np.ndarray, float]) -> float:
    """Log density of the innovations with parameters and coefficients of the added columns integrated out, densely."""
    prior, J = near.fit.prior, near.jacobian
    covariance = np.eye(J.shape[0]) + (J * prior.sd**2) @ J.T
    for C, size in added:
        covariance += size**2 * C @ C.T
    # innovations at the optimum theta: r(true) = r + J (true - theta) is white noise, and true is normal about the mean
    return float(multivariate_normal.logpdf(near.residual, -J @ (prior.mean - near.fit.optimum.theta), covariance))


def gains(near: Linearised, C: np.ndarray, *before: tuple[np.ndarray, float]) -> tuple[float, float]:
    """Log evidence of a group on top of others, the size integrated over its grid, and the size that suits best."""
    taken = [near.jacobian, *(columns for columns, _ in before)]
    weight = np.concatenate([near.fit.prior.weight, *(np.full(c.shape[1], s**-2.0) for c, s in before)])
    J = np.hstack(taken)
    rest = C - J @ np.linalg.solve(J.T @ J + np.diag(weight), J.T @ C)
    sizes = SIZES / np.sqrt(np.trace(C.T @ rest))
    each = np.array([log_density(near, *before, (C, size)) for size in sizes]) - log_density(near, *before)
    return float(np.logaddexp.reduce(each) - np.log(SIZES.size)), float(sizes[np.argmax(each)])


def gain_above(near: Linearised, C: np.ndarray, level: float, *before: tuple[np.ndarray, float]) -> float:
    """Log evidence of a group on top of others where white noise has another level: of its pull, a normal vector."""
    J = np.hstack([near.jacobian, *(columns for columns, _ in before)])
    weight = np.concatenate([near.fit.prior.weight, *(np.full(c.shape[1], s**-2.0) for c, s in before)])
    offset = np.zeros(weight.size)
    offset[: near.fit.prior.weight.size] = near.fit.prior.weight * (near.fit.optimum.theta - near.fit.prior.mean)
    inner = J.T @ J + np.diag(weight)
    pull = C.T @ (near.residual - J @ np.linalg.solve(inner, J.T @ near.residual + offset)) / level
    S = C.T @ (C - J @ np.linalg.solve(inner, J.T @ C)) / level
    own = multivariate_normal.logpdf(pull, cov=S)
    each = [multivariate_normal.logpdf(pull, cov=S + s**2 * S @ S) - own for s in SIZES / np.sqrt(np.trace(S))]
    return float(np.logaddexp.reduce(each) - np.log(SIZES.size))


def test_evidence_is_that_of_a_gaussian_linear_model() -> None:
    """Twelve numbers, three coefficients of one size, two nuisance parameters held by priors."""
    rng = np.random.default_rng(4)
    r, J, groups = 2.0 * rng.normal(size=12), rng.normal(size=(12, 2)), rng.normal(size=(5, 12, 3))
    prior = np.array([0.5, 2.0])
    white = np.eye(12) + (J * prior**2) @ J.T
    still = np.linalg.inv(white)
    A = np.array([C.T @ still @ C for C in groups])
    b = np.array([-C.T @ still @ r for C in groups])
    found, sizes = evidence(A, b, np.sum(groups**2, axis=(1, 2)))
    for C, left, gain, size in zip(groups, A, found, sizes, strict=True):
        tried = SIZES / np.sqrt(np.trace(left))
        each = [multivariate_normal.logpdf(r, cov=white + s**2 * C @ C.T) for s in tried]
        each = np.array(each) - multivariate_normal.logpdf(r, cov=white)
        assert gain == pytest.approx(np.logaddexp.reduce(each) - np.log(SIZES.size), rel=1e-9)
        assert size == pytest.approx(tried[np.argmax(each)])


def test_what_the_parameters_take_up_has_no_evidence() -> None:
    A, raw = 1e-6 * np.eye(2)[None], np.array([1.0])
    assert evidence(A, np.ones((1, 2)), raw)[0][0] == -np.inf


@pytest.mark.parametrize("number", [np.nan, np.inf])
def test_what_makes_the_motion_run_away_has_no_evidence(number: float) -> None:
    """And takes none from the others."""
    A = np.array([np.eye(2), number * np.ones((2, 2)), np.eye(2)])
    b = np.array([[8.0, 0.0], [1.0, 1.0], [number, 0.0]])
    gains, sizes = evidence(A, b, np.full(3, 2.0))
    assert gains[0] == evidence(A[:1], b[:1], np.full(1, 2.0))[0][0] > 0.0
    assert list(gains[1:]) == [-np.inf, -np.inf] and np.all(np.isfinite(sizes))


def leaders(pursuit: _Pursuit) -> dict[str, list[tuple[float, float, _Group]]]:
    """Of every piece, and of the terms by run, the group with the most evidence, before what it pays for the search."""
    tried: dict[str, list[_Tried]] = {kind: [] for kind in ("window", "event", "stall", "function", "line")}
    tried["by run"] = pursuit._by_run()
    for i, piece in enumerate(pursuit.pieces):
        tried[piece.kind].append(pursuit._windows(i) if piece.kind == "window" else pursuit._groups(i))
    best = {kind: [(one, int(np.argmax(one.gains))) for one in some] for kind, some in tried.items() if some}
    return {kind: [(one.gains[j], one.sizes[j], one.group(j)) for one, j in some] for kind, some in best.items()}


@pytest.mark.slow
def test_every_kind_of_group_has_the_evidence_of_dense_algebra_also_after_two_additions(fit: Fitted) -> None:
    pursuit = _Pursuit(fit)
    before: list[tuple[np.ndarray, float]] = []
    for _ in range(3):
        found = leaders(pursuit)
        assert {len(some) > 0 for some in found.values()} == {True}
        for kind, some in found.items():
            for gain, size, group in sorted(some, key=lambda one: -one[0])[:2]:
                dense, suits = gains(pursuit.near, pursuit._columns_of(group), *before)
                if lines := group.piece.lines:  # which of all frequencies it is was paid for
                    own = int(np.argmin(np.abs(lines.rad_s - group.frequency)))
                    dense += lines.log_share[own]
                    if lines.level[own] > 1.0:  # it has to stand above what is beside it
                        above = gain_above(pursuit.near, pursuit._columns_of(group), lines.level[own], *before)
                        assert gain == pytest.approx(above + lines.log_share[own], abs=1e-4 + 1e-5 * abs(dense))
                        continue
                if kind == "event":  # by ranks, if that is less
                    assert gain <= dense + 1e-4 + 1e-5 * abs(dense)
                    continue
                assert gain == pytest.approx(dense, abs=1e-4 + 1e-5 * abs(dense))
                assert size == pytest.approx(suits, rel=1e-6)
        gain, size, group, together = pursuit.best()
        blunt = max(max(one[0] for one in some) - paid(pursuit, kind) for kind, some in found.items())
        if group.columns is None:
            assert gain == pytest.approx(blunt) and together >= gain
        else:  # a window with sharp ends, which pays for each time that they were sought
            dense, _ = gains(pursuit.near, pursuit._columns_of(group), *before)
            looked = (dense - gain - paid(pursuit, "window")) / (2.0 * np.log(2 * made.SHARPER))
            assert gain > blunt and looked == pytest.approx(round(looked), abs=1e-3) and 1 <= round(looked) <= 2
        pursuit.add(group, gain, size)
        before.append((pursuit._columns_of(group), size))
    assert len({one[0].kind for one in pursuit.found}) > 1 and len(pursuit.found) == 3


def paid(pursuit: _Pursuit, kind: str) -> float:
    """What a group pays for all that were looked through beside it."""
    if kind == "by run":
        count = sum(one.looked for one in pursuit._by_run())
    else:
        some = [i for i, piece in enumerate(pursuit.pieces) if piece.kind == kind]
        count = sum((pursuit._windows(i) if kind == "window" else pursuit._groups(i)).looked for i in some)
    return float(np.log(len(made.KINDS) * count))


def test_what_is_found_is_solved_as_least_squares_with_priors_would(fit: Fitted, found: Freeform) -> None:
    """Also with a third of the measurements left out."""
    assert len(found.components) >= 2
    near, count = found.near, found.near.residual.size
    for keep in (np.ones(count, bool), np.arange(count) % 3 != 1):
        shift, parts = solve(near, found.components, keep)
        J = np.hstack([near.jacobian, *(c.columns for c in found.components)])[keep]
        sd = np.concatenate([fit.prior.sd, *(np.full(c.columns.shape[1], c.deviation) for c in found.components)])
        mean = np.zeros(sd.size)
        mean[: shift.size] = fit.prior.mean - fit.optimum.theta
        stacked, target = np.vstack([J, np.diag(1.0 / sd)]), np.concatenate([-near.residual[keep], mean / sd])
        scale = np.linalg.norm(stacked, axis=0)
        expected = np.linalg.lstsq(stacked / scale, target, rcond=None)[0] / scale
        spread = np.sqrt(np.diag(np.linalg.inv((stacked / scale).T @ (stacked / scale)))) / scale
        solution = np.concatenate([shift, *(part for part, _ in parts)])
        np.testing.assert_allclose((solution - expected) / spread, 0.0, atol=1e-4)
        np.testing.assert_allclose(np.concatenate([sd for _, sd in parts]), spread[shift.size :], rtol=1e-4)


def test_rows_left_out_have_no_say(found: Freeform) -> None:
    """The same as if they had never been recorded; and only what would come again is kept."""
    near = found.near
    keep = np.arange(near.residual.size) >= 300
    fewer = Linearised(near.fit, near.residual[keep], near.jacobian[keep])
    cut = [replace(c, columns=c.columns[keep]) for c in found.components]
    (shift, parts), (expected, others) = solve(near, found.components, keep), solve(fewer, cut)
    np.testing.assert_allclose(shift, expected, rtol=1e-9)
    np.testing.assert_allclose(np.concatenate([p for p, _ in parts]), np.concatenate([p for p, _ in others]))
    wild = replace(found, near=replace(near, residual=np.where(keep, near.residual, 1e3)))
    np.testing.assert_allclose(wild.without(keep).shift, shift, rtol=1e-9)
    assert all(c.kind == "function" for c in found.without(keep).components)


def test_columns_are_the_change_of_the_innovations(fit: Fitted, found: Freeform) -> None:
    """A small coefficient's force, simulated, moves the innovations as its columns say."""
    force = next(c for c in found.components if c.force)
    coefficient = PROBE_M_S2 * np.ones(force.columns.shape[1]) / np.max(np.abs(np.vstack(force.functions)))
    push = tuple(functions @ coefficient for functions in force.functions)
    there = replace(fit.problem, forcing=push).residuals(fit.optimum.theta, fit.filtered)
    change = there - fit.problem.residuals(fit.optimum.theta, fit.filtered)
    expected = force.columns @ coefficient
    assert np.linalg.norm(change - expected) < 0.01 * np.linalg.norm(expected)


@pytest.mark.parametrize("about", made.OWN)
def test_own_terms_are_the_derivative_of_what_they_are_called_after(right: _Pursuit, about: str) -> None:
    """In all bins of all runs together, they move the innovations as the parameter itself does."""
    pursuit, fit = right, right.near.fit
    groups = [one.group(0) for one in pursuit._by_run()]
    own, *single = [group for group in groups if group.kind == "run" and group.piece.about == about]
    change = pursuit._columns_of(own).sum(axis=1)
    alone = np.hstack([pursuit._columns_of(group) for group in single])  # the same, run by run
    np.testing.assert_allclose(pursuit._columns_of(own), alone, rtol=1e-9, atol=1e-12)
    i = fit.problem.free.index(made.OWN[about])
    value = fit.optimum.theta[i]
    factor = {"drag": 1.0, "thrust": value, "lag": -1.0}[about]  # of the term over the derivative
    derivative = factor * pursuit.near.jacobian[:, i]
    assert np.linalg.norm(change - derivative) < 0.1 * np.linalg.norm(derivative)  # held over 0.1 s


def test_windows_are_of_every_place() -> None:
    found = {tuple(span) for span in spans(5)}
    assert found == {(j, j + n) for n in (1, 2, 3, 4) for j in range(6 - n)}
    assert spans(1).shape == (0, 2)


def test_functions_are_those_of_a_smooth_process() -> None:
    """Their covariance is the Matern process', but for the little that was cut off."""
    share = np.linspace(0.0, 1.0, 33)
    columns = functions_of(share)
    d = np.sqrt(3.0) * np.abs(share[:, None] - share) / LENGTH
    assert columns.shape == (33, FUNCTIONS)
    kernel = (1.0 + d) * np.exp(-d)
    assert np.trace(kernel - columns @ columns.T) < 0.01 * 33.0
    assert np.max(np.abs(kernel - columns @ columns.T)) < 0.05
    between = functions_of(np.array([0.515625]))
    np.testing.assert_allclose(between, 0.5 * (columns[16] + columns[17])[None])
    both = products_of(columns, columns[::-1])
    assert both.shape == (33, PRODUCTS)
    square = np.einsum("ik,jl->ijkl", columns, columns).reshape(33 * 33, -1)
    kept = products_of(np.repeat(columns, 33, axis=0), np.tile(columns, (33, 1)))
    assert np.sum(kept**2) > 0.92 * np.sum(square**2)


def test_memory_fades_exponentially_at_any_rate() -> None:
    time = np.cumsum(np.random.default_rng(0).uniform(0.01, 0.3, 200))
    step = np.where(time > time[0], 1.0, 0.0)
    np.testing.assert_allclose(faded(time, step, 4.0), 1.0 - np.exp(-(time - time[0]) / 4.0), atol=1e-12)
