"""A change of the rate of rotation: simulated time, positions and numbers go on; what is computed depends on where it begins."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.radar.parameters import Origin
from radar_service.world.commands import Command
from radar_service.world.scene import scene_at_rpm
from tests.scenes import everything, point, scene

KNOT = 1852 / 3600  # m/s
RADAR = {"azimuths": 90, "beamwidth_deg": 6, "range_max_m": 900, "rpm": 40, "height_m": 12}
SHIP = {"name": "ship", "shape": "hull", "length_m": 40, "beam_m": 8, "height_m": 6, "scattering": "optics"}


def moving(after: float = 0.0, rpm: float = 40, **radar: object) -> rs.Scene:
    """Points and a metal hull under way, as they are `after` so many seconds [s] at the start."""
    bodies = [
        point("a", 200 - 12 * KNOT * after, 300, speed_kn=12, course_deg=270),
        point("b", -150, -200 + 25 * KNOT * after, speed_kn=25, course_deg=0),
        {**SHIP, "position_m": [300 + 9 * KNOT * after, -250, 0], "speed_kn": 9, "course_deg": 90, "heading_deg": 90},
    ]
    own_ship = {"position_m": [0, 8 * KNOT * after], "speed_kn": 8, "course_deg": 0}
    return scene(bodies, radar=RADAR | {"rpm": rpm} | radar, own_ship=own_ship, environment={"multipath": True})


def peak(values: np.ndarray) -> float:  # type: ignore[type-arg]
    return float(np.abs(values).max())


def test_time_and_numbers_go_on() -> None:
    sim = rs.Simulator(moving(), "fast", 1)
    *_, last = sim.spokes(2)
    slower = sim.at_rpm(25)
    first = next(slower.spokes(1))
    assert (first.number, first.scan, first.index, first.azimuth) == (180, 2, 0, 0.0)
    assert first.time == 2 * 60 / 40 and first.time - last.time == pytest.approx(60 / 40 / 90)
    later = list(slower.spokes(1))
    assert later[1].time - later[0].time == pytest.approx(60 / 25 / 90) and later[0].time == pytest.approx(3.0 + 60 / 25)
    faster = slower.at_rpm(80)
    assert (next(faster.spokes(1)).scan, faster.crossings()[0].scan) == (4, 4)
    assert faster.snapshot().time == pytest.approx(3.0 + 2 * 60 / 25 + 60 / 80)


def test_echoes_are_those_of_the_positions_at_that_time() -> None:
    """The scan after the change is the first scan of a scene whose bodies start where they have got to.

    `reference` computes each azimuth by itself, so that only rounding differs. 1e-5 of the peak, -100 dB, covers single
    precision, and metal whose shadows are found between samples: 4e-6 were seen.
    """
    sim = rs.Simulator(moving(), "reference", 1)
    sim.skip_to(3)
    changed = sim.at_rpm(25).scan()
    anew = rs.Simulator(moving(after=3 * 60 / 40, rpm=25), "reference", 1).scan()
    assert peak(changed.field - anew.field) < 1e-5 * peak(anew.field)
    unmoved = rs.Simulator(moving(rpm=25), "reference", 1).scan()
    assert peak(changed.field - unmoved.field) > 0.3 * peak(anew.field)


def test_what_is_far_and_fast_is_seen_where_the_beam_points_after_the_change() -> None:
    """Half a turn from where it would point had the new rate held from the start. `fast` errs by 1 % (-40 dB) under way."""

    def boat(after: float, rpm: float) -> rs.Simulator:
        bodies = [point("a", 2500, 100 + 100 * KNOT * after, speed_kn=100, course_deg=0)]
        return rs.Simulator(scene(bodies, radar=RADAR | {"rpm": rpm, "range_max_m": 2800, "beamwidth_deg": 4}), "fast", 1)

    sim = boat(0.0, 40)
    sim.skip_to(3)  # 4.5 s, in which 20 rpm are one turn and a half
    changed, anew = sim.at_rpm(20).scan().field, boat(4.5, 20).scan().field
    assert peak(changed - anew) < 0.02 * peak(anew)  # of both scans


def test_the_specification_as_printed_goes_on_too() -> None:
    """Points alone, equal but for rounding: rays at meshes are drawn by the number of the scan."""

    def made(after: float, rpm: float) -> rs.Simulator:
        whole = moving(after, rpm)
        return rs.Simulator(whole.with_world(bodies=whole.bodies[:2]), "documented", 1)

    sim = made(0.0, 40)
    sim.skip_to(3)
    changed, anew = sim.at_rpm(25).scan().field, made(4.5, 25).scan().field
    assert peak(changed - anew) < 1e-6 * peak(anew)


def test_truth_goes_on() -> None:
    sim = rs.Simulator(moving(), "fast", 1)
    sim.skip_to(3)
    changed, anew = sim.at_rpm(25), rs.Simulator(moving(after=3 * 60 / 40, rpm=25), "fast", 1)
    ours, others = changed.crossings(3), anew.crossings(0)
    assert [c.body for c in ours] == [c.body for c in others] and len(ours) == 3
    for one, other in zip(ours, others, strict=True):
        assert (one.scan, one.spoke) == (3, other.spoke + 270)
        np.testing.assert_allclose(
            [one.time - 4.5, one.range, one.bearing], [other.time, other.range, other.bearing], rtol=1e-9
        )
        np.testing.assert_allclose(one.position, other.position, rtol=1e-9)
    assert changed.snapshot(3).time == pytest.approx(4.5 + 60 / 25)


@pytest.mark.parametrize("fidelity", ["fast", "balanced", "documented"])
def test_a_change_to_the_same_rate_changes_nothing(fidelity: str) -> None:
    """Noise, clutter, interference, fluctuation, aspects, shadows: all go on with their numbers and times, but for rounding."""
    whole = everything() if fidelity != "documented" else moving()
    sim = rs.Simulator(whole, fidelity, 5)
    sim.skip_to(2)
    again, on = sim.at_rpm(60 / whole.radar.rotation_period).scan(), sim.scan()
    assert peak(again.field - on.field) < 2e-4 * peak(on.field)
    assert again.number == on.number == 2
    assert np.abs(again.time - on.time).max() < 1e-12


def test_the_same_origin_gives_the_same_bytes() -> None:
    def made() -> bytes:
        sim = rs.Simulator(everything(), "fast", 5)
        sim.skip_to(7)
        return sim.at_rpm(31).scan().field.tobytes()

    assert made() == made()
    first = rs.Simulator(everything(), "fast", 5)
    assert first.at_rpm(31).scan().field.tobytes() != made()  # other numbers: other draws


def test_earlier_scans_are_not_to_be_had() -> None:
    sim = rs.Simulator(moving(), "fast", 1)
    sim.skip_to(3)
    changed = sim.at_rpm(25)
    changed.skip_to(0)
    assert next(changed.spokes(1)).scan == 3


def test_a_sector_stays_a_sector() -> None:
    sim = rs.Simulator(moving(), "fast", 1, sector=(0.2, 0.4))
    assert [spoke.index for spoke in sim.at_rpm(25).spokes(1)] == [spoke.index for spoke in sim.spokes(1)]


def test_a_steered_run_goes_on_as_commanded() -> None:
    """The truth is that of a run at the old rate with the same commands; those to come act at their times."""
    bodies = [point("a", 200, 300, steerable={"max_speed_kn": 40})]
    made = scene(bodies, radar=RADAR, own_ship={"steerable": {}}, environment={"noise": True})
    sim = rs.Simulator(made, "fast", 1)
    sim.command("a", speed_kn=30, course_deg=40)
    sim.scan()
    sim.command(turn_rate_deg_s=-3, speed_kn=9)
    sim.command("a", time=2.9, position_m=[100, 100])
    sim.scan()
    slower = sim.at_rpm(25)
    assert [command.time for command in slower.commands] == [0.0, 1.5, 2.9]
    assert (later := slower.command("a", time=3.7, speed_kn=2)).spoke == 180 + math.ceil(0.7 / (60 / 25 / 90))
    changed = slower.scan()
    sim.command("a", time=later.time, speed_kn=2)
    sim.scan()  # the truth follows a command when its spoke is computed
    for time in (1.0, 2.0, 2.95, 3.5, 4.1):
        assert slower.truth(time) == sim.truth(time)
    again = rs.Simulator(made, "fast", 1, commands=sim.commands)
    again.skip_to(2)
    assert again.at_rpm(25).scan().field.tobytes() == changed.field.tobytes()
    still = rs.Simulator(made, "fast", 1)
    still.skip_to(2)
    assert still.at_rpm(25).scan().field.tobytes() != changed.field.tobytes()


def made_at(whole: rs.Scene, rpm: float, origin: Origin, fidelity: str, **options: Any) -> tuple[rs.Simulator, rs.Simulator]:
    """A simulator that was prepared for the origin, and one that was given it later."""
    late = rs.Simulator(scene_at_rpm(whole, rpm), fidelity, 5, **options)
    late.begin_at(origin)
    return rs.Simulator(scene_at_rpm(whole, rpm, origin), fidelity, 5, **options), late


def near_and_far() -> rs.Scene:
    """Two pulses, beside the sea."""
    pulses = [{"pulse_s": 3e-7, "bandwidth_hz": 2e7, "range_max_m": 300}, {"pulse_s": 1e-6, "bandwidth_hz": 2e7}]
    bodies = [point("a", 200, 100, speed_kn=20, course_deg=40)]
    return scene(bodies, radar={**RADAR, "pulses": pulses}, environment={"sea_state": 4, "noise": True})


@pytest.mark.parametrize(("make", "fidelity"), [(everything, "fast"), (moving, "documented"), (near_and_far, "fast")])
def test_an_origin_that_is_given_late_gives_the_same_bytes(make: Callable[[], rs.Scene], fidelity: str) -> None:
    early, late = made_at(make(), 31, Origin(7.25, 5), fidelity)
    for block, other in zip(early.blocks(1), late.blocks(1), strict=True):
        assert (block.first, block.time.tolist()) == (other.first, other.time.tolist())
        assert block.field.tobytes() == other.field.tobytes()
    assert early.crossings() == late.crossings() and early.snapshot() == late.snapshot()


def test_an_origin_that_is_given_late_keeps_what_commands_do() -> None:
    bodies = [point("a", 200, 300, steerable={"max_speed_kn": 40})]
    made = scene(bodies, radar=RADAR, own_ship={"steerable": {}}, environment={"noise": True})
    commands = [Command(0, 1.0, "a", speed_kn=30.0), Command(600, 9.0, None, course_deg=20.0, speed_kn=8.0)]
    early, late = made_at(made, 60, Origin(7.25, 5), "fast", labels=True)
    for sim in (early, late):
        sim.replay([command.after_change_of_rpm(sim.scene.radar) for command in commands])
    for block, other in zip(early.blocks(3), late.blocks(3), strict=True):
        assert block.field.tobytes() == other.field.tobytes() and block.commands == other.commands
        assert block.labels is not None and other.labels is not None
        assert block.labels.tobytes() == other.labels.tobytes()
    assert early.commands == late.commands and early.truth(9.5) == late.truth(9.5)
