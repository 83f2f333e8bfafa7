"""Bring a log of your own: other columns, other units, channels with clocks of their own."""

import csv

import numpy as np

import vtank as vt

# A log as a vehicle might write it: milliseconds, revolutions per minute at 10 Hz, sonar in centimetres at 5 Hz.
flown = vt.run("multisine", seed=3, simulator="surge", settings=["duration_s=90"])[0]
with open("log.csv", "w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(("ms", "rpm", "sonar_cm"))
    for k, t in enumerate(flown.time_s):
        sonar = f"{100 * flown.columns['range_m'][k]:.1f}" if k % 2 == 0 else ""
        writer.writerow((round(1000 * t), f"{60 * flown.columns['n_rev_s'][k]:.0f}", sonar))

log = np.genfromtxt("log.csv", delimiter=",", names=True)
time_s, heard = log["ms"] / 1000.0, ~np.isnan(log["sonar_cm"])
run = vt.Run.from_channels(
    "log",
    {
        "n_rev_s": (time_s, log["rpm"] / 60.0),
        "range_m": (time_s[heard], log["sonar_cm"][heard] / 100.0),
    },
)
fit = vt.identify([run], model="II")
print({name: f"{value:.4g} +- {fit.sd[name]:.2g}" for name, value in fit.values.items()})
