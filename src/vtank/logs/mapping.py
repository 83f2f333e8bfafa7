"""What a log's fields become: channels, the pulses of motors, and what tells that these were armed."""

from __future__ import annotations

from collections.abc import Mapping as Dictionary
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path

from ..record.columns import column
from .units import factor

PRESETS = Path(__file__).parent / "presets"
HEADER = "header"  # the preset of tables, which is no file
SINGLE_AXIS = {"n_rev_s": "rev/s", "command": "-", "thrust_N": "N"}  # inputs of a run along one axis
WGS84 = "WGS84"


@dataclass(frozen=True)
class Pulses:
    """What a pulse length [us] asks of a motor, where no parameter of the vehicle says otherwise.

    Attributes:
        stop_us, full_us: at rest and at full command ahead [us].
        one_way: whether all that is shorter than at rest is rest.
    """

    stop_us: float
    full_us: float
    one_way: bool


@dataclass(frozen=True)
class Channel:
    """Fields of a message that become columns.

    Attributes:
        message: its name or topic, * for anything; "" where `type` decides.
        type: of the message, "" for any.
        fields, columns: of the log and of the run.
        unit: of the log.
        scale, offset: laid over the value in the column's unit.
        frame: of vectors and attitude; "" for plain numbers.
        where: field -> number, which a message must have.
        output: number of an actuator's output, 0 where the outputs are not counted.
        parameters: "stop_us", "full_us", "sign" (1 or -1), "function" (what an output drives) -> name of the vehicle's
            parameter, with {n} for the output and {motor} for the motor.
        motor_function: of the first motor.
        pulses: how pulse lengths become commands; None for other units.
        optional: whether the log need not have it, as that of a preset.
    """

    message: str
    type: str
    fields: tuple[str, ...]
    columns: tuple[str, ...]
    unit: str = ""
    scale: float = 1.0
    offset: float = 0.0
    frame: str = ""
    where: Dictionary[str, float] = field(default_factory=dict)
    output: int = 0
    parameters: Dictionary[str, str] = field(default_factory=dict)
    motor_function: int = 0
    pulses: Pulses | None = None
    optional: bool = False

    def takes(self, name: str, kind: str) -> bool:
        """Whether it is made of such a message."""
        return fnmatchcase(name, self.message or "*") and (not self.type or kind == self.type)

    def factor(self, place: int) -> float:
        """By what a number of the log is multiplied to be in the unit of a column."""
        found = factor(self.unit, column_unit(self.columns[place])) if self.unit else 1.0
        return self.scale * (1.0 if found is None else found)


@dataclass(frozen=True)
class Armed:
    """What tells whether the vehicle's motors were allowed to turn: a field of a message, one bit of it or one value.

    `changes`: whether the message comes when that changes, so that one of them means that they were at some time.
    """

    message: str
    field: str
    where: Dictionary[str, float]
    bit: int
    value: float
    changes: bool


@dataclass(frozen=True)
class Mapping:
    """A mapping file.

    Attributes:
        path: of the file.
        channels: in the order of preference, where two give one column.
        several: whether two that give one column are two sensors, each with its own name before the column.
        armed: None where nothing tells it.
        time: of a table: its column of times and their unit; None where the header tells it.
        preset: whether vtank made it.
        header: whether the header of a table gives what the channels do not.
    """

    path: Path
    channels: tuple[Channel, ...]
    several: bool = False
    armed: Armed | None = None
    time: tuple[str, str] | None = None
    preset: bool = False
    header: bool = False

    def wanted(self, name: str, kind: str) -> tuple[str, ...]:
        """The fields of a message that are needed; none for a message that is not."""
        found: dict[str, None] = {}
        for channel in self.channels:
            if channel.takes(name, kind):
                found |= dict.fromkeys((*channel.fields, *channel.where))
        if self.armed and self.armed.message == name:
            found |= dict.fromkeys((self.armed.field, *self.armed.where))
        return tuple(found)


def column_unit(name: str) -> str:
    """The unit of a column of a run."""
    found = column(name)
    return SINGLE_AXIS.get(name) or (found.unit if found else "-")
