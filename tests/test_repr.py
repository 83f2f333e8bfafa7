"""What a terminal shows of the objects a user holds: a line or a few, not their arrays."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from recorded import NOMINAL, recordings

from vtank.diagnose.diagnosis import diagnose
from vtank.estimate.maximum_likelihood import identify
from vtank.record import Run
from vtank.record.dataset import DataSet


def test_reprs_are_short_and_say_what_it_is() -> None:
    runs = recordings()[:1]
    found = diagnose(runs, NOMINAL, names=("linear_drag",))
    run = Run("lake", np.arange(30.0), {"n_rev_s": np.ones(30), "range_m": np.ones(30)})
    texts = {
        repr(found): "Diagnosis(none, 1.",
        repr(found.verdict): "Verdict(kind='none'",
        repr(runs[0]): "Observed(run_0: ",
        repr(found.selection): "Selection(best of 3 hypotheses: none; run_0)",
        repr(identify(runs, "II", process_noise=False)): "Estimate(alpha = -2.",
        repr(run): "Run('lake', 30 rows, 0 to 29 s: n_rev_s, range_m)",
        repr(DataSet(Path("data"), (run,))): "DataSet('data', 1 runs: lake)",
    }
    for text, said in texts.items():
        assert text.startswith(said) and len(text) < 200, text
