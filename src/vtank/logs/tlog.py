"""Telemetry logs of MAVLink (*.tlog): the time of receipt in microseconds before each message as it came by radio."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from .log import Log, library
from .records import next_mark

STAMP = struct.Struct(">Q")  # of the receipt [us since 1970]
MAGIC = {0xFD: 12, 0xFE: 8}  # first byte of MAVLink 2 and 1 -> bytes of a message beside its payload
MARKS = re.compile(rb"[\xfd\xfe]")
SIGNATURE = 13  # bytes behind a signed message
AUTOPILOT = 1  # number of that component of a vehicle
GROUND = 255  # number of the ground station
SINCE_1970_US = 1e14  # above it a stamp [us] counts from 1970 and not from the start of the vehicle; 3 years after each
RESTART_S = 10.0  # [s] by which the vehicle's clock falls back where it starts again; a choice


def read(path: Path, log: Log) -> None:
    """Read a telemetry log of one vehicle; times are the vehicle's own, set against the earliest receipt.

    Messages that came late by radio keep the time at which the vehicle sent them. InputError without pymavlink.
    """
    dialect = library("pymavlink.dialects.v20.ardupilotmega", "pymavlink", f"{path}: a MAVLink log")
    log.kind = "MAVLink telemetry log"
    decoder, clock = dialect.MAVLink(None), Clock()
    vehicle = 0
    for received_s, packet in packets(path, log):
        try:
            message = decoder.decode(bytearray(packet))
        except dialect.MAVError as error:
            identity = packet[7:10] if packet[0] == 0xFD else packet[5:6]
            known = dialect.mavlink_map.get(int.from_bytes(identity, "little"))
            log.lose(known.msgname if known else "unknown message", str(error))
            continue
        name, system = message.get_type(), message.get_srcSystem()
        if name in ("HEARTBEAT", "SYSTEM_TIME") or system == GROUND:
            time_s = received_s
        else:
            vehicle = vehicle or system
            time_s = clock.time_s(received_s, message, message.get_srcComponent())
        if clock.restarted:
            log.remarks.append("the vehicle started anew in this log: what comes after is another recording, left out")
            break
        other = vehicle and system not in (vehicle, GROUND)
        stream = log.stream(f"{name} of system {system}" if other else name)
        stream.tick(received_s)
        if stream.values:
            stream.keep(time_s, message)
        if name == "PARAM_VALUE":
            log.learn(message.param_id, float(message.param_value))
    clock.set_right(log)


class Clock:
    """The vehicle's clock, which counts from its start, against the time of receipt."""

    def __init__(self) -> None:
        """Nothing seen yet."""
        self.offset_s: float | None = None  # the least by which receipt is ahead of the vehicle's clock
        self.latest_s = -1.0
        self.restarted = False

    def time_s(self, received_s: float, message: Any, component: int) -> float:
        """Time of a message: counted from the vehicle's start where it tells that, negative; else that of receipt."""
        own = getattr(message, "time_boot_ms", 0) * 1e-3
        stamp_us = getattr(message, "time_usec", 0)
        own = own or (stamp_us * 1e-6 if stamp_us < SINCE_1970_US else 0.0)
        if component != AUTOPILOT or not own:
            return received_s
        self.restarted = own < self.latest_s - RESTART_S
        self.latest_s = max(self.latest_s, own)
        offset = received_s - own
        self.offset_s = offset if self.offset_s is None else min(offset, self.offset_s)
        return -own

    def set_right(self, log: Log) -> None:
        """Turn the times that count from the vehicle's start into those of the others."""
        for stream in log.streams.values():
            for k, time_s in enumerate(stream.time_s):
                if time_s < 0.0:
                    stream.time_s[k] = (self.offset_s or 0.0) - time_s


def packets(path: Path, log: Log) -> Iterator[tuple[float, bytes]]:
    """Time of receipt [s since 1970] and bytes of each message, one after the other; what is no message is counted."""
    with path.open("rb") as file:
        lost = 0
        while head := file.read(STAMP.size + 3):
            if len(head) < STAMP.size + 3:
                log.cut("it ends within a message")
                break
            magic, payload, flags = head[STAMP.size :]
            if magic not in MAGIC:
                here = file.tell() - len(head)
                found = next_mark(file, MARKS, here + STAMP.size + 1)
                if found is None:
                    break
                file.seek(found - STAMP.size)
                lost += found - STAMP.size - here
                continue
            length = payload + MAGIC[magic] + SIGNATURE * (magic == 0xFD and flags & 1)
            rest = file.read(length - 3)
            if len(rest) < length - 3:
                log.cut("it ends within a message")
                break
            yield STAMP.unpack_from(head)[0] * 1e-6, head[STAMP.size :] + rest
    if lost:
        log.remarks.append(f"{lost} bytes between messages are no message and were skipped")
