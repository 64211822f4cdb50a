"""What own ship's sensors and the antenna report: a function of the true readings, the seed, and the numbers of spokes.

The radar measures the angle from the bow. Its azimuth from true north is that angle plus the reported heading, so an error of
the gyro turns the whole picture. While the heading is lost, azimuths count from the bow. Course is that of gyro and log: the
true drift is added to the reported heading.

The angle from the bow is what the antenna's encoder reports; the beam itself looks where it did.

Correlated noise is a first-order Gauss-Markov process as a sum of M sinusoids, a function of time alone (Shinozuka and Deodatis
1991, spectral representation). Its kurtosis is 3 - 3 / (2 M).
"""

from collections.abc import Callable

import numpy as np

from radar_service.numerics import SENSOR, Flags, Floats, Indices, generator, name_key, wrap_angle, wrap_bearing
from radar_service.radar import Radar
from radar_service.records import Readings
from radar_service.world import NO_STREAM, AntennaErrors, ErrorSettings, Stream, through_water

SINUSOIDS = 64  # kurtosis 2.977
BLOCK = 256  # spokes whose independent numbers come from one generator
GYRO, LOG, EAST, NORTH, ANTENNA = 1, 2, 3, 4, 5  # sensors, the key after the purpose
Earlier = Callable[[Indices], Readings]  # the true readings (K,) of spokes of these numbers (K,)


class SensorNoise:
    """Normal noise of standard deviation 1.

    correlation_time: [s]; 0 for numbers that are independent from spoke to spoke. seed, key: of the random generators.
    """

    def __init__(self, correlation_time: float, seed: int, *key: int) -> None:
        self._seed, self._key = seed, (SENSOR, *key)
        self._frequency = self._phase = np.empty(0)
        if correlation_time > 0.0:
            rng = generator(seed, *self._key)
            share = (np.arange(SINUSOIDS) + rng.random(SINUSOIDS)) / SINUSOIDS  # one in each of as many equal shares
            self._frequency = np.tan(np.pi * (share - 0.5)) / correlation_time  # rad/s
            self._phase = 2.0 * np.pi * rng.random(SINUSOIDS)

    def at(self, number: Indices, time: Floats) -> Floats:
        """Returns the noise (K,) at spokes of these numbers (K,) and times (K,) [s]."""
        if len(self._phase):
            angle = self._frequency * time[:, None] + self._phase
            return np.asarray(np.sqrt(2.0 / SINUSOIDS) * np.cos(angle).sum(axis=1))
        return draws(number, 1, self._seed, *self._key, normal=True)[:, 0]


def draws(number: Indices, columns: int, seed: int, *key: int, normal: bool = False) -> Floats:
    """Returns random numbers (K, columns) for spokes of these numbers (K,): uniform from 0 to 1, or normal."""
    result = np.empty((len(number), columns))
    block = number // BLOCK
    for which in np.unique(block).tolist():
        rng = generator(seed, *key, which)
        table = (rng.standard_normal if normal else rng.random)((BLOCK, columns))
        rows = block == which
        result[rows] = table[number[rows] % BLOCK]
    return result


def backlash(from_bow: Floats) -> Floats:
    """Returns the share (K,) of the play, -1 to 1, that the wind takes up at angles from the bow (K,) [rad].

    The encoder turns with the motor; gears have play. Wind from ahead turns a flat antenna with a torque that is zero along
    and across the wind, and changes its sign four times a turn. The share follows it as a triangle wave of twice the angle,
    so that it is evenly distributed over a turn: the rectangular distribution of A.823(19), appendix 3.
    """
    return np.asarray(np.arcsin(np.sin(2.0 * from_bow)) * (2.0 / np.pi))


def antenna_error(errors: AntennaErrors, noise: Floats, from_bow: Floats) -> Floats:
    """Returns reported angle from the bow minus true angle (K,) [rad] of an antenna at true angles from the bow (K,) [rad].

    noise: of its encoder (K,), of standard deviation 1.
    """
    error = errors.misalignment + errors.backlash * backlash(from_bow) + errors.encoder_noise * noise
    if errors.encoder_step:
        error = np.rint((from_bow + error) / errors.encoder_step) * errors.encoder_step - from_bow
    return np.asarray(error)


class SensorLaws:
    """The laws of the sensors in force.

    stream: of the water, east and north [m/s]: the log measures the speed through the water, and the speed over ground that is
    reported has the log's error.
    seed: of the noise. radar_key: of the antenna's noise, one for each radar. ship: name of the body that carries the radar, or
    None: all radars of a ship share its sensors, and their noise is not that of another ship.
    """

    def __init__(
        self, errors: ErrorSettings, radar: Radar, seed: int, radar_key: int = 0, ship: str | None = None,
        stream: Stream = NO_STREAM,
    ) -> None:  # fmt: skip
        self._errors, self._period, self._stream = errors, radar.spoke_period, stream
        key = () if ship is None else (name_key(ship),)
        gyro, log, position = errors.gyro, errors.log, errors.position
        self._gyro_noise = SensorNoise(gyro.noise_time if gyro else 0.0, seed, GYRO, *key)
        self._log_noise = SensorNoise(log.noise_time if log else 0.0, seed, LOG, *key)
        self._position_noise = [
            SensorNoise(position.noise_time, seed, axis, *key) for axis in (EAST, NORTH) if position is not None
        ]
        self._antenna_noise = SensorNoise(0.0, seed, ANTENNA, radar_key)

    @property
    def latencies(self) -> tuple[float, ...]:
        """Latencies [s] of the sensors that have one."""
        settings = (self._errors.gyro, self._errors.log, self._errors.position)
        return tuple(sensor.latency for sensor in settings if sensor is not None and sensor.latency)

    def reported(self, number: Indices, time: Floats, true: Readings, earlier: Earlier) -> Readings:
        """Returns what is reported with spokes of these numbers (K,) and times (K,) [s].

        true: their true readings; earlier: gives those of earlier spokes, for sensors with latency.
        """
        turn, course_turn = self._heading_errors(number, time, true, earlier)
        from_bow = wrap_angle(true.azimuth - true.heading)
        error, antenna = np.zeros(len(number)), self._errors.antenna
        if antenna is not None:
            error = antenna_error(antenna, self._antenna_noise.at(number, time), from_bow)
        feed = self._errors.feed
        lost = is_lost(time, feed.heading_lost if feed else ())
        return Readings(
            np.where(lost, wrap_bearing(from_bow + error), _turned(true.azimuth, turn + error)),
            np.where(lost, np.nan, _turned(true.heading, turn)),
            self._position(number, time, true, earlier),
            np.where(lost, np.nan, _turned(true.course, course_turn)),
            self._speed(number, time, true, earlier),
        )

    def _heading_errors(self, number: Indices, time: Floats, true: Readings, earlier: Earlier) -> tuple[Floats, Floats]:
        """The errors (K,) [rad] of heading and course."""
        gyro = self._errors.gyro
        if gyro is None:
            return np.zeros(len(number)), np.zeros(len(number))
        sensed = self._delayed(number, gyro.latency, true, earlier)
        error = gyro.bias + gyro.calibration * np.sin(sensed.heading - gyro.calibration_phase)
        error = error + gyro.noise * self._gyro_noise.at(number, time) if gyro.noise else error
        return (
            wrap_angle(sensed.heading - true.heading) + error if gyro.latency else error,
            wrap_angle(sensed.course - true.course) + error if gyro.latency else error,
        )

    def _speed(self, number: Indices, time: Floats, true: Readings, earlier: Earlier) -> Floats:
        log = self._errors.log
        if log is None:
            return np.asarray(true.speed)
        sensed = self._water_speed(self._delayed(number, log.latency, true, earlier))
        speed = sensed * (1.0 + log.scale) + log.bias
        if log.least:
            speed = sensed + np.copysign(np.maximum(np.abs(log.scale * sensed), log.least), log.scale) + log.bias
        speed = speed + log.noise * self._log_noise.at(number, time) if log.noise else speed
        return np.asarray(true.speed + speed - self._water_speed(true) if any(self._stream) else speed)

    def _water_speed(self, readings: Readings) -> Floats:
        """Speed through the water (K,) [m/s] of true readings."""
        if not any(self._stream):
            return np.asarray(readings.speed)
        velocity = np.stack([readings.speed * np.sin(readings.course), readings.speed * np.cos(readings.course)], axis=-1)
        return through_water(velocity, readings.course, self._stream)[1]

    def _position(self, number: Indices, time: Floats, true: Readings, earlier: Earlier) -> Floats:
        sensor = self._errors.position
        if sensor is None:
            return np.asarray(true.position)
        position = self._delayed(number, sensor.latency, true, earlier).position + np.asarray(sensor.bias)
        if sensor.noise:
            position = position + sensor.noise * np.stack([noise.at(number, time) for noise in self._position_noise], axis=1)
        return np.asarray(position)

    def _delayed(self, number: Indices, latency: float, true: Readings, earlier: Earlier) -> Readings:
        """The readings of the spokes that are `latency` [s] older, in whole spokes; spoke 0 has no older ones."""
        spokes = round(latency / self._period)
        return earlier(np.maximum(number - spokes, 0)) if spokes else true


def _turned(angle: Floats, error: Floats) -> Floats:
    """Bearings (K,) [rad] with errors; those without an error stay the same to the bit."""
    return np.where(error == 0.0, angle, wrap_bearing(angle + error))


def is_lost(time: Floats, periods: tuple[tuple[float, float], ...]) -> Flags:
    """Whether times (K,) [s] lie in one of the periods; each includes its beginning and not its end."""
    lost = np.zeros(len(time), dtype=np.bool_)
    for start, end in periods:
        lost |= (time >= start) & (time < end)
    return lost
