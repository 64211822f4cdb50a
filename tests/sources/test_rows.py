"""Rows of each source against all echoes on one grid."""

import numpy as np
import pytest

from radar_service.echo.echoes import SECOND_TIME, BeamWeightedEchoes
from radar_service.engine.pipeline import Contributions
from radar_service.engine.preparation import Prepared, prepare
from radar_service.numerics.types import Profiles
from radar_service.records.fidelity import PRESETS
from radar_service.sources.rows import source_rows, spread_echoes
from tests.scenes import scene

NUMBERS = np.array([256, 257, 20, 259, 260, 4])
RADAR = {"range_max_m": 1200, "azimuths": 64, "beamwidth_deg": 8, "pulse_s": 1e-6}


def echoes(seed: int, azimuths: int, bodies: list[int], ranges: list[float]) -> BeamWeightedEchoes:
    rng = np.random.default_rng(seed)
    shape = len(bodies), azimuths
    amplitude = (rng.normal(size=shape) + 1j * rng.normal(size=shape)).astype(np.complex64)
    migration = rng.uniform(-1, 1, shape).astype(np.float32)
    return BeamWeightedEchoes(np.array(ranges), migration, amplitude, np.array(bodies))


def recorded(prepared: Prepared) -> tuple[Contributions, dict[int, Profiles]]:
    """A tile of five azimuths, the last one blind, and the rows of each source by itself.

    Bodies 0 and SECOND_TIME are wide and overlap, 3 and 4 are alone, 1 stands near range 0, and 2 is asked for as a whole.
    """
    blocks = [
        (0, 3, echoes(1, 3, [0, 3, 0, 1, SECOND_TIME, 2], [300.0, 600.0, 420.0, 3.0, 400.0, 700.0])),
        (3, 5, echoes(2, 2, [4, 3, 0, SECOND_TIME], [1000.0, 610.0, 310.0, 480.0])),
    ]
    size, sources = prepared.compression.size, {}
    for first, stop, each in blocks:
        for body in np.unique(each.body).tolist():
            rows = sources.setdefault(int(NUMBERS[body]), np.zeros((5, size), dtype=np.complex64))
            spread_echoes(prepared, rows[first:stop], each.chosen(np.flatnonzero(each.body == body)))
    for rows in sources.values():
        rows[4] = 0.0
    transmitting = np.array([True, True, True, True, False])
    return Contributions(transmitting, blocks, sum(sources.values()), None), sources


@pytest.mark.parametrize("eclipsing", [False, True], ids=["", "eclipsing"])
def test_each_source_has_the_rows_of_its_echoes_alone(eclipsing: bool) -> None:
    prepared = prepare(scene(radar=RADAR | {"eclipsing": eclipsing}), PRESETS["balanced"], 0)
    record, expected = recorded(prepared)
    rows = source_rows(prepared, record, NUMBERS, full_rows=[20])
    got = dict(rows.full_rows)
    for windows in rows.windows:
        assert (np.diff(windows.at) > 0).all()
        for number, begin, at, width in zip(windows.number, windows.begin, windows.at, windows.width, strict=True):
            assert number not in got and width < 110
            got[int(number)] = np.zeros_like(expected[20])
            got[int(number)][:, begin : begin + width] = windows.grid[:, at : at + width]
    assert set(got) == set(expected) == set(NUMBERS.tolist())
    for number in got:
        np.testing.assert_allclose(got[number], expected[number], atol=3e-3, err_msg=str(number))  # the kernel's tables
    assert set(rows.full_rows) == {20, 257}
    assert [set(windows.number.tolist()) for windows in rows.windows] == [{259, 260}, {4, 256}]
    assert rows.windows[0].grid is record.rows
    assert set(source_rows(prepared, record, NUMBERS, NUMBERS.tolist()).full_rows) == set(expected)


def test_columns_that_wrap_around_the_row_are_nobodys_alone() -> None:
    prepared = prepare(scene(radar=RADAR), PRESETS["balanced"], 0)
    size, step = prepared.compression.size, prepared.scene.radar.range_step
    first, last = echoes(1, 1, [0], [1.0]), echoes(2, 1, [3], [(size - 4.5) * step])
    for pair, alone in (([first, last], set()), ([last], {259})):
        rows = np.zeros((1, size), dtype=np.complex64)
        for each in pair:
            spread_echoes(prepared, rows, each)
        record = Contributions(np.ones(1, dtype=bool), [(0, 1, each) for each in pair], rows, None)
        made = source_rows(prepared, record, NUMBERS)
        assert set(made.windows[0].number.tolist()) == alone


def test_no_echoes_have_no_rows() -> None:
    prepared = prepare(scene(radar=RADAR), PRESETS["balanced"], 0)
    rows = source_rows(prepared, Contributions(), NUMBERS)
    assert not rows.full_rows and not rows.windows
