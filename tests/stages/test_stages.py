"""The short modules of stages, each under its name."""

import numpy as np
import pytest

from radar_service.echo.echoes import AzimuthTimes
from radar_service.receive.compression import receiver_noise_power
from radar_service.stages.points import in_sight, point_echoes
from radar_service.stages.stage import Added, RandomField, Tile
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import scene
from tests.stages.fixtures import context_of

# points: echoes of points by the radar equation; `tests/plug_ins/effects` holds them against a body that is a point.
WALL = {"name": "wall", "shape": "plate", "width_m": 200, "height_m": 80, "position_m": [0, 900, 0]}


def test_points_out_of_range_out_of_sight_and_behind_a_wall_have_no_echoes() -> None:
    """The others have the power of the radar equation (Skolnik 2001, eq. 1.7) on boresight, and the change of their ranges."""
    made = scene([WALL], radar={"range_max_m": 5000})
    line_of_sight = OcclusionScene(made.bodies, 8.5e6)
    context = context_of(made, "hail")._replace(line_of_sight=line_of_sight, echo_sources={"hail": 1})
    azimuths = AzimuthTimes(np.arange(3), np.zeros(3), np.arange(3) * 0.1)
    start = np.array([[0.0, 500, 15], [0, 1500, 15], [0, 4000, 0], [0, 90_000, 15], [0, 600, 15]])
    position = start[:, None] + np.array([0.0, 10.0, 0.0]) * azimuths.time[:, None]
    assert in_sight(made, line_of_sight, start, 0.1).tolist() == [True, False, False, False, True]
    far = np.array([[0.0, -90_000, 15]])  # beyond the horizon, where a field reaches one that is lower than 20 m
    assert [in_sight(made, line_of_sight, far, 0.1, reach).tolist() for reach in (0.0, 20.0)] == [[False], [True]]
    echoes = point_echoes(context, "hail", azimuths, position, np.array([1.0, 1.0, 1.0, 1.0, 4.0]))
    assert echoes.range == pytest.approx([501.0, 601.0], abs=0.05) and echoes.body.tolist() == [1, 1]
    np.testing.assert_allclose(echoes.range_migration, [[-1.0, 0.0, 1.0]] * 2, atol=1e-3)
    radar = made.radar
    power = radar.power * radar.gain**2 * radar.wavelength**2 / ((4 * np.pi) ** 3 * echoes.range**4 * radar.loss)
    assert np.abs(echoes.amplitude[:, 1]) ** 2 == pytest.approx(power * [1.0, 4.0], rel=1e-3)


# stage: what stages are made from, and how they add to a tile.
def test_a_tile_keeps_who_added_what_and_adds_it_to_the_field() -> None:
    azimuths, field = AzimuthTimes(np.arange(3), np.zeros(3), np.zeros(3)), np.zeros((3, 4), dtype=np.complex64)
    tile, profile = Tile(azimuths, np.ones(3, dtype=np.bool_), field, Added()), np.arange(4) + 1j
    for source, row in ((5, 1), (5, 1), (6, 2)):
        tile.add(source, row, profile)
    np.testing.assert_array_equal(field, np.stack([0 * profile, 2 * profile, profile]))
    assert tile.added and {n: {*rows} for n, rows in tile.added.profiles.items()} == {5: {1}, 6: {2}}
    np.testing.assert_array_equal(tile.added.profiles[5][1], 2 * profile)
    drawn = RandomField(np.ones((3, 2), dtype=np.complex64), np.ones(2, dtype=np.float32))
    tile.add_field(drawn)
    np.testing.assert_array_equal(field[:, :2], [[1, 1], [1 + 2j, 3 + 2j], [1 + 1j, 2 + 1j]])
    np.testing.assert_array_equal(field[1, 2:], 2 * profile[2:])
    assert tile.added.fields == [drawn]


def test_random_numbers_are_those_of_the_name_of_an_effect() -> None:
    made = scene()

    def drawn(name: str, seed: int, *key: int) -> float:
        context = context_of(made, name, seed)
        assert context.noise_power == receiver_noise_power(made.radar)
        return float(context.random(*key).random())

    draws = [drawn("hail", 0), drawn("hail", 0, 1), drawn("birds", 0), drawn("hail", 1)]
    assert len(set(draws)) == 4 and drawn("hail", 0) == draws[0]
