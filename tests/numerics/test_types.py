"""Array types: what the engine computes has the type that its signatures name."""

from typing import get_args

import numpy as np
import pytest

from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.numerics import types
from radar_service.receive.detection import square_law
from radar_service.records.fidelity import PRESETS
from tests.scenes import point, scene


def element(alias: object) -> type:
    """The element type of an array type."""
    (element_type,) = get_args(get_args(alias)[1])
    return element_type


@pytest.mark.parametrize(
    ("alias", "size"), [("Floats", 8), ("Singles", 4), ("Complexes", 16), ("Profiles", 8), ("Indices", 8), ("Flags", 1)]
)
def test_sizes_of_elements(alias: str, size: int) -> None:
    assert np.dtype(element(getattr(types, alias))).itemsize == size


def test_the_engine_returns_what_it_says() -> None:
    made = scene(
        [point("a", 0, 300), point("b", 100, 300, speed_kn=10)],
        radar={"azimuths": 36, "range_max_m": 500, "beamwidth_deg": 12},
    )
    prepared = prepare(made, PRESETS["balanced"], 1)
    azimuths = tile_azimuths(prepared, 0, 0)
    field, echoes = profiles(prepared, azimuths), prepared.moving.echoes(azimuths)
    assert field.dtype == echoes.amplitude.dtype == element(types.Profiles)
    assert square_law(field).dtype == echoes.range_migration.dtype == element(types.Singles)
    assert echoes.range.dtype == azimuths.time.dtype == element(types.Floats)
    assert azimuths.number.dtype == prepared.resting.body.dtype == element(types.Indices)
    assert prepared.resting.echoes.amplitude.dtype == element(types.Complexes)
