"""What does not stand in memory whole is what it would be: inner products in pieces, and score tests run by run."""

from __future__ import annotations

import importlib
import os
import platform
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from test_rigid_motion import flown

from vtank.diagnose.whole.model import blank, refit
from vtank.diagnose.whole.own import own_unknowns
from vtank.diagnose.whole.score import PIECE, Base, based, promises, whitening
from vtank.rigid.filtered import give_back
from vtank.rigid.fit import Fit
from vtank.rigid.noise import first_noise
from vtank.rigid.places import Sizes, catalogue


def test_inner_products_in_pieces_are_those_of_the_whole() -> None:
    """Beside unknowns that are nearly the same, of priors far apart, which pull at the innovations' own."""
    rng, rows = np.random.default_rng(1), 2 * PIECE + 100
    J, scale = rng.normal(size=(rows, 4)), np.array([1e-4, 1.0, 1.0, 1e3])
    J[:, 2] = J[:, 1] + 1e-3 * J[:, 2]
    columns = np.column_stack([rng.normal(size=(rows, 3)), J[:, 1] + 1e-2 * rng.normal(size=rows)])
    strain = np.array([0.5, -2.0, 1.0, 0.1])
    base = Base([], columns[:, 0], J, whitening(J, scale), strain, scale)
    A = np.vstack([J * scale, np.eye(4)])
    left = np.vstack([columns, np.zeros((4, 4))])
    left[-4:, 0] = strain
    left -= A @ np.linalg.lstsq(A, left, rcond=None)[0]
    found = base.gram(np.split(columns, [100, PIECE, rows - 7]))
    np.testing.assert_allclose(found, left.T @ left, rtol=1e-8, atol=1e-9)


@pytest.fixture(scope="module")
def screened():
    """Two runs, a model of both, its linearisation, and some candidates beside it."""
    runs = tuple(flown("bluerov2", seconds) for seconds in (8.0, 12.0))
    layout = runs[0].layout
    fit = Fit(runs, first_noise(runs))
    model = blank(fit, layout, (), own_unknowns(layout, runs))
    found = fit.filter(model.vector())
    model = refit(model, found, model.theta)
    sought = [
        c for c in catalogue(layout, runs[0].moves, Sizes.unit(layout)) if c.place in ("yaw", "thruster_1", "dvl")
    ]
    return model, found, layout, sought


def test_a_score_test_is_that_of_the_whole_linear_model(screened) -> None:
    """Its gain is that of the normal density of innovations to which a number adds, own unknowns readapted.

    What the number has in common with them spares them to stand away from where they are held beforehand.
    """
    model, found, layout, sought = screened
    scale = np.array([u.scale for u in model.unknowns])
    model = replace(model, theta=model.theta + scale * np.linspace(-2.0, 3.0, scale.size))
    base = based(model, found)
    one = [c for c in sought if c.name == "linear_drag@yaw"]
    (promise,) = promises(model, base, layout, one)
    (number,) = one[0].parameters
    moved = model.vector()
    moved[layout.at(number.slots)] += 1e-3 * number.scale
    column = model.fit.answers(base.paths, [moved])[:, 0] / 1e-3

    def likely(A: np.ndarray) -> float:
        e = np.concatenate([base.e, model.theta / scale, np.zeros(A.shape[1] - scale.size)])
        A = np.vstack([A, np.eye(A.shape[1])])
        e -= A @ np.linalg.lstsq(A, e, rcond=None)[0]
        return -0.5 * float(e @ e) - 0.5 * float(np.linalg.slogdet(A.T @ A)[1])

    own = base.J * scale
    assert number.low < promise.begin[0] < number.high
    assert promise.gain == pytest.approx(likely(np.column_stack([own, column])) - likely(own), abs=0.05)


def test_score_tests_are_the_same_however_many_are_made_together(screened, monkeypatch) -> None:
    model, found, layout, sought = screened
    base = based(model, found)
    together = promises(model, base, layout, sought)
    monkeypatch.setattr(importlib.import_module("vtank.diagnose.whole.score"), "AT_ONCE", 1)
    alone = {promise.placed.name: promise for promise in promises(model, base, layout, sought)}
    assert len(together) == len(alone) > 5
    for promise in together:
        assert promise.gain == pytest.approx(alone[promise.placed.name].gain, rel=1e-9, abs=1e-6)
        assert promise.begin == pytest.approx(alone[promise.placed.name].begin, rel=1e-6, abs=1e-9)


@pytest.mark.skipif(platform.libc_ver()[0] != "glibc", reason="of glibc's heap")
def test_memory_that_is_free_goes_back_to_the_system() -> None:
    def resident() -> int:
        return int(Path("/proc/self/statm").read_text(encoding="utf-8").split()[1]) * os.sysconf("SC_PAGE_SIZE")

    block = np.ones(12_000)  # small enough to lie in the heap
    many = [block.copy() for _ in range(2000)]
    kept = many[::20]
    del many
    before = resident()
    give_back()
    assert len(kept) == 100 and resident() < before - 1000 * block.nbytes
