"""The short modules of stages, each under its name."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pytest
from pydantic import Field, TypeAdapter, ValidationError

import radar_service as rs
from radar_service.echo.echoes import AzimuthTimes
from radar_service.effects import Attenuator, Effect, Stage
from radar_service.engine import land_rows
from radar_service.numerics.constants import MAX_COORDINATE
from radar_service.receive.compression import receiver_noise_power
from radar_service.stages.fields import MAX_HEIGHT, MIN_HEIGHT, EastNorthUp, Number, Section, record_of
from radar_service.stages.interference.effect import InterferenceEffect
from radar_service.stages.points import in_sight, point_echoes
from radar_service.stages.stage import Added, RandomField, Tile
from radar_service.trace.line_of_sight import OcclusionScene
from radar_service.truth.truth_file import scene_hash
from tests.scenes import point, scene
from tests.stages.fixtures import Installed, context_of

# points: echoes of points by the radar equation; `tests/plug_ins` holds them against a body that is a point.
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


# effect: what all effects have in common.
OTHER = {"bearing_deg": 40, "level_db": 60}


def test_an_effect_is_in_a_scene_that_has_its_record() -> None:
    effect = InterferenceEffect()
    assert (
        effect.is_in(scene(interference=[OTHER])) and not effect.is_in(scene()) and not effect.is_in(scene(interference=[]))
    )
    assert len(effect.of_scene(scene(interference=[OTHER, OTHER]))) == 2 and effect.of_scene(scene()) is None
    assert effect.stage().__name__ == "InterferenceStage"


@dataclass(frozen=True)
class Fog(Attenuator):
    """A decibel in 100 m of fog, east of a line that comes nearer."""

    speed: float
    text = "fog"

    def one_way_db(self, radar: Any, lines: Any) -> Any:
        border = 1000.0 - self.speed * np.asarray(lines.time) - np.asarray(lines.antenna)[..., 0]
        return np.maximum(lines.distance - border / np.maximum(np.sin(lines.azimuth), 1e-9), 0.0) / 100.0


class FogStage(Stage):
    """Adds nothing."""


class FogEffect(Effect):
    """Fog on the east."""

    name, stage_at = "fog", f"{__name__}:FogStage"
    environment_keys = {"fog": (tuple[float, ...], Field(()))}

    def environment_value(self, key: str, value: Sequence[float]) -> Any:
        return Fog(value[0]) if value else ()


QUAY = {"name": "quay", "shape": "box", "length_m": 20, "width_m": 300, "height_m": 8, "material": "concrete"}


@pytest.mark.parametrize("own_ship", [{}, {"speed_kn": 10, "course_deg": 45}], ids=["at rest", "under way"])
@pytest.mark.parametrize("body", [point("buoy", 1300, 200), QUAY | {"position_m": [1300, 200, 0]}], ids=["point", "land"])
def test_what_attenuates_by_place_and_time_acts_on_all_echoes(
    installed: Installed, monkeypatch: pytest.MonkeyPatch, own_ship: dict[str, Any], body: dict[str, Any]
) -> None:
    """Two ways through fog take 2 dB in 100 m, of land on its grid too, and more as the fog comes nearer."""
    installed.package("fogs", FogEffect)
    monkeypatch.setattr(land_rows, "ROW_SECONDS", 0.0)
    radar = {"range_max_m": 2000, "azimuths": 360, "beamwidth_deg": 2}
    clear, foggy = (
        scene([body], radar=radar, own_ship=own_ship, environment={"fog": fog} if fog else {}) for fog in ((), (20.0,))
    )
    assert scene_hash(clear) != scene_hash(foggy)
    free, dim = (rs.Simulator(made, "fast", seed=3) for made in (clear, foggy))
    assert "fog" in str(dim.plan)
    for _ in range(2):
        free_scan, dim_scan = free.scan(), dim.scan()
        row, cell = np.unravel_index(free_scan.power.argmax(), free_scan.power.shape)
        east, *_ = foggy.antenna(free_scan.time[row : row + 1])[0]
        distance, sine = free_scan.range[cell], np.sin(free_scan.azimuth[row])
        lost = 2.0 * (distance - (1000.0 - 20.0 * free_scan.time[row] - east) / sine) / 100.0
        np.testing.assert_allclose(10.0 * np.log10(free_scan.power[row, cell] / dim_scan.power[row, cell]), lost, atol=0.1)


# fields: types of values in a scene file, records in SI units, and what is wrong with several keys together.
@pytest.mark.parametrize("value", [True, "12", None])
def test_only_numbers_are_numbers(value: Any) -> None:
    with pytest.raises(ValidationError):
        TypeAdapter(Number).validate_python(value)


def test_positions_end_at_their_limits() -> None:
    position = TypeAdapter(EastNorthUp)
    for limit in ((MAX_COORDINATE, -MAX_COORDINATE, MIN_HEIGHT), (0, 0, MAX_HEIGHT)):
        assert position.validate_python(limit) == limit
    for beyond in ((MAX_COORDINATE + 1, 0, 0), (0, -MAX_COORDINATE - 1, 0), (0, 0, MIN_HEIGHT - 1), (0, 0, MAX_HEIGHT + 1)):
        with pytest.raises(ValidationError):
            position.validate_python(beyond)


class Ferry(Section):
    """Keys with every kind of unit."""

    name: str = "ferry"
    course_deg: float = 90.0
    turn_rate_deg_s: float | None = None
    speed_kn: float = 10.0
    share_percent: float = 5.0
    power_dbm: float = 30.0
    gain_dbi: float = 20.0
    length_m: float = 60.0
    deck_m2: float = 900.0
    sectors_deg: tuple[tuple[float, float], ...] = ((0.0, 180.0),)
    seats: int = 7

    def problems(self) -> Iterator[str]:
        if self.seats > 9:
            yield f"seats: {self.seats} are too many; give 9"
        if self.seats > 8:
            yield "seats: never told"


@dataclass(frozen=True)
class FerryRecord:
    name: str
    course: float
    speed: float
    share: float
    power: float
    gain: float
    length: float
    deck: float
    sectors: tuple[tuple[float, float], ...]
    seats: int
    turn_rate: float | None = 3.0


def test_a_record_has_the_keys_of_its_fields_in_si_units() -> None:
    half = math.pi / 2.0
    assert record_of(FerryRecord, Ferry(), length=1.0) == FerryRecord(
        "ferry", half, 10.0 * 1852.0 / 3600.0, 0.05, 1.0, 100.0, 1.0, 900.0, ((0.0, math.pi),), 7, None
    )


class Wake(NamedTuple):
    speed: float
    width: float


def test_a_field_without_a_key_is_named_with_the_keys_and_the_units() -> None:
    with pytest.raises(TypeError) as told:
        record_of(Wake, Ferry())
    assert str(told.value).startswith(
        "Wake.width: Ferry has no key of this name and a known unit (its keys: name, course_deg, "
    )
    assert str(told.value).endswith(
        "_m, _m2, _s, _per_s, _hz, _w, _db, _dbi, _dbsm, _dbm); rename one, or give width= to record_of"
    )
    assert record_of(Wake, Ferry(), width=2.0).width == 2.0


def test_keys_that_differ_by_their_unit_alone_are_not_one_value() -> None:
    class Wakes(Section):
        speed_kn: float = 1.0
        width_m: float = 1.0
        width_deg: float = 90.0

    with pytest.raises(TypeError, match=r"^Wake.width: Wakes has width_m and width_deg; give width= to record_of$"):
        record_of(Wake, Wakes())
    assert record_of(Wake, Wakes(), width=2.0).width == 2.0


def test_the_first_problem_is_told() -> None:
    assert Ferry(seats=8).seats == 8
    with pytest.raises(ValidationError, match="seats: 12 are too many; give 9") as refused:
        Ferry(seats=12)
    assert "never" not in str(refused.value)
