"""Diagnose an effect that the simulator does not know, and fly the corrected simulator."""

import vtank as vt

# The "real" vehicle has linear drag; the nominal simulator, paper-ii, has none.
drag = ["effects.linear_drag.c_per_s=0.15", "duration_s=60"]
runs = vt.run("paper-ds1", "paper-ds3", "paper-ds4", seed=1, settings=drag)
unseen = vt.run("paper-ds2", seed=2, settings=drag)[0]

found = vt.diagnose(runs, nominal="paper-ii")
print(found)
found.report("gap.html")
found.save("gap.toml")

errors = vt.predict("gap.toml", unseen)
print(f"a run never seen: {errors['rms']['nominal']:.4f} m before, {errors['rms']['diagnosed']:.4f} m after")

corrected = vt.run("paper-ds2", truth="gap.toml", seed=2, settings=drag[1:])[0]  # the tank with the effect switched on
apart = abs(corrected.columns["range_m"] - unseen.columns["range_m"]).max()
print(f"corrected simulator and vehicle are {apart:.3f} m apart at most")
