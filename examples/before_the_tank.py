"""Before a tank is booked: what a plan of runs can tell, which effects it can tell apart, and which run would help."""

from vtank.studies.design import examine, write_findings

found = examine(["paper-ds1", "paper-ds4"], truth="paper-ii", settings=["duration_s=60"])
for sentence in found.sentences():
    print("-", sentence)

study = found.study
for name, relative in zip(study.free, study.relative, strict=True):
    print(f"{name}: no unbiased estimator gets below {100 * relative:.2g} %")
write_findings("plan", found)
