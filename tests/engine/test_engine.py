"""The short modules of engine, each under its name."""

import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from radar_service.engine.pipeline import Engine, profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.engine.range_sidelobes import MAX_COLUMNS, RangeSidelobes
from radar_service.receive.compression import Compression, compression_for
from radar_service.records.fidelity import PRESETS
from tests.scenes import everything, point, radar, scene

# preparation: A prepared scene: it crosses to another process, and bodies of it may be silent or transparent.
CHILD = """
import pickle, sys
from radar_service.engine.pipeline import profiles, tile_azimuths
for path in sys.argv[1:]:
    prepared = pickle.load(open(path, "rb"))
    for scan in (1, 0):
        for start in range(0, prepared.scene.radar.azimuths, prepared.tile):
            sys.stdout.buffer.write(profiles(prepared, tile_azimuths(prepared, scan, start)).tobytes())
"""


def test_a_prepared_scene_crosses_to_another_process(tmp_path: Path) -> None:
    """There its profiles have the same bytes, scans in another order too, whether or not its caches were filled here."""
    prepared = prepare(everything(), PRESETS["balanced"], 5)
    as_prepared, used = tmp_path / "prepared.pickle", tmp_path / "used.pickle"
    as_prepared.write_bytes(pickle.dumps(prepared))
    fields = [b"".join(field.tobytes() for _, field, _ in Engine(prepared).tiles(scan)) for scan in (0, 1)]
    used.write_bytes(pickle.dumps(prepared))
    command = [sys.executable, "-c", CHILD, str(as_prepared), str(used)]
    child = subprocess.run(command, capture_output=True, check=True, cwd=Path(__file__).parents[2])
    assert child.stdout == 2 * (fields[1] + fields[0])
    assert fields[0] != fields[1] and np.frombuffer(fields[0], np.complex64).any()


def test_silent_and_transparent_bodies() -> None:
    """A silent body still occludes; a transparent one still echoes, its far side too, and what is behind it is visible."""
    ship = {"name": "ship", "shape": "hull", "length_m": 60, "beam_m": 12, "height_m": 40, "rcs_dbsm": 20,
            "position_m": [0, 400, 0], "course_deg": 90, "speed_kn": 1}  # fmt: skip
    made = scene([ship, point("behind", 0, 900)], radar={"range_max_m": 1200, "pulse_s": 1e-6})
    near, far = slice(180, 230), slice(440, 460)

    def levels(**options: Any) -> tuple[float, float]:
        prepared = prepare(made, PRESETS["balanced"], 1, **options)
        power = np.abs(profiles(prepared, tile_azimuths(prepared, 0, 0))[0]) ** 2
        return float(power[near].max()), float(power[far].max())

    plain, silent, transparent = levels(), levels(silent=[0]), levels(transparent=[0])
    assert silent[0] < 1e-6 * plain[0] and silent[1] < 1e-4 * transparent[1]
    assert transparent[0] > 0.1 * plain[0] and plain[1] < 1e-4 * transparent[1]


# range_sidelobes: powers of windows against those of whole rows.
BEGIN, COLUMNS = 480, 80
PULSES = [
    {"pulse_s": 4e-6},
    {"modulation": "none", "pulse_s": 2e-7, "bandwidth_hz": 10e6, "sample_rate_hz": 75e6},
    {"pulse_s": 4e-6, "eclipsing": True},
]


def rows_of(compression: Compression, columns: int = COLUMNS) -> tuple[np.ndarray, np.ndarray]:
    """Three rows with three points each: windows, and whole."""
    rng = np.random.default_rng(0)
    position = np.array([512.3, 519.9, 532.0])
    first, weight = compression.kernel.weights(position)
    whole = np.zeros((3, compression.size), dtype=np.complex64)
    for row in whole:
        amplitude = rng.normal(size=(3, 1)) + 1j * rng.normal(size=(3, 1))
        np.add.at(row, (first[:, None] + np.arange(compression.kernel.width)).ravel(), (amplitude * weight).ravel())
    return whole[:, BEGIN : BEGIN + columns], whole


@pytest.mark.parametrize("columns", [COLUMNS, MAX_COLUMNS + 1])
@pytest.mark.parametrize("pulse", PULSES)
def test_the_power_of_any_bins_is_that_of_the_whole_profile(pulse: dict[str, float], columns: int) -> None:
    """To single precision of the strongest sample. The source of the last pulse is not eclipsed, as that ends at 600 m."""
    compression = compression_for(radar(range_max_m=3000, **pulse), 6)
    window, whole = rows_of(compression, columns)
    expected = np.abs(compression.profiles(whole).astype(np.complex128)) ** 2
    sidelobes = RangeSidelobes(compression, noise=1.0)
    for first, stop in ((0, compression.bins), (470, 580), (0, 20), (900, compression.bins)):
        power = sidelobes.power(window, BEGIN, first, stop)
        assert power.dtype == np.float32
        np.testing.assert_allclose(power, expected[:, first:stop], rtol=1e-4, atol=2e-6 * expected.max())


@pytest.mark.parametrize("level_db", [10, 30, 50, 90])
@pytest.mark.parametrize("pulse", PULSES[:2])
def test_beyond_its_reach_a_source_is_below_the_noise(pulse: dict[str, float], level_db: float) -> None:
    compression = compression_for(radar(range_max_m=3000, **pulse), 6)
    level = 10.0 ** (level_db / 20.0)
    window, whole = rows_of(compression)
    total = level * float(np.abs(window).sum(axis=1).max())
    first, stop = RangeSidelobes(compression, noise=1.0).bins(total, BEGIN, COLUMNS)
    magnitude = level * np.abs(compression.profiles(whole))
    beyond = np.concatenate([magnitude[:, :first], magnitude[:, stop:]], axis=1)
    assert beyond.size and beyond.max() < max(1.0, 1e-6 * level)  # single precision


def test_stronger_rows_reach_farther_and_all_as_far_as_single_precision_without_noise() -> None:
    compression = compression_for(radar(range_max_m=3000, pulse_s=4e-6), 6)
    sidelobes, end = RangeSidelobes(compression, noise=1.0), BEGIN + COLUMNS
    bins = [sidelobes.bins(total, BEGIN, COLUMNS) for total in (1.0, 3e2, 1e3, 1e9, 1e20)]
    reach = [BEGIN - first for first, _ in bins]
    assert reach == [stop - end for _, stop in bins]
    assert np.diff(reach[:4]).min() > 0 and reach[0] < 3
    assert 300 <= reach[-1] < 400  # 4 us at 75 MSPS, and the tail of the kernel's correction
    assert RangeSidelobes(compression, noise=0.0).bins(1e-9, BEGIN, COLUMNS) == bins[-1] == bins[-2]
    assert sidelobes.bins(1e9, 100, 8)[0] == 0 and sidelobes.bins(1e9, 1400, 8)[1] == compression.bins


@pytest.mark.parametrize("compression", ["matched", "inverse"])
@pytest.mark.parametrize("limit", [2**22, 0], ids=["by a table", "by transforms"])
@pytest.mark.parametrize("begin", [0, 40, 294, 400], ids=["first column", "near", "the last ones whole", "not at all"])
def test_eclipsed_sources_have_what_is_left_of_their_profiles(
    compression: str, limit: int, begin: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """4 us are 300 samples. What is left may stand out of the noise as far as the response of the filter reaches."""
    monkeypatch.setattr("radar_service.engine.range_sidelobes.MAX_LOST", limit)
    settings = {"pulse_s": 4e-6, "eclipsing": True, "compression": compression, "window": "nuttall"}
    made = compression_for(radar(range_max_m=3000, **settings), 6)
    rng = np.random.default_rng(1)
    window = (rng.normal(size=(2, 20)) + 1j * rng.normal(size=(2, 20))).astype(np.complex64)
    whole = np.zeros((2, made.size), dtype=np.complex64)
    whole[:, begin : begin + 20] = window
    expected = np.abs(made.profiles(whole).astype(np.complex128)) ** 2
    assert made.eclipsing_filter is not None
    assert (begin < 300) == bool(np.abs(made.eclipsing_filter.lost(whole)).max() > 1e-3)
    sidelobes = RangeSidelobes(made, noise=1e-3)
    first, stop = sidelobes.bins(float(np.abs(window).sum(axis=1).max()), begin, 20)
    for part in (slice(0, made.bins), slice(first, stop), slice(100, 150), slice(700, made.bins)):
        power = sidelobes.power(window, begin, part.start, part.stop)
        np.testing.assert_allclose(power, expected[:, part], rtol=1e-4, atol=1e-6 * expected.max())
    assert max(expected[:, :first].max(initial=0.0), expected[:, stop:].max()) < 1e-3
