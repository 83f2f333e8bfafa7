"""All effects, in the fixed order of the parameter vector."""

from __future__ import annotations

from . import (
    ambient_current,
    clock_skew,
    command_delay,
    coulomb_friction,
    drag_asymmetry,
    linear_drag,
    seiche,
    sonar_latency,
    sonar_multipath,
    sonar_offset,
    sonar_scale,
    supply_sag,
    tachometer_bias,
    tachometer_spikes,
    tether,
    thrust_asymmetry,
    thrust_deadband,
    thrust_lag,
    thrust_loss,
    thrust_saturation,
    wake_memory,
    wall_proximity,
)
from .effect import Effect

CATALOGUE: tuple[Effect, ...] = (
    linear_drag.EFFECT,
    coulomb_friction.EFFECT,
    ambient_current.EFFECT,
    seiche.EFFECT,
    wall_proximity.EFFECT,
    tether.EFFECT,
    drag_asymmetry.EFFECT,
    wake_memory.EFFECT,
    thrust_deadband.EFFECT,
    thrust_asymmetry.EFFECT,
    thrust_loss.EFFECT,
    thrust_lag.EFFECT,
    thrust_saturation.EFFECT,
    supply_sag.EFFECT,
    command_delay.EFFECT,
    sonar_latency.EFFECT,
    sonar_multipath.EFFECT,
    sonar_scale.EFFECT,
    sonar_offset.EFFECT,
    tachometer_bias.EFFECT,
    tachometer_spikes.EFFECT,
    clock_skew.EFFECT,
)

BY_NAME: dict[str, Effect] = {effect.name: effect for effect in CATALOGUE}
