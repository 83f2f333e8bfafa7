# A recording and a simulator that part: what drives the gap, and a second recording to hold the answer to.
# The cells run in Jupyter (through jupytext), VS Code and Spyder, or all together as a script.

# %% The vehicle: recordings whose cause is withheld
import vtank as vt

withheld = ["effects.linear_drag.c_per_s=0.15", "duration_s=60"]
runs = vt.run("paper-ds1", "paper-ds3", "paper-ds4", seed=1, settings=withheld)
first = runs[0]
first

# %% Its parameters, by maximum likelihood: drag, thrust and lag as if there were nothing else
fit = vt.identify(runs, model="II")
fit

# %% The simulator, paper-ii, beside them: how large is the gap, what is it made of, what causes it?
found = vt.diagnose(runs, nominal="paper-ii")
print(found)
found

# %% The report, and the corrected simulator as a file
found.report("gap.html")
found.save("gap.toml")

# %% A second recording, which the diagnosis has not seen
second = vt.run("paper-ds2", seed=2, settings=withheld)[0]
second

# %% The simulator before and after, along it
error = vt.predict("gap.toml", second)["rms"]
print(f"a second recording: {error['nominal']:.4f} m before, {error['diagnosed']:.4f} m after")
