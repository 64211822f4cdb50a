"""Rows of each source against all echoes on one grid."""

import numpy as np
import pytest

from radar_service.echo.echoes import SECOND_TIME, BeamWeightedEchoes
from radar_service.engine.preparation import prepare
from radar_service.engine.source_rows import source_rows
from radar_service.fidelity import PRESETS
from tests.scenes import scene

NUMBERS = np.array([256, 257, 20, 259, 4])


def echoes(seed: int, azimuths: int, bodies: list[int], ranges: list[float]) -> BeamWeightedEchoes:
    rng = np.random.default_rng(seed)
    shape = len(bodies), azimuths
    amplitude = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)
    migration = rng.uniform(-1, 1, shape).astype(np.float32)
    return BeamWeightedEchoes(np.array(ranges), migration, amplitude, np.array(bodies))


@pytest.mark.parametrize("eclipsing", [False, True])
def test_rows_of_all_sources_add_up_to_those_of_all_echoes(eclipsing: bool) -> None:
    """Body 0 is wide, body 1 stands near range 0, and body 2 gets whole rows because it is asked to."""
    radar = {"range_max_m": 1200, "azimuths": 64, "beamwidth_deg": 8, "pulse_s": 1e-6, "eclipsing": eclipsing}
    prepared = prepare(scene(radar=radar), PRESETS["balanced"], 0)
    blocks = [
        (0, 3, echoes(1, 3, [0, 3, 0, 1, SECOND_TIME, 2], [300.0, 600.0, 900.0, 3.0, 500.0, 700.0])),
        (3, 5, echoes(2, 2, [3, 0, SECOND_TIME], [610.0, 310.0, 1100.0])),
    ]
    rows = source_rows(prepared, blocks, NUMBERS, 5, whole=[20])
    expected, compression, step = np.zeros((5, prepared.compression.size), dtype=np.complex64), prepared.compression, 0.0
    step = prepared.scene.radar.range_step
    for first, stop, each in blocks:
        compression.spread(
            expected[first:stop], each.range / step - 0.5, each.range_migration / np.float32(step), each.amplitude
        )
    total, seen = np.zeros_like(expected), []
    for number, gridded in rows.whole.items():
        total += gridded
        seen.append(number)
    for numbers, begin, windows in rows.windows():
        for s, number in enumerate(numbers.tolist()):
            total[:, begin[s] : begin[s] + windows.shape[2]] += windows[:, s]
            seen.append(number)
    np.testing.assert_allclose(total, expected, atol=3e-3)  # the kernel's tables
    assert sorted(seen) == [4, 20, 256, 257, 259]
    assert set(rows.whole) == ({4, 20, 256, 257, 259} if eclipsing else {20, 257})
    everything = source_rows(prepared, blocks, NUMBERS, 5)
    np.testing.assert_allclose(everything.whole[20], rows.whole[20])
    assert len(everything.whole) == 5 and not len(everything.number)


def test_no_echoes_have_no_rows() -> None:
    prepared = prepare(scene(radar={"range_max_m": 600, "pulse_s": 1e-6}), PRESETS["balanced"], 0)
    rows = source_rows(prepared, [], NUMBERS, 5, whole=[])
    assert not rows.whole and list(rows.windows()) == []
