"""The range sidelobes that sea clutter lacks: what they would add, computed beside the engine, as docs/limits.md says it.

Each sample of the sea is compressed like a point here: its power stands at other ranges as much as the pulse does. The engine
gives its speckle the correlation of the pulse, but no cell the sidelobes of another.
"""

from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.numerics.frames import effective_earth_radius
from radar_service.receive.compression import compression_for, receiver_noise_power
from radar_service.records.fidelity import PRESETS
from radar_service.stages.clutter.resolution_cell import resolution_cell
from radar_service.stages.clutter.sea_clutter import sea_power
from radar_service.world.scene import Scene
from tests.alone import clutter_of
from tests.reference.compressed_pulse import compressed_pulse
from tests.scenes import scene

Floats = NDArray[np.float64]
WINDOWS = {"hamming": (0.54, 0.46), "blackman": (0.42, 0.5, 0.08)}


class Sea(NamedTuple):
    """range (N,) [m]; local: mean power of the sea's own cells, compressed: with sidelobes (N,) [W]; noise: of a sample [W]."""

    range: Floats
    local: Floats
    compressed: Floats
    noise: float

    @property
    def excess_db(self) -> Floats:
        """What sidelobes add to sea and noise."""
        return np.asarray(10.0 * np.log10((self.compressed + self.noise) / (self.local + self.noise)))


def pulse_power(made: Scene) -> Floats:
    """Power of the compressed linear chirp at whole samples from its peak (2 reach + 1,), in shares of its energy."""
    radar = made.radar
    reach = int(radar.pulse * radar.sample_rate)
    delay = np.arange(-reach, reach + 1) / radar.sample_rate
    power = np.abs(compressed_pulse(delay, radar.bandwidth, radar.pulse, WINDOWS[radar.window])) ** 2
    return np.asarray(power / power.sum())


def sidelobes(made: Scene, power: Floats) -> Floats:
    """Mean power (N,) [W] at samples that come from others more than two lengths of the pulse's cell away."""
    pulse = pulse_power(made)
    middle, reach = len(pulse) // 2, int(np.ceil(2.0 / pulse.max()))
    pulse[middle - reach : middle + reach + 1] = 0.0
    return np.convolve(power, pulse)[middle : middle + len(power)]


def sea_of(made: Scene) -> Sea:
    """The sea of a scene, compressed with the power of its linear chirp."""
    radar = made.radar
    distance = (np.arange(radar.bins) + 0.5) * radar.range_step
    cell = resolution_cell(radar.azimuth_gain, compression_for(radar, 6), radar.range_step)
    local = sea_power(made, distance, cell, effective_earth_radius(made.environment.earth_factor))
    pulse = pulse_power(made)
    compressed = np.convolve(local, pulse)[len(pulse) // 2 :][: len(local)]
    return Sea(distance, local, compressed, receiver_noise_power(radar))


def chirp(sea_state: int, **radar: Any) -> Scene:
    """The usual radar of 15 m height, whose sea ends beyond the range in which sidelobes count."""
    return scene([], radar={"range_max_m": 6000, **radar}, environment={"noise": True, "sea_state": sea_state})


@pytest.mark.parametrize(
    ("made", "excess_db", "at_m", "up_to_m"),
    [
        (rs.load_scene("open-sea"), 0.62, 954, 1500),
        (chirp(2, bandwidth_hz=10e6, sample_rate_hz=15e6), 1.84, 944, 4250),
    ],
    ids=["open sea", "10 MHz"],
)
def test_what_sidelobes_would_add_to_open_sea(made: Scene, excess_db: float, at_m: float, up_to_m: float) -> None:
    """The figures of docs/limits.md, to half their last digit: from 100 m on to 5.5 km, where the scenes' sea may end. Beyond the
    reach of the near sea, half a pulse length or 1.5 km, what the sea of a like range adds is all: below 0.3 dB."""
    sea = sea_of(made)
    within = (sea.range > 100.0) & (sea.range < 5500.0)
    strongest = int(np.argmax(np.where(within, sea.excess_db, -np.inf)))
    assert sea.excess_db[strongest] == pytest.approx(excess_db, abs=0.006)
    assert sea.range[strongest] == pytest.approx(at_m, abs=made.radar.range_step)
    over = sea.range[within & (sidelobes(made, sea.local) > sea.noise)]
    assert over[-1] == pytest.approx(up_to_m, abs=50.0)
    assert sea.excess_db[within & (sea.range > 1700.0)].max() < 0.3


def test_a_shadow_on_the_sea_is_empty_that_sidelobes_would_fill() -> None:
    """Behind a wall at 800 m the engine leaves nothing. The sea before the wall would leave 12 dB less than the sea beside the
    shadow has, and 25 dB less beyond 1.6 km, as half a pulse length is 1.5 km: to half their last digit."""
    wall = {
        "name": "wall", "shape": "box", "length_m": 10, "width_m": 600, "height_m": 40, "position_m": [0, 800, 0],
        "rcs_dbsm": 0,
    }  # fmt: skip
    made = chirp(3)
    walled = scene([wall], radar={"range_max_m": 6000}, environment={"noise": True, "sea_state": 3})
    clutter = clutter_of(prepare(walled, PRESETS["balanced"], 0))
    assert clutter is not None
    rows = clutter.rows(np.arange(1), np.ones((1, 1), dtype=np.bool_))
    assert rows is not None
    sea = sea_of(made)
    shaded = (sea.range > 900.0) & (sea.range < 2000.0)
    assert not rows.field[0][shaded[: rows.field.shape[1]]].any()
    left = sidelobes(made, np.where(sea.range < 800.0, sea.local, 0.0))
    below = 10.0 * np.log10(left[shaded] / sea.local[shaded])
    assert below.max() == pytest.approx(-12.0, abs=0.5)
    assert below[sea.range[shaded] > 1600.0].max() == pytest.approx(-25.0, abs=0.5)
