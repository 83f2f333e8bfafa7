"""Many runs from one file: scenarios on a grid, drag drawn at random, one data set with a table of its truth."""

import csv
from pathlib import Path

from vtank.studies.campaign import Threads, fly_campaign, load_campaign

CAMPAIGN = """
model = "surge"
seed = 7
repeats = 4

[grid]
scenario = ["paper-ds1", "step-coast"]
duration_s = 20.0

[draw]
effects.linear_drag.c_per_s = { uniform = [0.0, 0.2] }
"""

Path("drag.toml").write_text(CAMPAIGN, encoding="utf-8")
tally = fly_campaign(load_campaign("drag.toml"), Path("many"), Threads(2))
print(tally.summary)
with open("many/runs.csv", encoding="utf-8", newline="") as file:
    for row in csv.DictReader(file):
        print(f"{row['run']}: {row['scenario']}, linear drag {float(row['effects.linear_drag.c_per_s']):.3f} 1/s")
