"""A ROS 2 bag: what a radar sends as `marine_sensor_msgs/RadarSector`, with transforms, odometry and the clock.

Angles are counter-clockwise from ahead, x is forward, y to port, z up; the map's x is east and its y north. Intensities are the
video of the display: 0 where nothing shows, else quarters of a decibel above its threshold. `range_min` and `range_max` are the
middles of the first and the last cell.

Messages are CDR of the OMG's DDS-XTypes 1.3 (little-endian XCDR1), their definitions those of ROS packages as of 2024; fields
are in the order of these.
"""

import math
import struct

import numpy as np
from numpy.typing import NDArray

from radar_service.recording.recording_file import NANOSECONDS, RecordingFile
from radar_service.service.spokes import RadarInfo, SpokeBatch

PROFILE = "ros2"
MAP, SHIP, RADAR = "map", "base_link", "radar"  # frames
NO_COVARIANCE = (0.0,) * 36

TIME = "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n"
HEADER = "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n"
VECTOR = "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n"
QUATERNION = "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
DEFINITIONS = {
    "marine_sensor_msgs/msg/RadarSector": (
        "std_msgs/Header header\nfloat32 angle_start\nfloat32 angle_increment\nbuiltin_interfaces/Duration time_increment\n"
        "builtin_interfaces/Duration scan_time\nfloat32 range_min\nfloat32 range_max\nRadarEcho[] intensities\n",
        HEADER, TIME, "MSG: builtin_interfaces/Duration\nint32 sec\nuint32 nanosec\n",
        "MSG: marine_sensor_msgs/RadarEcho\nfloat32[] echoes\n",
    ),
    "tf2_msgs/msg/TFMessage": (
        "geometry_msgs/TransformStamped[] transforms\n",
        "MSG: geometry_msgs/TransformStamped\nstd_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n",
        HEADER, TIME, "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n",
        VECTOR, QUATERNION,
    ),
    "nav_msgs/msg/Odometry": (
        "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
        "geometry_msgs/TwistWithCovariance twist\n",
        HEADER, TIME, "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance\n",
        "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation\n",
        "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z\n", QUATERNION,
        "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance\n",
        "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular\n", VECTOR,
    ),
    "rosgraph_msgs/msg/Clock": ("builtin_interfaces/Time clock\n", TIME),
}  # fmt: skip


class Cdr:
    """One message as it is written."""

    def __init__(self) -> None:
        self._content = bytearray()

    def add(self, form: str, *values: float) -> "Cdr":
        """Adds numbers, each aligned to its size. form: a letter of the module `struct` for each."""
        for letter, value in zip(form, values, strict=True):
            self._content += b"\0" * (-len(self._content) % struct.calcsize(letter))
            self._content += struct.pack(f"<{letter}", value)
        return self

    def text(self, text: str) -> "Cdr":
        """Adds a text."""
        content = text.encode() + b"\0"
        self.add("I", len(content))
        self._content += content
        return self

    def header(self, nanoseconds: int, frame: str) -> "Cdr":
        """Adds a header. nanoseconds: UTC since 1970."""
        return self.time(nanoseconds).text(frame)

    def time(self, nanoseconds: int) -> "Cdr":
        """Adds a time or a duration."""
        return self.add("iI", *divmod(nanoseconds, 1_000_000_000))

    def sequences(self, rows: NDArray[np.number]) -> "Cdr":
        """Adds a sequence of sequences of float32 (K, N)."""
        self.add("I", len(rows))
        for row in rows:
            self.add("I", len(row))
            self._content += row.astype("<f4").tobytes()
        return self

    def content(self) -> bytes:
        """Returns the message with its encapsulation."""
        return b"\0\1\0\0" + bytes(self._content)


class Ros2Bag:
    """Writes what a radar sends. All methods raise OSError."""

    def __init__(self, file: RecordingFile) -> None:
        """file: of the profile of ROS 2."""
        topics = {"/radar/data": "marine_sensor_msgs/msg/RadarSector", "/tf": "tf2_msgs/msg/TFMessage",
                  "/odom": "nav_msgs/msg/Odometry", "/clock": "rosgraph_msgs/msg/Clock"}  # fmt: skip
        line = "=" * 80 + "\n"
        self._sector, self._transforms, self._odometry, self._clock = (
            file.typed_channel(topic, "cdr", name, "ros2msg", line.join(DEFINITIONS[name]).encode())
            for topic, name in topics.items()
        )

    def open_epoch(self, radar: RadarInfo) -> None:
        """Begins an epoch, of which the bag has only the spokes."""

    def send(self, batch: SpokeBatch) -> None:
        """Writes a sector, and before it the clock and own ship at its first ray, where its heading is known."""
        start = round(batch.epoch.start_utc.timestamp() * NANOSECONDS)
        nanoseconds = start + round(float(batch.block.time[0]) * NANOSECONDS)
        log_time = nanoseconds / NANOSECONDS
        self._clock(log_time, log_time, Cdr().time(nanoseconds).content())
        if not math.isnan(batch.block.heading[0]):
            for channel, message in zip((self._transforms, self._odometry), own_ship(batch, nanoseconds), strict=True):
                channel(log_time, log_time, message)
        self._sector(log_time, log_time, sector(batch, nanoseconds))


def sector(batch: SpokeBatch, nanoseconds: int) -> bytes:
    """Returns the rays of a batch."""
    block, to, radar = batch.block, batch.epoch.layout(None), batch.epoch.info.radar
    heading = np.where(np.isnan(block.heading), 0.0, block.heading)  # while it is lost the azimuth counts from the bow
    angles = np.unwrap(block.azimuth - heading)
    rays = len(block) - 1
    step = (angles[-1] - angles[0]) / rays if rays else 2.0 * math.pi / radar.azimuths
    message = Cdr().header(nanoseconds, RADAR).add("ff", math.remainder(-angles[0], 2.0 * math.pi), -step)
    message.time(round(radar.spoke_period * NANOSECONDS)).time(round(radar.rotation_period * NANOSECONDS))
    message.add("ff", to.first, to.first + (to.bins - 1) * to.step)
    return message.sequences(batch.video_bytes(to)).content()


def own_ship(batch: SpokeBatch, nanoseconds: int) -> tuple[bytes, bytes]:
    """Returns the transforms from the map to own ship and from there to the radar, and the odometry, whose covariances are 0: not
    known."""
    block = batch.block
    heading, drift, speed = float(block.heading[0]), float(block.course[0] - block.heading[0]), float(block.speed[0])
    turn, seconds = np.unwrap(block.heading[[0, -1]]), float(block.time[-1] - block.time[0])
    turn_rate = float(turn[0] - turn[1]) / seconds if seconds else 0.0
    half_yaw = (math.pi / 2.0 - heading) / 2.0
    pose = (*block.position[0].tolist(), 0.0, 0.0, 0.0, math.sin(half_yaw), math.cos(half_yaw))
    frames = Cdr().add("I", 2).header(nanoseconds, MAP).text(SHIP).add("d" * 7, *pose).header(nanoseconds, SHIP).text(RADAR)
    frames.add("d" * 7, 0.0, 0.0, batch.epoch.info.radar.height, 0.0, 0.0, 0.0, 1.0)
    odometry = Cdr().header(nanoseconds, MAP).text(SHIP).add("d" * 7, *pose).add("d" * 36, *NO_COVARIANCE)
    odometry.add("d" * 6, speed * math.cos(drift), -speed * math.sin(drift), 0.0, 0.0, 0.0, turn_rate).add(
        "d" * 36, *NO_COVARIANCE
    )
    return frames.content(), odometry.content()
