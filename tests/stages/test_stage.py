"""What stages are made from, and how they add to a tile."""

import numpy as np

from radar_service.echo.echoes import AzimuthTimes
from radar_service.receive.compression import receiver_noise_power
from radar_service.stages.stage import Added, RandomField, Tile
from tests.scenes import scene
from tests.stages.fixtures import context_of


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
