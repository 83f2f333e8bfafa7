"""Fly two experiments in the virtual tank and identify the surge model from them, beside the truth."""

import vtank as vt

runs = vt.run("paper-ds1", "paper-ds4", seed=1, settings=["duration_s=60"], out="data")
fit = vt.identify(runs, model="II")

truth = vt.load_truth("paper-ii")
known = {"alpha": truth.alpha_per_m, "beta": truth.beta_m_per_rev2, "thrust_lag.tau": truth.tau_s}
for name, value in fit.values.items():
    print(f"{name:15} {value:10.4g} +- {fit.sd[name]:.2g}   truth {known[name]:.4g}")
