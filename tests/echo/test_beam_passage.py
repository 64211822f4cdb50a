"""Aspects along the pass of the beam: turning plates against the far field at each spoke, and when bodies are evaluated."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.echo.beam_passage import BeamPassages
from radar_service.echo.echoes import AzimuthTimes
from radar_service.echo.passage_nodes import ALL_ROUND, CUBIC_PHASE, MAIN_BEAM, Part
from radar_service.engine.pipeline import Engine
from radar_service.engine.preparation import Prepared, prepare
from radar_service.plan.budget import ErrorBudget
from radar_service.plan.settings_search import fidelity_for
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.physical_optics.model import OpticalBody
from radar_service.world.body import Body
from radar_service.world.motion import Motion
from tests.reference.compressed_pulse import sinc2_beam
from tests.scattering.physical_optics.test_ships_under_way import spokes as spoke_fields
from tests.scenes import point, scene

Floats = NDArray[np.float64]
WAVELENGTH = 299_792_458.0 / 9.41e9
RADAR = {"azimuths": 720, "beamwidth_deg": 2.0, "height_m": 15.0, "range_max_m": 99_000, "bandwidth_hz": 5e6}


def turning(body: Body, time: float, heading: float, rate: float) -> Body:
    """The body turning in place at `rate` [rad/s], with a heading at a time; knots every 1.5 rad."""
    knots = np.arange(-40, 40) * (1.5 / rate) + time
    motion = Motion(knots, np.repeat(body.motion.position[:1], len(knots), 0), heading + rate * (knots - time), turning=True)
    return replace(body, motion=motion)


def turning_plate(
    width: float, distance: float, bearing_deg: float, scan: int, rpm: float, off_deg: float, rate_deg: float = 3.0
) -> tuple[rs.Scene, float]:
    """A plate 1 m high, level with the antenna, that turns at `rate_deg` per second and is `off_deg` from its normal in a scan;
    and when the beam points at it then."""
    b = np.deg2rad(bearing_deg)
    plate = {"name": "p", "shape": "plate", "width_m": width, "height_m": 1.0, "scattering": "optics",
             "position_m": [distance * np.sin(b), distance * np.cos(b), 14.5]}  # fmt: skip
    made = scene([plate], radar=RADAR | {"rpm": rpm}, environment={"earth": "flat"})
    time = (scan + bearing_deg / 360) * made.radar.rotation_period
    body = turning(made.bodies[0], time, b + np.pi + np.deg2rad(off_deg), np.deg2rad(rate_deg))
    return made.with_world(bodies=(body,)), time


def far_field(made: rs.Scene, width: float, distance: float, bearing: float, azimuths: AzimuthTimes) -> Floats:
    """Amplitudes (K,) on a sinc2 beam: sqrt(4 pi) A / lambda cos(i) sinc(2 w sin(i) / lambda) at the aspect of each spoke."""
    radar = made.radar
    aspect = made.bodies[0].motion.pose(azimuths.time).heading - bearing - np.pi
    rcs = np.sqrt(4 * np.pi) * width / WAVELENGTH * np.cos(aspect) * np.sinc(2 * width * np.sin(aspect) / WAVELENGTH)
    level = np.sqrt(radar.power * radar.gain**2 * radar.wavelength**2 / (4 * np.pi) ** 3) / distance**2
    off = (azimuths.boresight - bearing + np.pi) % (2 * np.pi) - np.pi
    return np.abs(level * rcs * sinc2_beam(off, radar.beamwidth))


def around(made: rs.Scene, time: float, spokes: int, prepared: Prepared) -> AzimuthTimes:
    """Spokes on both sides of a time, none before the start."""
    middle = round(time / made.radar.spoke_period)
    number = np.arange(max(0, middle - spokes), middle + spokes)
    return AzimuthTimes(number, *made.radar.schedule(number))


def blocks(azimuths: AzimuthTimes, size: int) -> list[AzimuthTimes]:
    return [azimuths.part(k, k + size) for k in range(0, len(azimuths.number), size)]


def narrowband(prepared: Prepared, azimuths: AzimuthTimes) -> Floats:
    """Magnitudes (K,) of the sum of all echoes, each with its phase."""
    size = prepared.fidelity.azimuths_per_block
    return np.concatenate([np.abs(prepared.moving.echoes(one).amplitude.sum(axis=0)) for one in blocks(azimuths, size)])


@pytest.mark.sample(12)
@pytest.mark.parametrize("bearing_deg", [0.0, 0.1, 180.0, 359.9])
@pytest.mark.parametrize(
    ("width", "distance", "off_deg"),
    [(2.0, 3000.0, 0.2), (2.0, 3000.0, -0.75), (10.0, 95_000.0, 0.03), (10.0, 95_000.0, -0.2)],
)
@pytest.mark.parametrize(("rpm", "scan"), [(24, 1), (24, 7000), (48, 3), (12, 2)])
def test_a_turning_plate_has_the_aspect_of_each_spoke(
    width: float, distance: float, off_deg: float, bearing_deg: float, rpm: float, scan: int
) -> None:
    """1 dB (required) at every spoke within 20 dB of the greatest one. Plates are in their far field: k w^2 / 4 R is 0.05 rad."""
    made, time = turning_plate(width, distance, bearing_deg, scan, rpm, off_deg)
    prepared = prepare(made, PRESETS["balanced"], 0)
    azimuths = around(made, time, 16, prepared)
    exact = far_field(made, width, distance, np.deg2rad(bearing_deg), azimuths)
    result = narrowband(prepared, azimuths)
    loud = exact > 0.1 * exact.max()
    assert loud.sum() >= 5
    assert np.abs(20 * np.log10(result[loud] / exact[loud])).max() < 1.0


@pytest.mark.parametrize("off_lobes", [-1.2, -0.7, -0.4, 0.0, 0.2, 0.5, 1.1])
def test_one_node_serves_a_passage_up_to_a_quarter_of_a_radian(off_lobes: float) -> None:
    """10 m at 12 rpm and 2.8 degrees/s: the ends of a cell change their phase by 0.246 rad to the edge of the main beam, so one
    node errs by up to 4 %, against the plate's level over a lobe both ways. 0.12 is required; it takes 0.5 rad."""
    width, distance, lobe = 10.0, 95_000.0, np.rad2deg(WAVELENGTH / 20.0)

    def exact(off_deg: float) -> Floats:
        return far_field(turning_plate(width, distance, 90.0, 2, 12, off_deg, 2.8)[0], width, distance, np.pi / 2, azimuths)

    made, time = turning_plate(width, distance, 90.0, 2, 12, off_lobes * lobe, 2.8)
    prepared = prepare(made, PRESETS["balanced"], 0)
    azimuths, each = around(made, time, 16, prepared), prepared.moving.passages
    assert len(each.nodes(0, each.crossing(0, 2.25))) == 1
    local = np.sqrt(np.mean([exact((off_lobes + aside) * lobe) ** 2 for aside in np.linspace(-1, 1, 17)], axis=0))
    floor, error = (
        np.maximum(exact(off_lobes * lobe), local),
        np.abs(narrowband(prepared, azimuths) - exact(off_lobes * lobe)),
    )
    off = np.abs(azimuths.boresight % (2 * np.pi) - np.pi / 2)
    main = sinc2_beam(off, made.radar.beamwidth) > MAIN_BEAM
    assert main.sum() >= 5 and (error / floor)[main].max() < 0.05
    faster = passages(turning_plate(width, distance, 90.0, 2, 12, off_lobes * lobe, 3.0)[0])
    assert len(faster.nodes(0, faster.crossing(0, 2.25))) > 1


@pytest.mark.parametrize("off_deg", [0.0, 3.0])
def test_the_reference_has_the_aspect_in_every_sidelobe(off_deg: float) -> None:
    """All round, 2 m at 3 degrees/s sweep 16 lobes in a scan: within 20 dB of the greatest at that gain, 1 dB (required). The
    beam is flat there: levels are divided by its gain."""
    made, time = turning_plate(2.0, 3000.0, 90.0, 2, 24, off_deg)
    prepared = prepare(made, PRESETS["reference"], 0)
    step = 8  # spokes: one in eight
    middle = round(time / made.radar.spoke_period)
    number = np.arange(middle - 352, middle + 352, step)
    azimuths = AzimuthTimes(number, *made.radar.schedule(number))
    off = azimuths.boresight - np.pi / 2
    gain = sinc2_beam((off + np.pi) % (2 * np.pi) - np.pi, made.radar.beamwidth)
    seen = gain > 1e-6  # not in nulls of the beam, where tables of its gain err
    result = narrowband(prepared, azimuths)[seen] / gain[seen]
    exact = far_field(made, 2.0, 3000.0, np.pi / 2, azimuths)[seen] / gain[seen]
    loud = exact > 0.1 * exact.max()
    assert loud.sum() > 5
    assert np.abs(20 * np.log10(result[loud] / exact[loud])).max() < 1.0


def passages(made: rs.Scene, name: str = "balanced") -> BeamPassages:
    return prepare(made, PRESETS[name], 0).moving.passages


PLATE = {"name": "p", "shape": "plate", "width_m": 3, "height_m": 1, "scattering": "optics", "position_m": [0, 2000, 14.5]}


@pytest.mark.parametrize("scan", [0, 1, 7, 40])
@pytest.mark.parametrize("bearing_deg", [0.0, 1.0, 90.0, 200.0, 359.5])
def test_the_boresight_points_at_the_body_at_its_crossing(scan: int, bearing_deg: float) -> None:
    """To half a spoke, from wherever within a quarter of a scan it starts; never another crossing."""
    b = np.deg2rad(bearing_deg)
    body = PLATE | {"position_m": [1000 * np.sin(b), 1000 * np.cos(b), 10], "speed_kn": 14, "course_deg": 70}
    made = scene([body], own_ship={"speed_kn": 9})
    each, radar = passages(made), made.radar
    spoke = each.crossing(0, scan + bearing_deg / 360)
    position = made.bodies[0].middle_at(spoke * radar.spoke_period) - made.antenna(spoke * radar.spoke_period)[0]
    off = (np.arctan2(position[0], position[1]) - radar.schedule(np.array([spoke]))[0][0] + np.pi) % (2 * np.pi) - np.pi
    assert abs(off) < 0.51 * radar.azimuth_step
    crossed = spoke / radar.azimuths
    assert abs(crossed - scan - bearing_deg / 360) < 0.2  # 14 and 9 kn for up to 100 s
    assert {each.crossing(0, crossed + d) for d in (-0.24, -0.1, 0.0, 0.2, 0.24)} == {spoke}


def test_a_passage_due_north_is_one_over_the_boundary_of_scans() -> None:
    """The last spokes of a scan and the first of the next one take the same nodes."""
    made = scene([PLATE | {"speed_kn": 10, "course_deg": 90, "position_m": [-20, 2000, 14.5]}])
    each, radar = passages(made), made.radar
    for scan in (1, 2, 3, 4, 5):
        found = []
        for number in (scan * radar.azimuths - 5, scan * radar.azimuths + 5):
            boresight, time = radar.schedule(np.array([number]))
            found.append(each.passing(float(time[0]), float(boresight[0]), 0.1))
        assert found[0] == found[1] and abs(found[0][0][1] - scan * radar.azimuths) < 5


@pytest.mark.parametrize(("rpm", "roll_deg"), [(24, 0), (6, 8), (2, 0)])
def test_no_passing_body_is_missed_by_the_quick_test(rpm: int, roll_deg: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fast, near, turning, along waypoints, from a ship that sways: as when every body is tested."""
    square = [{"position_m": [60, 80], "speed_kn": 30}, {"position_m": [60, -80], "speed_kn": 30}]
    bodies = [
        PLATE | {"name": "fast", "position_m": [-300, 60, 9], "speed_kn": 40, "course_deg": 90},
        PLATE | {"name": "far", "position_m": [3000, -2500, 9], "speed_kn": 20, "course_deg": 10},
        PLATE | {"name": "round", "position_m": [-60, 80, 9], "waypoints": square, "loop": True},
    ]
    own = {"speed_kn": 15, "course_deg": 200} | ({"roll_deg": roll_deg, "roll_period_s": 6} if roll_deg else {})
    made = scene(bodies, radar={"rpm": rpm}, own_ship=own)
    turns = turning(replace(made.bodies[1], name="turns"), 3.0, 1.0, np.deg2rad(6.0))
    each = passages(made.with_world(bodies=(*made.bodies, turns)))
    number = np.arange(2 * made.radar.azimuths)
    boresight, time = made.radar.schedule(number)
    quick = [each.passing(t, b, 0.005) for t, b in zip(time.tolist(), boresight.tolist(), strict=True)]
    monkeypatch.setattr(BeamPassages, "_may_pass", lambda *_: np.arange(4))
    every = [each.passing(t, b, 0.005) for t, b in zip(time.tolist(), boresight.tolist(), strict=True)]
    assert quick == every and {n for found in every for n, _ in found} == {0, 1, 2, 3}


def test_a_body_that_outruns_the_beam_is_evaluated_all_the_same() -> None:
    """At 1 rpm a body that passes at 40 kn and 30 m runs round faster than the beam."""
    made = scene([PLATE | {"speed_kn": 40, "course_deg": 90, "position_m": [-600, -30, 14.5]}], radar={"rpm": 1})
    prepared = prepare(made, PRESETS["balanced"], 0)
    levels = []
    for time in np.linspace(20, 40, 11):
        number = round(time / made.radar.spoke_period) + np.arange(8)
        echoes = prepared.moving.echoes(AzimuthTimes(number, *made.radar.schedule(number)))
        levels.append(np.abs(echoes.amplitude).max(initial=0.0))
    assert np.isfinite(levels).all() and max(levels) > 0


def test_a_body_that_hardly_turns_has_one_node_and_a_turning_one_has_more_where_the_beam_looks() -> None:
    slow = passages(scene([PLATE | {"speed_kn": 5, "course_deg": 0}]))
    assert len(slow.nodes(0, slow.crossing(0, 3.0))) == 1
    made, time = turning_plate(40.0, 95_000.0, 90.0, 2, 24, 0.0)
    fast = passages(made)
    crossing = fast.crossing(0, time / made.radar.rotation_period)
    nodes = fast.nodes(0, crossing)
    gaps, off = np.diff(nodes), np.abs(nodes[:-1] + np.diff(nodes) / 2 - crossing)
    assert nodes[0] < crossing < nodes[-1]
    cell = OpticalBody.of(made.bodies[0], made.radar, 1).limits.coherence(95_000.0 - made.bodies[0].radius)
    rate = 2 * np.pi / WAVELENGTH * cell * np.deg2rad(3.0)  # of its ends
    assert gaps[np.argmin(off)] == np.floor(CUBIC_PHASE / rate / made.radar.spoke_period)
    every = np.diff(passages(made, "reference").nodes(0, crossing))
    assert len(nodes) < len(every) / 4
    assert set(every.tolist()) == {np.floor(ALL_ROUND * CUBIC_PHASE / rate / made.radar.spoke_period)}


def test_sea_reflection_and_nearness_make_more_nodes() -> None:
    """A plate that comes straight on turns in elevation alone; over the sea its reflected ray turns by 2 h / R more. One that
    passes turns the more the nearer it passes."""

    def count(**body: Any) -> int:
        made = scene([PLATE | body], radar={"beamwidth_deg": 6, "azimuths": 360})
        each = passages(made, "reference")
        return len(each.nodes(0, each.crossing(0, 0.0)))

    coming = {"position_m": [0, 200, 14.5], "speed_kn": 40, "course_deg": 180}
    sea = scene([PLATE | coming], radar={"beamwidth_deg": 6, "azimuths": 360}, environment={"multipath": True})
    each = passages(sea, "reference")
    assert len(each.nodes(0, each.crossing(0, 0.0))) > count(**coming)
    passing = {"speed_kn": 20, "course_deg": 90}
    assert count(position_m=[0, 300, 14.5], **passing) > count(position_m=[0, 1500, 14.5], **passing)


def test_roll_makes_nodes_where_it_turns_a_body_against_the_line_of_sight() -> None:
    """Rotation about the line of sight changes no phase: end on, roll makes fewer nodes than abeam; pitch is the other way."""

    def count(course: int, angle: str) -> int:
        sway = {f"{angle}_deg": 3, f"{angle}_period_s": 4, "speed_kn": 1, "course_deg": course}
        each = passages(scene([PLATE | sway | {"position_m": [0, 4000, 14.5]}], radar={"range_max_m": 5000}), "reference")
        return len(each.nodes(0, each.crossing(0, 1.0)))

    assert count(90, "roll") > 4 * count(0, "roll")
    assert count(0, "pitch") > 4 * count(90, "pitch")


def test_bytes_do_not_depend_on_history() -> None:
    """Plates turning and passing, one due north, after the scan before and after a jump."""
    made, _ = turning_plate(3.0, 1500.0, 0.0, 1, 24, 0.4)
    passing = scene([PLATE | {"name": "q", "speed_kn": 20, "course_deg": 80}, point("t", 700, 0)])
    made = made.with_world(bodies=(*made.bodies, *passing.bodies))
    made = replace(made, radar=replace(made.radar, range_max=3000.0, bins=200))

    def scan(*before: int) -> Any:
        engine = Engine(prepare(made, PRESETS["balanced"], 1))
        for number in before:
            list(engine.tiles(number))
        return np.concatenate([field for _, field, _ in engine.tiles(2)])

    alone = scan()
    assert np.abs(alone).max() > 0
    np.testing.assert_array_equal(alone, scan(1))
    np.testing.assert_array_equal(alone, scan(5, 1))


def test_bodies_outside_the_beam_are_not_evaluated(monkeypatch: pytest.MonkeyPatch) -> None:
    bodies = [
        PLATE | {"name": str(k), "speed_kn": 5, "course_deg": 0, "position_m": [2000 * np.sin(k), 2000 * np.cos(k), 14]}
        for k in (0.0, 1.5, 3.0)
    ]
    prepared = prepare(scene(bodies, radar=RADAR), PRESETS["fast"], 0)
    evaluated = []
    original = BeamPassages.evaluated
    monkeypatch.setattr(BeamPassages, "evaluated", lambda self, n, *when: (evaluated.append(n), original(self, n, *when))[1])
    number = 720 + round(720 * 1.5 / (2 * np.pi)) + np.arange(-8, 8)
    prepared.moving.echoes(AzimuthTimes(number, *prepared.scene.radar.schedule(number)))
    assert set(evaluated) == {1}


def passing_field(
    name: str, body: dict[str, Any], own_ship: dict[str, Any], spokes: NDArray[np.int64]
) -> NDArray[np.complex64]:
    """Narrowband fields (K,) of spokes, numbered from the start."""
    prepared = prepare(scene([BOX | body], radar=RADAR | {"rpm": 24}, own_ship=own_ship), PRESETS[name], 0)
    size = prepared.fidelity.azimuths_per_block
    azimuths = AzimuthTimes(spokes, *prepared.scene.radar.schedule(spokes))
    return np.concatenate([prepared.moving.echoes(one).amplitude.sum(axis=0) for one in blocks(azimuths, size)])


BOX = {"name": "b", "shape": "box", "length_m": 8, "width_m": 3, "height_m": 3, "scattering": "optics"}
NORTH = {"course_deg": 0.0, "speed_kn": 10.0}  # the position is given at the crossing
CROSSING, SPEED, STEP = 2 * 720 + 180, 10 * 1852 / 3600, 2.5 / 720  # at bearing 90


def by_manoeuvre(time: float, **change: float) -> dict[str, Any]:
    return NORTH | {"position_m": [600.0, -SPEED * CROSSING * STEP, 14.0], "manoeuvre": [{"time_s": time, **change}]}


def by_waypoints(time: float, **more: Any) -> dict[str, Any]:
    begin = -SPEED * CROSSING * STEP
    stops = [{"position_m": [600 + 400 * k, begin + SPEED * time], "speed_kn": 10} for k in (0, 1)]
    return {"position_m": [600.0, begin, 14.0], "waypoints": stops, **more}


@pytest.mark.sample(6)
@pytest.mark.parametrize("name", ["balanced", "reference"])
@pytest.mark.parametrize("after", [-3, 30])
@pytest.mark.parametrize("kind", ["waypoints", "manoeuvre", "speed and rate", "loop", "rolling", "own ship"])
def test_spokes_before_a_corner_know_nothing_of_it(kind: str, after: int, name: str) -> None:
    """No node of another heading counts: the field is that without the corner, but for nodes that lie elsewhere."""
    time = (CROSSING + after - 0.5) * STEP
    spokes = CROSSING + np.arange(-8, min(after, 8))
    own: tuple[dict[str, Any], ...] = ({}, {})
    rest = {"position_m": [600.0, 0.0, 14.0], "heading_deg": 7.0}
    straight = by_manoeuvre(1e6, course_deg=90)
    body = {
        "waypoints": by_waypoints(time),
        "manoeuvre": by_manoeuvre(time, course_deg=90),
        "speed and rate": by_manoeuvre(time, speed_kn=30, turn_rate_deg_s=-40),
        "loop": by_waypoints(time, loop=True),
        "rolling": by_waypoints(time, roll_deg=8, roll_period_s=6),
        "own ship": rest,
    }[kind]
    without = {"rolling": straight | {"roll_deg": 8, "roll_period_s": 6}, "own ship": rest}.get(kind, straight)
    if kind == "own ship":
        sway = {"course_deg": 180, "speed_kn": 12, "roll_deg": 8, "roll_period_s": 5, "roll_phase_deg": 60}
        own = tuple(sway | {"manoeuvre": [{"time_s": t, "course_deg": 90}]} for t in (1e6, time))
    exact, result = (passing_field(name, each, ship, spokes) for each, ship in zip((without, body), own, strict=True))
    assert np.abs(result - exact).max() < 0.02 * np.abs(exact).max()


TURNED = (6, 52)  # errors of 0.055 and 0.018 where a series spread the echoes on both sides of the corner


def turns_at_once(number: int) -> tuple[rs.Scene, NDArray[np.int64]]:
    """A drawn box that turns within 12 spokes of its crossing, and the spokes about that."""
    rng = np.random.default_rng([52, number])
    distance, length = np.exp(rng.uniform(np.log([300.0, 5.0]), np.log([3000.0, 40.0])))
    speed, after, bearing = rng.uniform([3.0, -12.0, 0.0], [15.0, 12.0, 2.0 * np.pi])
    legs = rng.uniform(0.0, 2.0 * np.pi) + np.array([0.0, np.deg2rad(rng.uniform(10.0, 120.0)) * rng.choice([-1.0, 1.0])])
    along, own_speed = np.stack([np.sin(legs), np.cos(legs)], axis=1), rng.choice([0.0, 12.0])
    crossing = 2 * 720 + round(bearing / (2.0 * np.pi) * 720)
    place = distance * np.array([np.sin(bearing), np.cos(bearing)]) + [0.0, own_speed * 1852 / 3600 * crossing * STEP]
    stop = place + along[int(after <= 0.0)] * speed * after * STEP
    stops = [stop, stop + along[1] * speed * 100.0]
    body = BOX | {"length_m": length, "width_m": length / 4, "height_m": length / 4} | {
        "position_m": [*(stop - along[0] * speed * (crossing + after) * STEP), -1.0],
        "waypoints": [{"position_m": each.tolist(), "speed_kn": speed * 3600 / 1852} for each in stops],
    }  # fmt: skip
    radar = RADAR | {"rpm": 24, "range_max_m": distance + 200.0, "bandwidth_hz": 20e6}
    made = scene([body], radar=radar, own_ship={"course_deg": 0, "speed_kn": own_speed}, environment={"multipath": True})
    return made, crossing + np.arange(-12, 13)


def an_aspect_for_each_spoke(passages: BeamPassages, n: int, crossing: int, time: float) -> tuple[Part, ...]:
    return tuple(Part(spoke, spoke, np.array([spoke])) for spoke in range(crossing - 16, crossing + 17))


@pytest.mark.parametrize("number", [k if k in TURNED else pytest.param(k, marks=pytest.mark.study) for k in range(60)])
def test_a_ship_that_turns_at_once_is_right_at_every_spoke(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """`auto` against an aspect for each spoke and blocks of one: 0.03 of the largest cell (required)."""
    made, numbers = turns_at_once(number)
    chosen = fidelity_for(made, ErrorBudget())
    result = spoke_fields(made, chosen, numbers)
    monkeypatch.setattr(BeamPassages, "_scheduled", an_aspect_for_each_spoke)
    exact = spoke_fields(made, replace(chosen, azimuths_per_block=1), numbers)
    assert np.abs(result - exact).max() < 0.03 * np.abs(exact).max()


@pytest.mark.parametrize("name", ["balanced", "reference"])
def test_a_loop_in_the_first_scan_is_on_its_first_leg(name: str) -> None:
    """Before the start a lap ends: a body due north has the aspect of its first leg all the same."""
    spokes = np.arange(8)
    stops = [{"position_m": [800.0, 600.0], "speed_kn": 10}, {"position_m": [800.0, -200.0], "speed_kn": 10}]
    body = {"position_m": [0.0, 600.0, 14.0], "waypoints": stops}
    exact, result = (passing_field(name, body | {"loop": loop}, {}, spokes) for loop in (False, True))
    assert np.abs(result - exact).max() < 0.02 * np.abs(exact).max()


@pytest.mark.parametrize("after", [-6, -3, 0, 3, 6])
def test_a_body_whose_middle_jumps_across_the_beam_has_its_crossing_there(after: int) -> None:
    """From the east 20 m ahead to 20 m north, at 400 m: between six spokes no spoke points at it."""
    time = (2 * 720 + 180 + after) * STEP
    stops = [{"position_m": [400.0, north], "speed_kn": 10} for north in (0.0, 200.0)]
    made = scene([BOX | {"position_m": [400.0 - SPEED * time, 0.0, 14.0], "waypoints": stops}], radar={"azimuths": 720})
    body = made.bodies[0]
    assert body.mesh is not None
    ahead = replace(body, mesh=replace(body.mesh, vertices=body.mesh.vertices + np.array([0.0, 20.0, 0.0])))
    crossing = passages(made.with_world(bodies=(ahead,))).crossing(0, 2.25) - 2 * 720
    assert crossing == {-6: 174, 3: 180, 6: 180}.get(after, 177)
