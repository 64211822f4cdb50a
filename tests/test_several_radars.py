"""Several radars of one scene: each has its own noise, speckle and fluctuation; the world and its truth are the same for all."""

import dataclasses
import json
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.truth.ground_truth import scene_hash
from tests.scenes import point, scene

SMALL = {"azimuths": 64, "beamwidth_deg": 8, "range_max_m": 256, "pulse_s": 1e-6}
HULL = {"shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6}
CROSSES = {**HULL, "name": "ferry", "position_m": [90, 60, 0], "course_deg": 280, "speed_kn": 12}
TURNS = {
    **HULL, "name": "tug", "position_m": [-60, 80, 0], "turn_radius_m": 30,
    "waypoints": [{"position_m": [-60, 150], "speed_kn": 14}, {"position_m": [80, 160], "speed_kn": 9}],
}  # fmt: skip


def radars(*ids: str, **settings: Any) -> list[dict[str, Any]]:
    return [{"id": name, **SMALL, **settings} for name in ids]


def power(made: rs.Scene, radar: str | None = None, fidelity: str = "fast") -> Any:
    return rs.Simulator(made, fidelity, seed=5, radar=radar).scan().power


@pytest.mark.parametrize(
    ("environment", "bodies"),
    [
        ({"noise": True}, []),
        ({"sea_state": 5}, []),
        ({"rain_mm_h": 50}, []),
        ({}, [point("flutters", 0, 100, swerling=2)]),
        ({}, [point("blinks", 0, 100, swerling=1)]),
    ],
    ids=["noise", "sea", "rain", "swerling 2", "swerling 1"],
)
def test_what_is_random_is_each_radars_own(environment: dict[str, Any], bodies: list[dict[str, Any]]) -> None:
    """Radars at one place with equal settings differ; the id "0" has the bytes of a single [radar], whatever stands beside it."""
    both = scene(bodies, radar=radars("0", "aft"), environment=environment)
    alone = scene(bodies, radar=SMALL, environment=environment)
    np.testing.assert_array_equal(power(both, "0"), power(alone))
    np.testing.assert_array_equal(power(both), power(alone))  # the first by default
    assert (power(both, "aft") != power(alone)).any()
    np.testing.assert_array_equal(power(both, "aft"), power(scene(bodies, radar=radars("aft"), environment=environment)))


def test_noise_of_two_radars_is_independent() -> None:
    """Correlation of 64 x 129 complex samples: 1 / sqrt(8256) = 0.011 as a rule; five times that is chance of 1e-11."""
    both = scene(radar=radars("a", "b"), environment={"noise": True})
    one, other = (rs.Simulator(both, "fast", radar=name).scan().field.ravel() for name in ("a", "b"))
    size = len(one)
    assert abs(np.vdot(one, other)) / np.linalg.norm(one) / np.linalg.norm(other) < 5 / np.sqrt(size)


def test_the_sea_is_the_same_under_different_speckle() -> None:
    """Mean power over 24 scans, without speckle but with the texture: alike for both radars, unlike for another seed.

    At rest, spiky (shape 0.3) and with waves that hardly move in a scan of 0.1 s. Means of 24 exponential draws scatter by a
    fifth, the texture by nearly twice its mean, so maps correlate by more than 0.8 with one texture, and by about 0 with two.
    """
    sea = {"sea_state": 5, "sea_texture_shape": 0.3, "wind_from_deg": 30}
    both = scene(radar=radars("a", "b", rpm=600), environment=sea)

    def mean(radar: str, seed: int = 0) -> Any:
        sim = rs.Simulator(both, "fast", seed=seed, radar=radar)
        return np.mean([sim.scan().power for _ in range(24)], axis=0)[:, 20:100]

    level = np.mean([mean("a"), mean("b")], axis=0).mean(axis=0)
    one, other, stranger = (mean(*each) / level for each in (("a",), ("b",), ("b", 1)))
    assert np.corrcoef(one.ravel(), other.ravel())[0, 1] > 0.8
    assert abs(np.corrcoef(one.ravel(), stranger.ravel())[0, 1]) < 0.4


def test_a_radar_neither_sees_nor_is_shadowed_by_its_platform() -> None:
    """On a big box a radar has the bytes of one on the bare sea, while one on the pier sees the box."""
    box = {"name": "barge", "shape": "box", "length_m": 60, "width_m": 20, "height_m": 30, "speed_kn": 4}
    target = point("buoy", 0, 150, 3)
    pier = {"id": "pier", **SMALL, "platform": {"position_m": [0, -150]}}
    carried = scene([box, target], radar=[*radars("0"), pier], own_ship={"body": "barge"})
    bare = scene([target], radar=SMALL, own_ship={"speed_kn": 4})
    for fidelity in ("balanced", "documented"):
        np.testing.assert_array_equal(power(carried, "0", fidelity), power(bare, None, fidelity))
    sim = rs.Simulator(carried, "fast", radar="pier")
    assert [(c.body, c.visible) for c in sim.crossings(0)] == [("barge", True), ("buoy", False)]  # the barge is before it
    assert "barge" not in str(rs.Simulator(carried, "fast", radar="0").plan)


def world(**more: Any) -> rs.Scene:
    """Two ships that move and turn, seen from a third that sways, from one of them, and from a site; three rates of rotation."""
    places = [{"id": "bow", "rpm": 24}, {"id": "pier", "rpm": 48, "platform": {"position_m": [150, -40], "heading_deg": 70}},
              {"id": "ferry", "rpm": 12, "platform": {"body": "ferry"}}]  # fmt: skip
    return scene(
        [CROSSES, TURNS, point("buoy", 120, 140, 3)],
        origin={"latitude_deg": 50.0, "longitude_deg": 1.0},
        radar=[{**SMALL, **place} for place in places],
        own_ship={"position_m": [20, -30], "course_deg": 20, "speed_kn": 8, "yaw_deg": 4, "roll_deg": 3},
        **more,
    )


SHARED = ("time", "mmsi", "position", "latitude_deg", "longitude_deg", "velocity", "course", "speed", "heading", "turn_rate",
          "length", "beam")  # fmt: skip


@pytest.mark.same_bytes
def test_truths_of_two_radars_agree_to_the_bit() -> None:
    """Ends of scans at 24, 48 and 12 rpm fall together every 5 s; there each radar says the same of every body that it has."""
    made = world()
    sims = [rs.Simulator(made, "fast", radar=name) for name in ("bow", "pier", "ferry")]
    seen = set()
    for turn in range(6):
        snapshots = [sim.snapshot(per * (turn + 1) - 1) for sim, per in zip(sims, (2, 4, 1), strict=True)]
        assert [snapshot.radar for snapshot in snapshots] == ["bow", "pier", "ferry"]
        by_name = [{body.body: body for body in snapshot.bodies} for snapshot in snapshots]
        assert [sorted(bodies) for bodies in by_name] == [["buoy", "ferry", "tug"]] * 2 + [["buoy", "tug"]]
        for name in by_name[0]:
            states = [tuple(getattr(bodies[name], key) for key in SHARED) for bodies in by_name if name in bodies]
            assert len(set(states)) == 1 and states[0][0] == 5.0 * (turn + 1)
            seen.add(states[0])
        ferry, carrier = by_name[0]["ferry"], snapshots[2].own_ship
        assert all(getattr(ferry, key) == getattr(carrier, key) for key in ("velocity", "course", "speed", "heading"))
    assert len(seen) == 6 * 3 and any(state[SHARED.index("turn_rate")] for state in seen)  # one of them on the tug's arc
    at = [{body.name: dataclasses.astuple(body)[1:6] for body in sim.truth(7.3).bodies} for sim in sims[:2]]
    assert at[0] == at[1]


def test_each_radar_names_itself_in_its_truth() -> None:
    made = world()
    for name in ("bow", "pier", "ferry"):
        sim = rs.Simulator(made, "fast", radar=name)
        header = sim.truth_header()
        assert [radar["id"] for radar in header["radars"]] == [name]
        assert header["scene_hash"] == scene_hash(made.for_radar(name))
        assert {crossing.radar for crossing in sim.crossings(0)} == {name}
        assert name not in {crossing.body for crossing in sim.crossings(0)}  # no radar crosses its own platform
        assert json.loads(json.dumps(sim.snapshot(0).as_dict()))["radar"] == name
    assert len({scene_hash(made.for_radar(radar.id)) for radar in made.radars}) == 3


def test_a_simulator_refuses_an_unknown_radar() -> None:
    with pytest.raises(ValueError, match='radar: "stern" is not a radar of this scene; it has bow, pier, ferry'):
        rs.Simulator(world(), "fast", radar="stern")


def test_a_command_to_own_ship_and_to_its_body_are_the_same() -> None:
    """The tug turns from 1.25 s on: spoke 32 of the bow's radar, spoke 64 of the pier's, which turns twice as fast."""
    made = scene(
        [{**HULL, "name": "tug", "speed_kn": 8, "steerable": {}}],
        radar=[{"id": "bow", **SMALL}, {"id": "pier", **SMALL, "rpm": 48, "platform": {"position_m": [90, 0]}}],
        own_ship={"body": "tug"},
    )
    bow, pier = (rs.Simulator(made, "fast", radar=radar.id) for radar in made.radars)
    order = {"course_deg": 90, "speed_kn": 15}
    bow.command(spoke=32, **order)
    pier.command("tug", spoke=64, **order)
    for turn in range(3):
        for sim, scans in ((bow, 1), (pier, 2)):
            assert [len(list(sim.spokes(1))) for _ in range(scans)]
        own, (tug,) = bow.snapshot(turn).own_ship, pier.snapshot(2 * turn + 1).bodies
        assert [getattr(own, key) for key in ("velocity", "course", "speed", "heading")] == [
            getattr(tug, key) for key in ("velocity", "course", "speed", "heading")
        ]
    assert tug.course == pytest.approx(np.deg2rad(5.0 * (7.5 - 1.25)))  # at the default limit of 5 degrees/s


def test_a_ships_gyro_turns_no_other_picture() -> None:
    """A gyro that is 20 degrees off turns the azimuths of the ship's radars by 20 degrees, and none of the pier's."""
    gyro = {"gyro": {"bias_deg": 20, "noise_deg": 1}}
    for sections in ({"own_ship": {"errors": gyro}}, {"errors": gyro}):
        made = scene(radar=[*radars("bow", "aft"), {**radars("pier")[0], "platform": {"position_m": [90, 0]}}], **sections)
        bow, aft, pier = (next(rs.Simulator(made, "fast", radar=radar.id).blocks(1, 64)) for radar in made.radars)
        right = next(rs.Simulator(scene(radar=SMALL), "fast").blocks(1, 64))
        np.testing.assert_array_equal(pier.azimuth, right.azimuth)
        np.testing.assert_array_equal(pier.heading, right.heading)
        assert pier.true is None and np.rad2deg(np.ptp(bow.heading)) > 0 and abs(np.rad2deg(bow.heading).mean() - 20) < 5
        np.testing.assert_array_equal(bow.heading, aft.heading)  # one ship, one gyro


def test_ships_have_gyros_of_their_own() -> None:
    barge = {"name": "barge", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, 90, 0]}
    tug = {"name": "tug", "shape": "box", "length_m": 9, "width_m": 9, "height_m": 9, "position_m": [0, -90, 0]}
    carried = [{**radars(name)[0], "platform": {"body": name}} for name in ("barge", "tug")]
    made = scene([barge, tug], radar=[*radars("own"), *carried], errors={"gyro": {"noise_deg": 1}})
    headings = [next(rs.Simulator(made, "fast", radar=radar.id).blocks(1)).heading for radar in made.radars]
    assert len({heading.tobytes() for heading in headings}) == 3


def test_errors_change_no_hash_of_a_radar_that_has_none() -> None:
    two_radars = [{**radars("bow")[0]}, {**radars("pier")[0], "platform": {"position_m": [90, 0]}}]
    plain, wrong = (
        scene(radar=two_radars, own_ship={"errors": errors} if errors else {}) for errors in ({}, {"log": {"bias_kn": 1}})
    )
    for name, same in (("bow", False), ("pier", True)):
        assert (scene_hash(plain.for_radar(name)) == scene_hash(wrong.for_radar(name))) is same
