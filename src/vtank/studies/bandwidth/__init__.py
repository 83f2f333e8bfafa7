"""What the surge controller can follow and withstand: closed-loop response, and station keeping in waves."""

from __future__ import annotations
