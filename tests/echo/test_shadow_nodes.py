"""How fast shadows move over bodies, and the nodes that they need, for fields whose change is known at every spoke."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from radar_service.echo import beam_passage
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.passage_nodes import node_weights
from radar_service.echo.shadow_nodes import CHANGE, SKIPPED, STEADY, Fields, ShadowRates, by_centre, by_range, telling_nodes
from radar_service.engine.pipeline import profiles, tile_azimuths
from radar_service.engine.preparation import prepare
from radar_service.numerics.types import Complexes, Floats, Indices, Profiles
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes, Caster
from tests.scenes import scene

EVERY = np.arange(200, 297)
NONE = np.array([250])


def at_places(field: Floats) -> Fields:
    """Fields of one path, a scattering centre each 2 mm."""
    place = np.stack([0.002 * np.arange(len(field)), np.zeros(len(field)), np.zeros(len(field))], axis=1)
    same = np.zeros(len(field), dtype=np.int64)
    return by_centre(BodyEchoes(place.astype(np.float64), field.astype(np.complex128), same, same, np.zeros(len(field))))


def told(field: Callable[[int], Floats], unshaded: Indices = NONE, slack: float = 1.0) -> tuple[list[int], list[int]]:
    """The nodes, and the spokes at which the field was asked for."""
    asked: list[int] = []

    def evaluate(spokes: Sequence[int], _: int) -> list[Fields]:
        asked.extend(spokes)
        return [at_places(np.atleast_1d(field(spoke))) for spoke in spokes]

    nodes = telling_nodes(EVERY, unshaded, lambda spokes: np.full(len(spokes), slack), evaluate)
    return nodes.tolist(), sorted(set(asked))


def error_between(field: Callable[[int], Floats]) -> float:
    """The largest error at any spoke, between the nodes as spokes have it."""
    nodes, exact = np.array(told(field)[0]), np.array([field(int(spoke)) for spoke in EVERY])
    return float(np.abs(node_weights(nodes, EVERY.astype(np.float64)).T @ exact[nodes - 200] - exact).max())


@pytest.mark.parametrize("field", [lambda _: 3.0, lambda spoke: 1.0 + 0.1j * spoke], ids=["steady", "straight"])
def test_what_is_straight_between_nodes_needs_each_sixteenth(field: Callable[[int], Floats]) -> None:
    """And those that the motion needs. One about the middle of each gap says so, and is no node."""
    nodes, asked = told(field)
    assert nodes == list(range(200, 297, SKIPPED)) and asked[::2] == nodes


def test_nodes_are_close_where_the_field_steps_and_nowhere_else() -> None:
    """From spoke 263 to 264 the field falls by half; the gaps double away from there."""
    nodes, _ = told(lambda spoke: 1.0 if spoke < 264 else 0.5)
    assert {263, 264} < set(nodes) and len(nodes) < 32
    gaps = np.diff(nodes)
    assert gaps.max() < SKIPPED and np.max(np.maximum(gaps[1:] / gaps[:-1], gaps[:-1] / gaps[1:])) <= 2.0


def test_a_step_below_the_limit_is_left_between_two_nodes() -> None:
    steady = len(told(lambda _: 1.0)[0])
    (above, below) = (told(lambda spoke, size=size: 1.0 if spoke < 264 else 1.0 - size)[0] for size in (0.05, 0.015))
    assert len(above) > len(below) == steady


def test_what_moves_from_centre_to_centre_has_changed() -> None:
    """The edge of a shadow crosses centres of equal strength: the sum of powers stays, the field does not."""
    nodes, _ = told(lambda spoke: np.where(np.arange(97) == spoke - 200, 1.0, 0.0))
    assert nodes == EVERY.tolist()


@pytest.mark.parametrize("turns", [*range(2, SKIPPED + 1), 2.5, 7.5, 16.5])
def test_an_edge_with_a_doppler_shift_of_its_own_is_seen(turns: float) -> None:
    """A tenth of the field turns once in so many spokes: for 2, 4, 8 and 16 nodes at equal halves would all be alike."""
    assert error_between(lambda spoke: np.array([1.0, 0.1 * np.exp(2j * np.pi * spoke / turns)])) < CHANGE


def test_motion_that_needs_closer_nodes_keeps_them() -> None:
    nodes, _ = told(lambda _: 3.0, unshaded=np.arange(200, 297, 6))
    assert np.diff(nodes).max() <= 6


def test_a_faint_beam_lets_the_field_change_more() -> None:
    """At 20 dB below the main beam's edge the step of a tenth changes as much as one of a hundredth there."""
    step = 0.1
    loud, faint = (told(lambda spoke: 1.0 if spoke < 264 else 1.0 - step, slack=slack)[0] for slack in (1.0, 10.0))
    assert len(faint) < len(loud)


@pytest.mark.parametrize("width", [2.0, 5.0, 20.0, 100.0])
def test_what_is_between_errs_by_less_than_the_limit(width: float) -> None:
    """An edge that crosses a facet: the field turns as it falls. Cubics between nodes meet it at every spoke."""

    def field(spoke: int) -> Floats:
        fallen = 0.5 + np.arctan((spoke - 251.3) / width) / np.pi
        return np.array([1.0, 0.3 * (1.0 - fallen) * np.exp(2j * fallen)])

    assert error_between(field) < CHANGE
    assert len(told(field)[0]) < len(EVERY)


def test_a_passage_of_two_nodes_keeps_both() -> None:
    nodes = telling_nodes(
        np.array([5, 6]), NONE, lambda spokes: np.ones(len(spokes)), lambda spokes, _: [at_places(np.ones(1))] * len(spokes)
    )
    assert nodes.tolist() == [5, 6]


def test_fields_by_range_do_not_depend_on_the_centres_that_share_them() -> None:
    """A centre 10.3 range cells off, and shares of it 10.1 and 10.4 off, all in phase."""
    radar = scene([]).radar

    def cells(distance: Floats, size: Floats) -> Floats:
        none = np.zeros(len(size), dtype=np.int64)
        distance = distance * radar.range_resolution
        amplitude = size * np.exp(4j * np.pi / radar.wavelength * distance)
        key, field = by_range(
            BodyEchoes(np.zeros((len(size), 3)), amplitude, none, none, np.zeros(len(size))), distance, radar
        )
        return np.asarray(np.bincount(key - key.min(), np.abs(field)))

    one, two = cells(np.array([10.3]), np.array([3.0])), cells(np.array([10.1, 10.4]), np.array([1.0, 2.0]))
    np.testing.assert_allclose(one, two, rtol=1e-9)


KNOT = 1852.0 / 3600.0
HULL = {"shape": "box", "scattering": "optics", "length_m": 6.0, "width_m": 3.0, "height_m": 2.0, "heading_deg": 0}
TIME = np.array([10.0, 10.1, 10.2])
SIZE = float(np.sqrt(6.0**2 + 3.0**2 + 2.0**2))


def rates(target: dict[str, object], other: dict[str, object], **own: object) -> ShadowRates:
    made = scene(
        [{"name": "target", **HULL, **target}, {"name": "other", **HULL, **other}], own_ship={"position_m": [0, 0], **own}
    )
    return ShadowRates(made, made.bodies[0])


def test_a_shadow_moves_as_many_times_faster_as_it_falls_farther_off() -> None:
    """A hull at 500 m that crosses at 10 kn moves its shadow at 20 kn over a body at 1000 m."""
    sideways = {"position_m": [-10.0 * KNOT * 10.1, 500.0, 0.0], "speed_kn": 10.0, "course_deg": 90.0}
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, sideways)
    assert shadow.rate([Caster(1, 500.0)], TIME)[1] == pytest.approx(
        20.0 * KNOT / (STEADY * SIZE), rel=1e-3
    )  # straight course
    assert shadow.moving([1], TIME) == [1]


def test_a_shadow_rests_where_both_keep_one_bearing() -> None:
    """A body at 1000 m and one at 500 m that cross at 10 and 5 kn."""
    both = [
        {"position_m": [-speed * KNOT * 10.1, north, 0.0], "speed_kn": speed, "course_deg": 90.0}
        for speed, north in ((10.0, 1000.0), (5.0, 500.0))
    ]
    assert rates(*both).rate([Caster(1, 500.0)], TIME)[1] < 0.001 * 10.0 * KNOT / (STEADY * SIZE)


def test_own_ship_moves_shadows_of_what_rests() -> None:
    """At 10 kn across, the shadow of what stands half way moves at 10 kn over what rests."""
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, {"position_m": [0.0, 500.0, 0.0]}, speed_kn=10.0, course_deg=90.0)
    assert shadow.rate([Caster(1, 500.0)], TIME)[1] == pytest.approx(
        10.0 * KNOT / (STEADY * SIZE), rel=1e-2
    )  # 52 m aside by then


def test_what_rests_moves_no_shadow_over_what_rests() -> None:
    shadow = rates({"position_m": [0.0, 1000.0, 0.0]}, {"position_m": [0.0, 500.0, 0.0]})
    assert not shadow.rate([Caster(1, 500.0)], TIME).any() and shadow.moving([1], TIME) == []
    swinging = rates(
        {"position_m": [0.0, 1000.0, 0.0]}, {"position_m": [0.0, 500.0, 0.0], "turn_rate_deg_s": 2.0, "heading_deg": None}
    )
    ends = 2.0 * np.deg2rad(2.0) * swinging.body.radius  # of the shadow of a hull that turns on the spot
    assert swinging.rate([Caster(1, 500.0)], TIME)[1] == pytest.approx(ends / (STEADY * SIZE), rel=1e-3)


@pytest.mark.parametrize("width", [80.0, 3.0], ids=["along-its-edge", "across"])
def test_nodes_in_a_moving_shadow_have_the_field_of_all(width: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A low hull sails across before a high one: a long one hides its foot all the while, a short one bit by bit."""
    high = {"name": "high", **HULL, "height_m": 6.0, "position_m": [0.0, 500.0, 0.0], "speed_kn": 0.1}
    sailing = {"position_m": [-10.0 * KNOT * 2.5, 470.0, 0.0], "speed_kn": 10.0, "course_deg": 90.0}
    made = scene([high, {"name": "low", **HULL, "width_m": width, **sailing}], radar={"azimuths": 2048})

    def passage() -> tuple[int, Complexes]:
        moving = prepare(made, PRESETS["balanced"], 1).moving
        numbers = [np.arange(first, first + 16) for first in range(2000, 2096, 16)]
        echoes = [moving.echoes(AzimuthTimes(number, *made.radar.schedule(number))) for number in numbers]
        nodes = moving.passages.nodes(0, moving.passages.crossing(0, 1.0))
        return len(nodes), np.concatenate([each.amplitude.sum(axis=0) for each in echoes])

    few, field = passage()
    monkeypatch.setattr("radar_service.echo.beam_passage.telling_nodes", lambda nodes, *_: nodes)
    every, exact = passage()
    assert np.abs(field - exact).max() < CHANGE * np.abs(exact).max() and few < every / 4


def rolling(
    name: str, size: tuple[float, float, float], place: tuple[float, float], way: tuple[float, float, float, float]
) -> dict[str, Any]:
    """A hull of length, beam and height; way: course [deg], speed [kn], roll [deg] and its period [s]."""
    keys = ("length_m", "beam_m", "height_m", "course_deg", "speed_kn", "roll_deg", "roll_period_s")
    sway = {"pitch_deg": 2, "pitch_period_s": 5, "position_m": [*place, 0]}
    return {"name": name, "shape": "hull", **sway, **dict(zip(keys, (*size, *way), strict=True))}


FAR = rolling("far", (110, 17.6, 20), (3553.91, -1407.345), (51.76, 6.877, 12.05, 9.29))
BEFORE = rolling("near", (88, 14.08, 14), (3401.11, -1403.777), (238.87, 12.266, 6.845, 11.83))
BOAT = rolling("boat", (12, 3.5, 2.6), (-676.9, 2099.3), (233.9, 6.6, 9.2, 11.2))
SHIP = {"speed_kn": 12, "course_deg": 193.92, "roll_deg": 5, "roll_period_s": 7, "pitch_deg": 2, "pitch_period_s": 5}


@pytest.mark.parametrize(
    ("bodies", "own_ship", "radar", "air", "spokes"),
    [
        ([FAR, BEFORE], SHIP, {"azimuths": 1024, "beamwidth_deg": 0.8, "rpm": 48}, {"multipath": True}, (1312, 1376)),
        ([BOAT], {}, {"azimuths": 720, "beamwidth_deg": 5.0, "rpm": 24}, {}, (2800, 2880)),
    ],
    ids=["half-behind-another", "alone"],
)
def test_rolling_hulls_have_the_field_of_an_aspect_at_each_spoke(
    bodies: list[Any], own_ship: dict[str, Any], radar: dict[str, Any], air: dict[str, Any], spokes: tuple[int, int],
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    """Within 5 % of the largest cell; 60 % off where a shadow's edge moves by 3 wavelengths, 10 % by a third of the height."""
    made = scene(bodies, radar={**radar, "range_max_m": 6000, "pulse_s": 2e-7}, own_ship=own_ship, environment=air)

    def field() -> Profiles:
        prepared = prepare(made, PRESETS["balanced"], 1)
        tiles = range(spokes[0], spokes[1], prepared.tile)
        return np.concatenate(
            [profiles(prepared, tile_azimuths(prepared, *divmod(first, made.radar.azimuths))) for first in tiles]
        )

    few = field()
    monkeypatch.setattr(
        beam_passage, "part_nodes", lambda stretch, *_: np.arange(round(stretch.first), round(stretch.last) + 1)
    )
    monkeypatch.setattr(beam_passage, "telling_nodes", lambda nodes, *_: nodes)
    monkeypatch.setattr(beam_passage, "NODES_PER_BODY", 500)
    every = field()
    assert np.abs(few - every).max() < 0.05 * np.abs(every).max()
