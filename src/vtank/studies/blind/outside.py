"""Laws that are deliberately not in the catalogue, once for all: the right answer to them is "none of these".

Three act on the hull, three in the thrust, three in the sensors. All are guesses in form and size, chosen to be
plausible in a tank and different from every law of `vtank.effects`. Random ones are drawn in `generator.py`.
"""

from __future__ import annotations

from .laws import ABOVE, DAY, EVEN, LAGGED, PLAY, SINE, SUMMED, THRUST, A, Factor, Law, N, U, X

OUTSIDE: dict[str, Law] = {
    law.name: law
    for law in (
        # wave making of a hull near the surface: half the quadratic drag at 0.25 m/s
        Law("cubic_drag", "force", -0.04, 4.0, (Factor(U, 0.2, c=3.0),)),
        # drag drops above a critical speed, where the boundary layer turns turbulent
        Law("drag_crisis", "force", 0.03, 2.5, (Factor(U, 0.2, c=2.0), Factor(U, bent=ABOVE, c=0.15, w=0.04))),
        # added mass that grows with speed, on the acceleration of the tick before: by a half at 0.3 m/s
        Law("speed_inertia", "force", -0.5, 1.5, (Factor(U, 0.3, bent=EVEN, c=2.0), Factor(A))),
        # the propeller pushes more while it speeds up than while it slows down
        Law("thrust_hysteresis", "thrust", 0.2, 4.0, (Factor(THRUST, bent=EVEN), Factor(N, 1.0, PLAY, 2.0))),
        # two propellers whose speeds differ by a sixtieth drift in and out of step, and the thrust beats
        Law("propeller_beat", "thrust", 0.1, 4.0, (Factor(THRUST), Factor(N, 1.0, SUMMED, 1.0, SINE, 60.0, 0.0))),
        # the slipstream goes round the tank and comes back against the hull some seconds later
        Law("returning_wash", "thrust", -0.3, 2.0, (Factor(THRUST, 1.0, LAGGED, 8.0),)),
        # ranges bent by temperature layers: 1 cm at 0.3 m
        Law("sonar_bend", "range", 0.01, 6.0, (Factor(X, 0.3, c=3.0),)),
        # the sound's path is bent by the day's warming
        Law("sonar_warming", "range", 0.01, 6.0, (Factor(DAY, 240.0),)),
        # the tachometer reads low where its brushes lose contact
        Law("tachometer_brushes", "tachometer", -1.0, 1.0, (Factor(N), Factor(N, bent=ABOVE, c=3.0, w=-0.1))),
    )
}
