"""The radiometric truth of a beam crossing: where the power of a body lies, how much it is, and what else is in its cells.

P is the power of the body alone: compressed, in the beam, without noise. The gate is the cells with P within GATE of its peak
that connect with the peak, over corners too. It may reach into the scans before and after (docs/truth.md).
"""

from collections.abc import Sequence

import numpy as np

from radar_service.echo import BeamWeightedEchoes, apparent_position, elevation_of, slant_range
from radar_service.engine.preparation import Prepared
from radar_service.numerics import (
    BLAS_LIMIT,
    Flags,
    Floats,
    Singles,
    effective_earth_radius,
    turned,
    wrap_angle,
    wrap_bearing,
)
from radar_service.propagation import attenuation, elevation_gain, local_attenuation, received_amplitude
from radar_service.receive import receiver_noise_power
from radar_service.records import Extent, Radiometry, square_law
from radar_service.sources.numbers import BODY, source_numbers
from radar_service.sources.power_window import PowerWindow, pulse_powers
from radar_service.sources.rows import spread_echoes
from radar_service.world import SightLines

GATE = 10.0 ** (-20.0 / 10.0)  # of the peak
DETECTABLE = 10.0 ** (13.0 / 10.0)  # of the noise
BEAMS = 1.5  # beamwidths each side of the body in which its gate is looked for first; it is widened as far as needed
TILT_STEPS = 8  # towards a bearing: each leaves 2 % of the error at a roll of 12 degrees, 40 % at 45 degrees
GROUND_STEPS = 4  # towards a ground distance: the earth's drop changes it by parts in a million


class RadiometricTruth:
    """Measures crossings of a prepared scene. Each body counts by itself, land too. Safe to call from several threads."""

    def __init__(self, pulses: Sequence[Prepared]) -> None:
        """pulses: the scene prepared for each pulse of its radar, by rising range."""
        self._moving, self._scene, self._radar = pulses[-1].moving, pulses[-1].scene, pulses[-1].scene.radar
        numbers = source_numbers(self._scene)
        numbers[: len(self._scene.bodies)] = BODY + np.arange(len(self._scene.bodies))
        self._pulses = pulse_powers(pulses, numbers)
        self._earth_radius = effective_earth_radius(self._scene.environment.earth_factor)
        self._noise = receiver_noise_power(self._radar) if self._scene.environment.noise else None

    @BLAS_LIMIT.held()
    def at(self, body: int, spoke: int) -> Radiometry:
        """The crossing of a body, by its index in the scene. spoke: number since the start of the spoke nearest to it."""
        window, gate = self._gated(body, spoke)
        if not gate.any():
            return Radiometry()
        power = np.where(gate, window.power(BODY + body), 0.0).astype(np.float64)
        total, peak = float(power.sum()), np.unravel_index(int(power.argmax()), power.shape)
        number = int(window.number[0]) + float(power.sum(axis=1) @ np.arange(len(power))) / total
        distance = float(power.sum(axis=0) @ (np.arange(power.shape[1]) + 0.5)) / total * self._radar.range_step
        along, across = self._in_body_frame(body, number, distance)
        background, drawn = float(window.background[peak]), self._drawn_rcs(body, spoke)
        unit = self._unit_energy(body, window, along, across)
        every = sum(float(window.power(source)[gate].sum(dtype=np.float64)) for source in window.sources)
        return Radiometry(
            centroid_range=distance,
            centroid_bearing=float(wrap_bearing(number * self._radar.azimuth_step)),
            centroid_along=along,
            centroid_across=across,
            rcs_dbsm=None if unit == 0.0 else _db(total / unit),
            rcs_drawn_dbsm=None if drawn is None else _db(drawn),
            snr_db=None if self._noise is None else _db(float(power[peak]) / self._noise),
            scr_db=None if background == 0.0 else _db(float(power[peak]) / background),
            extent=self._extent(window, gate),
            extent_13db=None if self._noise is None else self._extent(window, power >= DETECTABLE * self._noise),
            foreign_share=1.0 - total / every,
        )

    def _gated(self, body: int, spoke: int) -> tuple[PowerWindow, Flags]:
        """The azimuths about a crossing that hold the gate of a body, and the gate (K, bins)."""
        half_scan, step = self._radar.azimuths // 2, self._radar.azimuth_step
        (offset,), _ = self._track(body, self._time(spoke))
        size = self._scene.bodies[body].diagonal / max(float(np.hypot(offset[0], offset[1])), 1.0)
        half = int(np.ceil((BEAMS * self._radar.beamwidth + size) / step)) + 1
        while True:
            half = min(half, half_scan)
            first = max(0, spoke - half)  # nothing is before
            window = PowerWindow(self._pulses, first, min(spoke + half + 1, first + self._radar.azimuths))
            gate = _gate(window.power(BODY + body))
            cut = bool(gate[0].any() and window.number[0] > 0 or gate[-1].any())
            if not cut or half == half_scan:
                return window, gate
            half *= 2

    def _time(self, number: float) -> Floats:
        """The time (1,) [s] of an azimuth, or of a place between two of them."""
        earlier = int(number)
        _, time = self._radar.schedule(np.array([earlier]))
        return time + (number - earlier) * self._radar.spoke_period

    def _track(self, body: int, time: Floats, along: float = 0.0, across: float = 0.0) -> tuple[Floats, Floats]:
        """Positions (K, 3) [m] from the antenna at times (K,) [s] of a point of a body, and the body's headings (K,) [rad].

        along, across: of the point from the reference point, to the bow and to starboard [m].
        """
        scene_body = self._scene.bodies[body]
        pose = scene_body.motion.pose(time)
        point = scene_body.reference + np.array([across, along, 0.0])
        upright = pose.rotation is None
        arm = turned(point, np.cos(pose.heading), np.sin(pose.heading)) if upright else pose.rotation @ point
        return pose.position + arm - self._scene.antenna(time), pose.heading

    def _in_body_frame(self, body: int, number: float, distance: float) -> tuple[float, float]:
        """Metres from the reference point of a body to the bow and to starboard of a place that appears `distance` [m] away.

        number: of the azimuth at whose boresight the place is. It is taken to be as high as the reference point.
        """
        (offset,), (heading,) = self._track(body, self._time(number))
        ground = distance
        for _ in range(GROUND_STEPS):
            z = offset[2] - ground**2 / (2.0 * self._earth_radius)
            ground = float(np.sqrt(max(distance**2 - z**2, 0.0)))
        bearing = self._map_bearing(number, ground, float(offset[2]))
        east, north = ground * np.sin(bearing) - offset[0], ground * np.cos(bearing) - offset[1]
        along, across = east * np.sin(heading) + north * np.cos(heading), east * np.cos(heading) - north * np.sin(heading)
        return float(along), float(across)

    def _map_bearing(self, number: float, ground: float, height: float) -> float:
        """The bearing on the map [rad] of what the boresight of an azimuth meets, `ground` [m] away and `height` over the antenna
        [m]."""
        boresight, level = number * self._radar.azimuth_step, self._scene.upright_from_map(self._time(number))
        bearing = boresight
        if level is None:
            return bearing
        for _ in range(TILT_STEPS):
            position = np.array([[[ground * np.sin(bearing), ground * np.cos(bearing), height]]])
            east, north, _ = apparent_position(position, level, self._earth_radius)[0, 0]
            bearing += float(wrap_angle(boresight - np.arctan2(east, north)))
        return bearing

    def _unit_energy(self, body: int, window: PowerWindow, along: float, across: float) -> float:
        """Energy in its own gate of 1 m^2 in free space, with the losses of gas and rain, where the power of a body lies.

        A point is taken where it is. Any other body's power is taken to lie at the same place of the body meanwhile.
        """
        place = (0.0, 0.0) if self._scene.bodies[body].mesh is None else (along, across)
        boresight, time = self._radar.schedule(window.number)
        position, _ = self._track(body, time, *place)
        distance, level = slant_range(position, self._earth_radius), self._scene.upright_from_map(time)
        matrices = np.broadcast_to(np.eye(3), (len(time), 3, 3)) if level is None else level
        observed = apparent_position(position[:, None], matrices, self._earth_radius)[:, 0]
        amplitude = received_amplitude(self._radar, distance) * attenuation(self._radar, self._scene.environment, distance)
        if self._scene.environment.attenuators:
            bearing = np.arctan2(position[:, 0], position[:, 1])
            lines = SightLines(self._scene.antenna(time), time, bearing, distance)
            amplitude *= local_attenuation(self._radar, self._scene.environment, lines)
        amplitude *= elevation_gain(self._radar, elevation_of(observed)) * window.transmitting
        amplitude *= self._radar.azimuth_gain(wrap_angle(boresight - np.arctan2(observed[:, 0], observed[:, 1])))
        middle = distance[len(distance) // 2]
        migration, of_beam = (distance - middle).astype(np.float32)[None], amplitude.astype(np.complex64)[None]
        echo = BeamWeightedEchoes(np.array([middle]), migration, of_beam, np.array([body]))
        power = np.zeros((len(time), self._radar.bins), dtype=np.float32)
        for pulse in self._pulses:
            compression = pulse.powers.prepared.compression
            rows = np.zeros((len(time), compression.size), dtype=np.complex64)
            spread_echoes(pulse.powers.prepared, rows, echo)
            power[:, pulse.columns] = pulse.gain * square_law(compression.profiles(rows)[:, pulse.columns])
        return float(power[_gate(power)].sum(dtype=np.float64))

    def _drawn_rcs(self, body: int, spoke: int) -> float | None:
        """The cross-section [m^2] drawn for a crossing; None for a body that does not fluctuate."""
        rcs = self._scene.bodies[body].rcs
        factor = self._moving.drawn_power(body, spoke, float(spoke * self._radar.azimuth_step))
        return None if rcs is None or factor is None else rcs * factor

    def _extent(self, window: PowerWindow, cells: Flags) -> Extent | None:
        """The outer edges of cells (K, bins) of a window; None where there are none."""
        row, cell = np.nonzero(cells)
        if not len(row):
            return None
        ranges = np.array([cell.min(), cell.max() + 1]) * self._radar.range_step
        bearings = wrap_bearing((window.number[[row.min(), row.max()]] + np.array([-0.5, 0.5])) * self._radar.azimuth_step)
        return Extent((float(ranges[0]), float(ranges[1])), (float(bearings[0]), float(bearings[1])))


def _gate(power: Singles) -> Flags:
    """The cells (K, bins) with power within GATE of the peak that connect with the peak; none where there is no power."""
    from scipy.ndimage import label  # here: it would slow every start

    peak = np.unravel_index(int(power.argmax()), power.shape)
    if not power[peak] > 0.0:
        return np.zeros(power.shape, dtype=np.bool_)
    areas, _ = label(power >= GATE * power[peak], structure=np.ones((3, 3)))
    return np.asarray(areas == areas[peak])


def _db(ratio: float) -> float:
    return float(10.0 * np.log10(ratio))
