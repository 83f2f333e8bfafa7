"""Everything found about a plan: sentences, tables and the page."""

from __future__ import annotations

import base64
from dataclasses import dataclass

import numpy as np

from ...estimate.paper import PaperSettings
from ...present import Heading, Paragraph, Picture, Table, effect_name
from ...present.document import html
from .advice import Remedy
from .bias import BiasMap
from .design import REST_MIN, Design, minutes, summed
from .estimators import METHODS
from .profile import Profile
from .study import Study
from .tables import bounds_sheet, design_sheet, effects_sheet, trials_sheet
from .trials import Trials
from .verdicts import closest
from .words import called, sentences


@dataclass(frozen=True, eq=False)
class Findings:
    """What was looked at; parts that were not asked for are None.

    Attributes:
        checked: the Monte Carlo of the designed plan.
    """

    study: Study
    remedies: tuple[Remedy, ...]
    profiles: tuple[Profile, ...]
    trials: Trials | None = None
    bias: BiasMap | None = None
    design: Design | None = None
    checked: Trials | None = None

    def sentences(self) -> list[str]:
        """Verdicts in plain words."""
        return [*sentences(self.study, self.remedies), *self._estimators(), *self._design()]

    def sheets(self) -> list[Table]:
        """All tables."""
        found = [bounds_sheet(self.study), effects_sheet(self.study)]
        found += [trials_sheet(self.trials)] if self.trials else []
        return found + ([design_sheet(self.study, self.design)] if self.design else [])

    def _estimators(self) -> list[str]:
        if self.trials is None:
            return []
        t, likelihood = self.trials, METHODS[0]
        most, cover = 100.0 * np.abs(t.bias(likelihood)[0]).max(), 100.0 * t.coverage(likelihood)
        off = {m: ", ".join(f"{called(n)} {100.0 * b:+.0f} %" for n, b in zip(t.names, t.bias(m)[0], strict=True))
               for m in METHODS}  # fmt: skip
        wide = np.nanmedian(t.claimed["kalman"] / t.bound, axis=0)
        tau = self.study.truth.tau_s
        return [
            f"On {t.seeds} seeds the likelihood's bias stays within {most:.2g} %; its 95 % intervals hold the truth in "
            f"{cover.min():.0f} % of cases at least.",
            f"On the same recordings the paper's Kalman filter is off by {off['kalman']} (median), its two-stage form "
            f"by {off['two_stage']}, least squares by {off['least_squares']}: their regression differentiates the "
            f"sonar and steps {PaperSettings().regression_step_s:g} s at a time, with a lag of {tau:g} s.",
            f"The Kalman filter's intervals are {wide.min():.0f} to {wide.max():.0f} times as wide as the bound: "
            "what they hold says nothing about its estimates.",
        ]

    def _design(self) -> list[str]:
        if self.design is None:
            return []
        d, s = self.design, self.study
        gains = ", ".join(f"{called(n)} {g:.2g}" for n, g in zip(d.free, d.gain, strict=True))
        text = (
            f"In the same {minutes(d.given):g} min ({REST_MIN:g} min of rest a run) the designed plan's bounds are "
            f"smaller by these factors: {gains}."
        )
        if self.checked is not None and self.trials is not None:
            ratio = self.trials.spread(METHODS[0]) / self.checked.spread(METHODS[0])
            seen = ", ".join(f"{called(n)} {r:.2g}" for n, r in zip(d.free, ratio, strict=True))
            doubt = 100.0 * 0.9 * np.sqrt(1.0 / self.trials.seeds + 1.0 / self.checked.seeds)
            text += f" On {self.checked.seeds} seeds the likelihood's spread is smaller by {seen} (+- {doubt:.0f} %)."
        near = [closest(info, s.flown, s.free) for info in (s.information, summed(d.items))]
        told = [
            f"{effect_name(p.a.name)} and {effect_name(p.b.name)} ({p.separation:.0f} deviations)" for p in near if p
        ]
        if len(told) == 2:
            text += f" The closest effects are {told[1]}, by the given plan {told[0]}."
        return [text]

    def page(self, png: bytes) -> str:
        """One HTML file with the picture in it."""
        s = self.study
        title = f"Identifiability of Model {s.model}: {', '.join(f.run.name for f in s.flown)}"
        picture = Picture(f"data:image/png;base64,{base64.b64encode(png).decode()}", "Bounds, estimators and bias")
        return html(title, [Heading(title, 1), *map(Paragraph, self.sentences()), picture, *self.sheets()])
