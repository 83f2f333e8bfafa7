"""The gap diagnosis: where the sim-to-real gap lies, which effect causes it, and how far it shrinks."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..facade import facade

if TYPE_CHECKING:
    from .diagnosis import Diagnosis, diagnose
    from .experiments import recorded, with_channels
    from .holdout import Model, Prediction, fraction_closed, rms, target_of
    from .model_file import ModelFile, model_text, read_model

__all__ = facade(__name__)
