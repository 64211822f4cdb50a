"""Errors on purpose in SI units and radians; the scene file's `model/errors.py` says what each value means."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GyroErrors:
    """Errors of the reported heading."""

    bias: float
    calibration: float
    calibration_phase: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class LogErrors:
    """Errors of the reported speed. scale: share of the speed; least: the speed that this adds or takes at least."""

    bias: float
    scale: float
    least: float
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class PositionErrors:
    """Errors of the reported position. bias: east, north."""

    bias: tuple[float, float]
    noise: float
    noise_time: float
    latency: float


@dataclass(frozen=True)
class AntennaErrors:
    """Errors of the reported angle from the bow."""

    misalignment: float
    backlash: float
    encoder_noise: float
    encoder_step: float


@dataclass(frozen=True)
class FeedErrors:
    """What happens to spokes between radar and client. bytes: per second; cut_after: age of a connection [s]."""

    drop_rate: float
    burst_rate: float
    burst_spokes: int
    repeat_rate: float
    late_rate: float
    late: float
    swap_rate: float
    stuck_sector: tuple[float, float] | None
    heading_lost: tuple[tuple[float, float], ...]
    bytes: float | None
    cut_after: float | None


@dataclass(frozen=True)
class ErrorSettings:
    """The errors in force; None where a part has none."""

    gyro: GyroErrors | None = None
    log: LogErrors | None = None
    position: PositionErrors | None = None
    antenna: AntennaErrors | None = None
    feed: FeedErrors | None = None
