"""Small logs of every kind, written for tests of their readers: one dive, whose motion is known."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_typestore
from scipy.spatial.transform import Rotation

from vtank.record import Run

TIME_S = np.arange(0.0, 30.0, 0.1)
BOOT_S, UNIX_S = 500.0, 1.7e9  # of the vehicle's clock and of the recorder's at the first sample
HEADING_RAD = 1.0 + 0.8 * np.sin(0.5 * TIME_S)
ROLL_RAD, PITCH_RAD = 0.1 * np.sin(0.9 * TIME_S), 0.05 * np.cos(0.7 * TIME_S)
NORTH_M, EAST_M, DEPTH_M = 3.0 * np.sin(0.2 * TIME_S), 0.1 * TIME_S, 2.0 + 0.5 * np.cos(0.3 * TIME_S)
SURGE_M_S, SWAY_M_S, HEAVE_M_S = 0.5 * np.cos(0.2 * TIME_S), 0.1 * np.sin(TIME_S), -0.15 * np.sin(0.3 * TIME_S)
COMMAND = np.round(0.6 * np.sin(0.4 * TIME_S) * 400.0) / 400.0  # as pulses of whole microseconds
ATTITUDE = Rotation.from_euler("ZYX", np.column_stack([HEADING_RAD, PITCH_RAD, ROLL_RAD]))  # body to north, east, down
TRUE = {
    "thruster_1_command": COMMAND, "thruster_2_command": -COMMAND, "roll_rad": ROLL_RAD, "pitch_rad": PITCH_RAD,
    "heading_rad": HEADING_RAD, "north_m": NORTH_M, "east_m": EAST_M, "depth_m": DEPTH_M, "surge_m_s": SURGE_M_S,
    "sway_m_s": SWAY_M_S, "heave_m_s": HEAVE_M_S,
}  # fmt: skip
VELOCITY_NED = ATTITUDE.apply(np.column_stack([SURGE_M_S, SWAY_M_S, HEAVE_M_S]))


def check(run: Run, names: tuple[str, ...] = tuple(TRUE), to: float = 1e-4, prefix: str = "") -> None:
    """Assert that columns hold the dive, wherever they have samples, and have most of them."""
    for name in names:
        time_s, values = run.samples(prefix + name)
        expected = np.interp(time_s, TIME_S, TRUE[name])
        assert time_s.size > 0.9 * TIME_S.size, name
        error = values - expected
        if name in ("heading_rad", "roll_rad"):
            error = (error + np.pi) % (2.0 * np.pi) - np.pi
        assert np.abs(error).max() < to, name


def tlog(path: Path, late_s: Callable[[int], float] = lambda k: 0.0) -> Path:
    """MAVLink telemetry; each message is received `late_s` after it was sent."""
    from pymavlink.dialects.v20 import ardupilotmega as dialect

    vehicle, station, parts = dialect.MAVLink(None, 1, 1), dialect.MAVLink(None, 255, 190), []

    def add(time_s: float, message: Any, sender: Any = vehicle) -> None:
        parts.append(struct.pack(">Q", round((UNIX_S + time_s) * 1e6)) + message.pack(sender))

    names = {"SERVO1_FUNCTION": 34.0, "SERVO2_FUNCTION": 33.0, "SERVO3_FUNCTION": 59.0, "MOT_2_DIRECTION": -1.0}
    for number, (name, value) in enumerate(names.items()):
        add(0.0, dialect.MAVLink_param_value_message(name.encode(), value, 9, len(names), number))
    for k, t in enumerate(TIME_S):
        received, boot_ms = t + late_s(k), round(1e3 * (BOOT_S + t))
        if k % 10 == 0:
            add(received, dialect.MAVLink_heartbeat_message(6, 8, 192, 0, 4, 3), station)
            add(received, dialect.MAVLink_heartbeat_message(12, 3, 128 if k else 0, 0, 4, 3))
        add(
            received,
            dialect.MAVLink_attitude_message(boot_ms, ROLL_RAD[k], PITCH_RAD[k], HEADING_RAD[k], 0.0, 0.0, 0.0),
        )
        place = NORTH_M[k], EAST_M[k], DEPTH_M[k]
        add(received, dialect.MAVLink_local_position_ned_message(boot_ms, *place, *VELOCITY_NED[k]))
        pulses = [round(1500 + 400 * COMMAND[k]), round(1500 + 400 * COMMAND[k]), 1100, *[0] * 13]
        add(received, dialect.MAVLink_servo_output_raw_message(1000 * boot_ms, 0, *pulses))
    path.write_bytes(b"".join(parts))
    return path


def dataflash(path: Path) -> Path:
    """ArduPilot's log on board."""
    forms = {
        1: ("PARM", "QNf", "TimeUS,Name,Value"),
        2: ("ATT", "Qccc", "TimeUS,Roll,Pitch,Yaw"),
        3: ("XKF1", "QBffffff", "TimeUS,C,VN,VE,VD,PN,PE,PD"),
        4: ("RCOU", "QHHH", "TimeUS,C1,C2,C3"),
        5: ("ARM", "QB", "TimeUS,ArmState"),
        6: ("ESC", "QBf", "TimeUS,Instance,RPM"),
    }
    letters = {"Q": "Q", "N": "16s", "f": "f", "c": "h", "B": "B", "H": "H"}
    packers = {number: struct.Struct("<" + "".join(letters[c] for c in form[1])) for number, form in forms.items()}

    def head(number: int, name: str, form: str, columns: str, length: int) -> bytes:
        return b"\xa3\x95\x80" + struct.pack(
            "<BB4s16s64s", number, length, name.encode(), form.encode(), columns.encode()
        )

    def line(number: int, *values: Any) -> bytes:
        return b"\xa3\x95" + bytes([number]) + packers[number].pack(*values)

    parts = [head(0x80, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns", 89)]
    parts += [head(number, *form, packers[number].size + 3) for number, form in forms.items()]
    start = round(1e6 * BOOT_S)
    for name, value in {"SERVO1_FUNCTION": 34.0, "SERVO2_FUNCTION": 33.0, "MOT_2_DIRECTION": -1.0}.items():
        parts.append(line(1, start, name.encode(), value))
    parts.append(line(5, start, 1))
    degrees = 100.0 * np.degrees([ROLL_RAD, PITCH_RAD, HEADING_RAD])
    for k, t in enumerate(TIME_S):
        now = start + round(1e6 * t)
        parts.append(line(2, now, *np.round(degrees[:, k]).astype(int).tolist()))
        parts.append(line(3, now, 0, *VELOCITY_NED[k], NORTH_M[k], EAST_M[k], DEPTH_M[k]))
        parts.append(line(3, now, 1, *[99.0] * 6))
        parts.append(line(4, now, *[round(1500 + 400 * COMMAND[k])] * 2, 0))
        parts += [line(6, now, instance, abs(600.0 * COMMAND[k])) for instance in (0, 1)]
    path.write_bytes(b"".join(parts))
    return path


def ulog(path: Path) -> Path:
    """A log of PX4."""

    def part(kind: bytes, content: bytes) -> bytes:
        return struct.pack("<HB", len(content), kind[0]) + content

    forms = {
        0: "vehicle_attitude:uint64_t timestamp;float[4] q;",
        1: "vehicle_local_position:uint64_t timestamp;float x;float y;float z;float vx;float vy;float vz;",
        2: "actuator_motors:uint64_t timestamp;float[3] control;",
        3: "cpuload:uint64_t timestamp;float load;",
    }
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", round(1e6 * BOOT_S))]
    parts += [part(b"F", form.encode()) for form in forms.values()]
    parts += [part(b"A", struct.pack("<BH", 0, k) + form.split(":")[0].encode()) for k, form in forms.items()]
    x, y, z, w = ATTITUDE.as_quat().T
    for k, t in enumerate(TIME_S):
        now = struct.pack("<Q", round(1e6 * (BOOT_S + t)))
        place = struct.pack("<6f", NORTH_M[k], EAST_M[k], DEPTH_M[k], *VELOCITY_NED[k])
        parts.append(part(b"D", struct.pack("<H", 0) + now + struct.pack("<4f", w[k], x[k], y[k], z[k])))
        parts.append(part(b"D", struct.pack("<H", 1) + now + place))
        parts.append(part(b"D", struct.pack("<H", 2) + now + struct.pack("<3f", COMMAND[k], -COMMAND[k], np.nan)))
    path.write_bytes(b"".join(parts))
    return path


THRUST_MAP = """
several = true

[[channel]]
message = "/thrusters/a*"
field = "vector.x"
column = "thruster_1_command"

[[channel]]
message = "/thrusters/a*"
field = "vector.y"
column = "thruster_2_command"

[[channel]]
type = "nav_msgs/msg/Odometry"
fields = ["pose.pose.position.x", "pose.pose.position.y", "pose.pose.position.z"]
columns = ["north_m", "east_m", "depth_m"]
frame = "ENU"
"""


def bag(path: Path, compression: str = "") -> Path:
    """A bag of ROS 1 with an odometry and commands as a vector."""
    store = get_typestore(Stores.ROS1_NOETIC)
    writer = Writer1(path)
    if compression:
        writer.set_compression(Writer1.CompressionFormat[compression])
    with writer:
        odometry = writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=store)
        thrust = writer.add_connection("/thrusters/all", "geometry_msgs/msg/Vector3Stamped", typestore=store)
        for k in range(TIME_S.size):
            for topic, message in ((odometry, _odometry(store, k, 1)), (thrust, _commands(store, k, 1))):
                writer.write(topic, _received_ns(k), store.serialize_ros1(message, topic.msgtype))
    return path


def bag2(path: Path, mcap: bool = False, frame: str = "odom") -> Path:
    """The same as a bag of ROS 2: a folder; in another frame than "odom" with axes z down."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    plugin = StoragePlugin.MCAP if mcap else StoragePlugin.SQLITE3
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        odometry = writer.add_connection("/odom", "nav_msgs/msg/Odometry", typestore=store)
        thrust = writer.add_connection("/thrusters/all", "geometry_msgs/msg/Vector3Stamped", typestore=store)
        port = writer.add_connection("/thrusters/port", "std_msgs/msg/Float64", typestore=store)
        for k in range(TIME_S.size):
            rpm = store.types["std_msgs/msg/Float64"](600.0 * COMMAND[k])
            for topic, message in (
                (odometry, _odometry(store, k, 2, frame)),
                (thrust, _commands(store, k, 2)),
                (port, rpm),
            ):
                writer.write(topic, _received_ns(k), store.serialize_cdr(message, topic.msgtype))
    return path


def _received_ns(k: int) -> int:
    """A quarter of a second late: the stamps count."""
    return round(1e9 * (UNIX_S + TIME_S[k] + 0.25))


def _header(store: Any, k: int, version: int, frame: str = "odom") -> Any:
    whole, part = divmod(round(1e9 * TIME_S[k]), 10**9)
    stamp = store.types["builtin_interfaces/msg/Time"](sec=int(UNIX_S) + whole, nanosec=part)
    sequence = {"seq": k} if version == 1 else {}
    return store.types["std_msgs/msg/Header"](**sequence, stamp=stamp, frame_id=frame)


def _odometry(store: Any, k: int, version: int, frame: str = "odom") -> Any:
    """Earth axes east, north, up and body axes forward, left, up, as ROS has them; z down in other frames."""
    t = store.types
    vector, point = t["geometry_msgs/msg/Vector3"], t["geometry_msgs/msg/Point"]
    to_enu, to_flu = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]]), np.diag([1, -1, -1])
    if frame != "odom":
        to_enu = to_flu = np.eye(3, dtype=int)
    place = to_enu @ [NORTH_M[k], EAST_M[k], DEPTH_M[k]]
    speed_m_s = to_flu @ [SURGE_M_S[k], SWAY_M_S[k], HEAVE_M_S[k]]
    x, y, z, w = Rotation.from_matrix(to_enu @ ATTITUDE[k].as_matrix() @ to_flu).as_quat()
    pose = t["geometry_msgs/msg/Pose"](
        position=point(*place), orientation=t["geometry_msgs/msg/Quaternion"](x, y, z, w)
    )
    speed = t["geometry_msgs/msg/Twist"](vector(*speed_m_s), vector(0.0, 0.0, 0.0))
    return t["nav_msgs/msg/Odometry"](
        header=_header(store, k, version, frame),
        child_frame_id="base_link",
        pose=t["geometry_msgs/msg/PoseWithCovariance"](pose, np.zeros(36)),
        twist=t["geometry_msgs/msg/TwistWithCovariance"](speed, np.zeros(36)),
    )


def _commands(store: Any, k: int, version: int) -> Any:
    vector = store.types["geometry_msgs/msg/Vector3"](COMMAND[k], -COMMAND[k], 0.0)
    return store.types["geometry_msgs/msg/Vector3Stamped"](header=_header(store, k, version), vector=vector)
