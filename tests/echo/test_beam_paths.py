"""Paths to the antenna: the direct one through a beam that structures shadow."""

import numpy as np

from radar_service.echo.beam_paths import Beam, DirectPath, Sights
from radar_service.echo.echoes import BeamWeightedEchoes
from radar_service.stages.registry import changed_pattern
from tests.scenes import radar

RADAR = radar(structure=[{"bearing_deg": 30, "distance_m": 2, "width_m": 0.3}])
SHADOW = changed_pattern(RADAR, 0.3)


def test_a_shadowed_beam_multiplies_by_the_square_of_its_field() -> None:
    """Two echoes at three azimuths while own ship turns: one behind the mast at the last azimuth, one never."""
    assert SHADOW is not None
    bearing = np.radians([[70.0, 70.0, 71.0], [200.0, 200.0, 200.0]])
    sights = Sights(bearing, np.radians([69.0, 70.0, 71.0]), np.radians([0.0, 20.0, 41.0]))
    amplitude = np.array([[1.0, 2j, 3.0], [1.0, 1.0, 1.0]], dtype=np.complex64)
    echoes = BeamWeightedEchoes(np.array([100.0, 200.0]), np.zeros((2, 3), dtype=np.float32), amplitude, np.array([0, 1]))
    received = DirectPath(Beam(RADAR, SHADOW)).received(echoes, sights)
    field = SHADOW.one_way(np.radians([[70.0, 50.0, 30.0]]), np.radians([[1.0, 0.0, 0.0]]))[0]
    np.testing.assert_allclose(received.amplitude[0], amplitude[0] * field**2, rtol=1e-6)
    assert abs(received.amplitude[0, 2]) < 0.75 * 3.0 and abs(received.amplitude[0, 1]) > 0.9 * 2.0
    assert abs(received.amplitude[1]).max() < 1e-3  # far from the beam
    np.testing.assert_array_equal(received.range, echoes.range)
