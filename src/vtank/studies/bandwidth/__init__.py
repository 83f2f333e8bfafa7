"""What the surge controller can follow and withstand: closed-loop response, and station keeping in waves."""

from __future__ import annotations

from ...record.folder import Kind

RESULTS = Kind("results of vtank bandwidth", "bandwidth.json", "vtank.bandwidth/1")
