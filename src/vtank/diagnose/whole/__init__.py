"""Diagnosis of a whole vehicle: which effect at which axis, thruster or sensor parts recordings from its simulator."""

from .diagnosis import WholeDiagnosis, diagnose

__all__ = ["WholeDiagnosis", "diagnose"]
