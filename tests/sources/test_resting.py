"""The fields of sources at rest, each by itself."""

import numpy as np
import pytest

from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import prepare
from radar_service.records.fidelity import PRESETS
from radar_service.sources.numbers import source_numbers
from radar_service.sources.rows import resting_fields
from tests.alone import Alone
from tests.scenes import point, scene

RADAR = {"range_max_m": 1200, "azimuths": 64, "beamwidth_deg": 8, "pulse_s": 1e-6}
BODIES = [point("a", 100, 200), point("b", 10, 5, 3), point("c", -600, 900, rcs_dbsm=30)]


@pytest.mark.parametrize("eclipsing", [False, True])
def test_each_field_is_that_of_the_body_alone(eclipsing: bool) -> None:
    """To single precision of the strongest sample; b is so near that its kernel wraps."""
    made = scene(BODIES, radar=RADAR | {"eclipsing": eclipsing})
    prepared = prepare(made, PRESETS["balanced"], 0)
    fields = dict(resting_fields(prepared, source_numbers(made), 0.0))
    assert list(fields) == [256, 257, 258]
    total = np.zeros((64, made.radar.bins), dtype=np.complex64)
    separate = Alone(made)
    for k, (rows, field) in enumerate(fields.values()):
        alone = separate.bodies([k], 0)
        whole = np.zeros_like(alone)
        whole[rows] = field
        np.testing.assert_allclose(whole, alone, atol=2e-7 * np.abs(alone).max())
        total += whole
    together = np.concatenate([field for _, field, _ in Engine(prepared).tiles(0)])
    np.testing.assert_allclose(total, together, atol=1e-6 * np.abs(together).max())


def test_rows_below_the_floor_are_left_out() -> None:
    made = scene(BODIES[:1], radar=RADAR)
    prepared = prepare(made, PRESETS["balanced"], 0)
    power = np.abs(Alone(made).bodies([0], 0)).max(axis=1) ** 2
    floor = float(power.max()) * 1e-3
    ((_, kept),) = resting_fields(prepared, source_numbers(made), floor)
    assert kept.rows.tolist() == np.flatnonzero(power > floor).tolist() and 1 < len(kept.rows) < 20
    added = np.zeros((8, made.radar.bins), dtype=np.complex64)
    kept.add_to(added, int(kept.rows[1]))
    np.testing.assert_array_equal(added[0], kept.field[1])
    assert not added[len(kept.rows) - 1 :].any()
