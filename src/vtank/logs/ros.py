"""Messages of ROS: raw bytes to fields, by the definitions that a log carries, and the time that a message tells."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

from .log import Log, library, number

DOWN = ("ned", "frd")  # ends of the names of frames whose z axis points down, REP-103
APART_S = 3600.0  # [s] between stamp and receipt above which they are different clocks; a choice


class Messages:
    """Decodes the wanted messages of one log and hands them to it. InputError without rosbags.

    A message has the time of its header where it has one; all have that of their receipt where the two are different
    clocks, as they are where a simulator's time stands in the headers.
    """

    def __init__(self, log: Log, what: str) -> None:
        """Messages of `log`; `what` is to be read, for the error without rosbags."""
        self.log = log
        self.types = library("rosbags.typesys", "rosbags", what)
        store = {"ros1": self.types.Stores.ROS1_NOETIC, "cdr": self.types.Stores.ROS2_HUMBLE}
        self.stores = {encoding: self.types.get_typestore(each) for encoding, each in store.items()}
        self.decoders: dict[str, Callable[[bytes, str], Any]] = {
            "ros1": self.stores["ros1"].deserialize_ros1,
            "cdr": self.stores["cdr"].deserialize_cdr,
            "json": lambda raw, _: json.loads(raw),
        }
        self.by_receipt: bool | None = None

    def define(self, encoding: str, kind: str, definition: str, language: str = "ros2msg") -> None:
        """Learn a type from the definition that the log carries; one that cannot be understood is left as it is."""
        read = self.types.get_types_from_idl if language == "ros2idl" else self.types.get_types_from_msg
        store = self.stores.get(encoding)
        if store is None or not definition:
            return
        try:
            found = read(definition) if language == "ros2idl" else read(definition, kind)
            store.register({name: each for name, each in found.items() if name not in store.fielddefs})
        except Exception as error:  # of many kinds, by a definition that is broken
            self.log.remarks.append(f"the definition of {kind} is not understood ({str(error)[:80]})")

    def take(self, topic: str, kind: str, encoding: str, received_s: float, raw: bytes) -> None:
        """Count a message, and keep its fields where they are wanted."""
        stream = self.log.stream(topic, kind)
        stream.tick(received_s)
        if not stream.values:
            return
        if encoding not in self.decoders:
            self.log.lose(topic, f"encoding '{encoding}' is not known")
            return
        try:
            message = self.decoders[encoding](raw, kind)
        except Exception as error:  # rosbags raises many kinds for bytes that are not what the definition says
            self.log.lose(topic, self._why(encoding, kind, error))
            return
        if stream.sample is None:
            frame = str(getattr(getattr(message, "header", None), "frame_id", ""))
            stream.down = frame.lower().endswith(DOWN)
        stream.keep(self._time_s(message, received_s), message)

    def _why(self, encoding: str, kind: str, error: Exception) -> str:
        """Why a message could not be decoded."""
        store = self.stores.get(encoding)
        if store is not None and kind not in store.fielddefs:
            return f"its type '{kind}' is not known"
        return f"not {encoding} as expected: {error}"

    def _time_s(self, message: Any, received_s: float) -> float:
        stamped_s = number(message, "header.stamp.sec") + number(message, "header.stamp.nanosec") * 1e-9
        if not stamped_s or not math.isfinite(stamped_s):
            return received_s
        if self.by_receipt is None:
            self.by_receipt = abs(stamped_s - received_s) > APART_S
            if self.by_receipt:
                self.log.remarks.append("stamps are of another clock than the recorder's: times are those of receipt")
        return received_s if self.by_receipt else stamped_s


def type_name(name: str) -> str:
    """The name of a type in three parts, as ROS 2 writes it: nav_msgs/Odometry is nav_msgs/msg/Odometry."""
    return name if name.count("/") != 1 else name.replace("/", "/msg/")
