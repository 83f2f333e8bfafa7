"""What flights would tell: distances between hypotheses before a flight, and the doubt that they take away."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_rigid_motion import multisine

from vtank.diagnose.whole import Foreseen, Hypothesis, drop_of_doubt, foreseen, possible
from vtank.experiment.whole import fly_vehicle
from vtank.plant import load_vehicle
from vtank.rigid.fit import Fit
from vtank.rigid.noise import first_noise
from vtank.rigid.recordings import record

FILE = load_vehicle("bluerov2")
VEHICLE = replace(FILE, sensors=tuple(s for s in FILE.sensors if s.name in ("imu", "dvl")))
SOME = ("linear_drag", "coulomb_friction", "thruster_dead", "thruster_reversed")


@pytest.fixture(scope="module")
def flight():
    """20 s of the nominal."""
    return fly_vehicle(VEHICLE, multisine(FILE, 20.0, 3), 20.0, 3)


def told(flight, share: float) -> tuple[list[Hypothesis], Foreseen]:
    hypotheses = possible(VEHICLE, [flight], SOME, share)
    return hypotheses, foreseen(VEHICLE, [flight], hypotheses)[0]


@pytest.fixture(scope="module")
def small(flight) -> tuple[list[Hypothesis], Foreseen]:
    return told(flight, 0.1)


def at(hypotheses: list[Hypothesis], name: str) -> int:
    return [h.name for h in hypotheses].index(name)


def test_what_a_hypothesis_changes_is_what_its_simulation_does(flight, small) -> None:
    hypotheses, seen = small
    i = at(hypotheses, "linear_drag@yaw")
    layout, runs, _ = record([flight], VEHICLE)
    noise = replace(first_noise(runs), sigma=np.full(6, 1e-3))
    fit = Fit(runs, noise)
    sides = [layout.null, layout.vector(dict(hypotheses[i].values))]
    exact = np.diff(fit.residuals(sides, fit.filter(layout.null)), axis=1)
    assert np.sqrt(seen.gram[seen.at[i], seen.at[i]]) == pytest.approx(np.linalg.norm(exact), rel=0.05)


def test_own_parameters_take_part_of_an_effect_and_the_rest_grows_with_it(flight, small) -> None:
    hypotheses, seen = small
    i, apart = at(hypotheses, "linear_drag@yaw"), seen.apart(hypotheses)
    assert 0.0 < apart[i, 0] < np.sqrt(seen.gram[seen.at[i], seen.at[i]])
    twice, again = told(flight, 0.2)
    assert again.apart(twice)[i, 0] == pytest.approx(2.0 * apart[i, 0], rel=0.02)
    assert (seen + seen).apart(hypotheses)[i, 0] > 1.2 * apart[i, 0]


def test_a_rival_explains_no_more_than_its_bounds_allow(small) -> None:
    """A thruster that pushes the other way is none that has lost at most all of its force.

    Whatever the gains of the others, each of which may be off by a little, take up of it.
    """
    hypotheses, seen = small
    reversed_, dead = (at(hypotheses, f"{name}@thruster_1") for name in ("thruster_reversed", "thruster_dead"))
    free = tuple(replace(number, high=np.inf) for number in hypotheses[dead].numbers)
    unbounded = [replace(h, numbers=free) if i == dead else h for i, h in enumerate(hypotheses)]
    assert seen.apart(hypotheses)[reversed_, dead] > 5.0 * seen.apart(unbounded)[reversed_, dead]
    assert seen.apart(hypotheses)[dead, dead] == pytest.approx(0.0, abs=1e-6)


def test_bounds_are_never_above_the_prior_and_are_it_where_nothing_is_told(small) -> None:
    _, seen = small
    prior = np.diag(np.diag(seen.gram[seen.own, seen.own]))
    assert np.all(seen.bounds(prior) < np.diag(prior) ** -0.5)
    blind = replace(seen, gram=0.0 * seen.gram)
    assert blind.bounds(prior) == pytest.approx(np.diag(prior) ** -0.5)


def test_doubt_falls_by_no_more_than_there_is() -> None:
    def pair(d: float) -> np.ndarray:
        return np.array([[0.0, d], [d, 0.0]])

    drops = [drop_of_doubt([0.5, 0.5], pair(d)) for d in (0.0, 1.0, 3.0, 30.0)]
    assert drops[0] == 0.0 and drops == sorted(drops)
    assert drops[-1] == pytest.approx(np.log(2.0))
    assert drop_of_doubt([0.999, 0.001], pair(30.0)) < 0.01
    assert drop_of_doubt([1.0, 1.0], pair(1.0)) == drops[1]  # in any measure
    assert drop_of_doubt([0.5, 0.5], np.array([[0.0, 30.0], [0.0, 0.0]])) == 0.0  # one of them explains the other
    assert drop_of_doubt([1.0, 0.0], pair(100.0)) == 0.0  # what is impossible leaves no doubt


def test_no_effect_is_foreseen_at_nothing(flight) -> None:
    """Where fits begin at nothing as well, as of delays, the size is that of another beginning."""
    layout, _, _ = record([flight], VEHICLE)
    for hypothesis in possible(VEHICLE, [flight])[1:]:
        changed = [v != layout.null[layout.slot(name)] for name, v in hypothesis.values.items() if name in layout.slots]
        assert not changed or any(changed), hypothesis.name
