"""A recording held against the vehicle that it is said to be of: its thrusters, its fins, its sensors."""

from __future__ import annotations

from ..errors import InputError
from ..record.columns import FIXED, NAMED
from ..record.run import Run
from ..record.toml import meant
from .actuators import INPUTS
from .vehicle import Vehicle


def check_recorded(run: Run, vehicle: Vehicle) -> None:
    """InputError for a column of a thruster, a fin or a sensor that the vehicle file has not, with the nearest.

    And for a thruster that is recorded, but not by the input from which the file knows its force.
    """
    for name in run.columns:
        sensor, dot, channel = name.rpartition(".")
        if dot:
            _check_sensor(run, vehicle, name, sensor, channel)
    check_inputs(run, vehicle)
    for thruster in vehicle.thrusters:
        name = thruster.name
        found = [column for kind in INPUTS if (column := f"{name}_{kind}") in run.columns]
        if found and thruster.column not in found:
            expected = f"{vehicle.path} knows its force from {thruster.column}, by gain or curve"
            raise InputError(f"{_where(run, found[0])}: {expected}; found {' and '.join(found)} alone")


def check_inputs(run: Run, vehicle: Vehicle) -> None:
    """InputError for the input of a thruster or fin that the vehicle file has not, with the nearest."""
    for name in run.columns:
        if "." not in name and name not in FIXED:
            _check_input(run, vehicle, name)


def _check_sensor(run: Run, vehicle: Vehicle, name: str, sensor: str, channel: str) -> None:
    sensors = {each.name: each for each in vehicle.sensors}
    if sensor not in sensors:
        raise InputError(f"{_where(run, name)}: {vehicle.path} has no sensor '{sensor}'{meant(sensor, sensors)}")
    if channel not in sensors[sensor].channels:
        known = meant(channel, sensors[sensor].channels)
        raise InputError(f"{_where(run, name)}: sensor.{sensor} of {vehicle.path} has no channel '{channel}'{known}")


def _check_input(run: Run, vehicle: Vehicle, name: str) -> None:
    """A name that ends as an input or a current does; the inputs of runs along one axis belong to no thruster."""
    ending = next((each for each in NAMED if name.endswith(each) and name != each), "")
    owner = name.removesuffix(ending)
    if not ending or owner in ("n", "thrust"):
        return
    columns = {thruster.name: thruster.column for thruster in vehicle.thrusters}
    columns |= {fin.name: fin.column for fin in vehicle.fins}
    if owner not in columns:
        raise InputError(f"{_where(run, name)}: {vehicle.path} has no thruster or fin '{owner}'{meant(owner, columns)}")


def _where(run: Run, name: str) -> str:
    return f"run {run.name}, column {name}"
