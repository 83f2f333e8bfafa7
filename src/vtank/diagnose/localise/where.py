"""Where the gap lies: in which channel, run, stretch of time, frequency and region of motion.

Everything is measured after the refit of the nominal's own parameters, which hides most of a raw gap, and with the
noise level that all hypotheses share. `locate` keeps the arrays that pictures need, its document the compact summary.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..selection import Selection
from ..verdict import Verdict, probabilities
from .channel import ChannelShares, channel_shares
from .frequency import Spectrum, residual_spectra
from .gap import RunGap, run_gaps
from .region import Profile, residual_force
from .time import Windows, shares, windowed_evidence


@dataclass(frozen=True)
class WhereData:
    """The place of the gap, with the arrays behind it.

    Attributes:
        channel: force against sensor, and the probability of each channel.
        gaps: per run, simulation error before and after.
        windows: per run, evidence in windows of time.
        local: windows of a cause without a name that is there in them only.
        spectra: per run, spectrum of what the refit cannot predict.
        profiles: residual force over input, speed and place.
    """

    channel: ChannelShares
    gaps: tuple[RunGap, ...]
    windows: tuple[Windows, ...]
    local: list[dict[str, Any]]
    spectra: tuple[Spectrum, ...]
    profiles: tuple[Profile, ...]

    def document(self) -> dict[str, Any]:
        """The "where" part of a document of schema vtank.diagnosis/2."""
        evidence = max(sum(float(windows.gain.sum()) for windows in self.windows), self.windows[0].needed)
        return {
            "channel": self.channel.document(),
            "runs": [gap.document() for gap in self.gaps],
            "time_s": self.local or [span for windows in self.windows for span in windows.document()],
            "frequency_rad_s": [line.document() for spectrum in self.spectra for line in spectrum.lines],
            "region": {profile.name: profile.document(evidence) for profile in self.profiles},
        }


def locate(selection: Selection, verdict: Verdict, chances: dict[str, float] | None = None) -> WhereData:
    """Place the gap; chances: probabilities of all hypotheses where they are known already."""
    chances = probabilities(selection) if chances is None else chances
    windows = windowed_evidence(selection, verdict)
    return WhereData(
        channel_shares(selection, chances),
        run_gaps(selection, verdict, shares(windows)),
        windows,
        selection.beyond.windows() if verdict.kind == "unknown" else [],
        residual_spectra(selection),
        residual_force(selection, verdict),
    )
