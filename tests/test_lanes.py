"""Functions of math on lanes: what the library gives for each number, to the last bits."""

from __future__ import annotations

import math

import numba
import numpy as np
import pytest

from vtank.lanes import WIDTH, load, store

FUNCTIONS = {
    "exp": (lambda x: math.exp(x), np.exp),
    "sin": (lambda x: math.sin(x), np.sin),
    "cos": (lambda x: math.cos(x), np.cos),
    "tanh": (lambda x: math.tanh(x), np.tanh),
    "sqrt": (lambda x: math.sqrt(x), np.sqrt),
    "log": (lambda x: math.log(x), np.log),
    "cube": (lambda x: x**3, lambda x: x**3),
    "signed": (lambda x: math.copysign(3.0, x), lambda x: np.copysign(3.0, x)),
    "power": (lambda x: abs(x) ** 1.85, lambda x: np.abs(x) ** 1.85),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_function_of_math_is_that_of_the_library_on_every_lane(name: str) -> None:
    own, library = FUNCTIONS[name]
    f = numba.njit(own, error_model="numpy")

    @numba.njit(error_model="numpy")
    def on_lanes(a: np.ndarray, out: np.ndarray) -> None:
        for i in range(a.shape[0]):
            store(out, i, f(load(a, i)))

    sizes = np.array([1e-6, 1e-2, 1.0, 30.0, 600.0, 1e4, 1e8])[:, None, None]  # one size to a row: no lane is far out
    values = (sizes * np.random.default_rng(5).normal(size=(7, 40, WIDTH))).reshape(-1, WIDTH)
    odd = np.resize([0.0, np.nan, np.inf, -np.inf, 0.5 * np.pi, -700.0, 709.0, 1e7], (1, WIDTH))
    values = np.vstack([values, odd])
    out = np.empty_like(values)
    on_lanes(values, out)
    with np.errstate(all="ignore"):
        expected = library(values)
    assert np.array_equal(np.isnan(out), np.isnan(expected))
    assert out == pytest.approx(expected, rel=4e-16, abs=4e-16, nan_ok=True)
