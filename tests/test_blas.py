"""One thread for linear algebra while vtank works, and as many as before afterwards."""

from __future__ import annotations

import os
import subprocess
import sys

SCRIPT = """
import numpy, scipy.linalg, threadpoolctl
from vtank.blas import one_blas_thread
from vtank import library

def threads():
    return [each["num_threads"] for each in threadpoolctl.threadpool_info() if each["user_api"] == "blas"]

print(threads(), one_blas_thread(threads)(), threads())
assert all(hasattr(getattr(library, name), "__wrapped__") for name in ("identify", "diagnose", "predict"))
"""


def test_numpy_that_was_loaded_before_works_on_one_thread() -> None:
    environment = {name: value for name, value in os.environ.items() if "_NUM_THREADS" not in name}
    environment |= {"OPENBLAS_NUM_THREADS": "2"}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
    before, during, after = done.stdout.replace("] [", "]|[").strip().split("|")
    assert set(during) <= set("[1, ]") and during.count("1") >= 1
    assert before == after and "2" in before
