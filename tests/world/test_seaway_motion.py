"""Ships in a seaway: rates, continuity, independence of history, statistics against theory, and bounds."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from radar_service.numerics.constants import GRAVITY, KNOT
from radar_service.numerics.types import Floats
from radar_service.world import seaway_motion
from radar_service.world.motion import Motion
from radar_service.world.seaway import (
    PEAK_PERIOD,
    PERIOD_HEIGHT,
    Seaway,
    Waves,
    drawn_waves,
    energy_below,
    significant_wave_height,
)
from radar_service.world.seaway_motion import (
    EASING,
    MARGIN,
    HullForm,
    Response,
    SeawayMotion,
    amplitudes,
    bounds_of,
    bounds_on_any_course,
    easing_of,
    response,
)
from radar_service.world.steered_motion import SteeredMotion
from tests.scenes import scene

SEA: dict[str, Any] = {"height_m": 2.0, "period_s": 7.0, "from_deg": 300.0, "seed": 2}
SHIP: dict[str, Any] = {"name": "ship", "shape": "hull", "length_m": 60, "beam_m": 10, "height_m": 8,
                        "position_m": [100, 900, 0]}  # fmt: skip
WAYPOINTS = [{"position_m": [700, 900], "speed_kn": 9}, {"position_m": [700, 1700], "speed_kn": 5}]
COURSES: dict[str, dict[str, Any]] = {
    "at rest": {"heading_deg": 20.0},
    "straight": {"course_deg": 200.0, "speed_kn": 12},
    "fast": {"course_deg": 80.0, "speed_kn": 35},
    "turning": {"course_deg": 40.0, "speed_kn": 10, "turn_rate_deg_s": 1.0},
    "rounded": {"waypoints": WAYPOINTS, "turn_radius_m": 150},
    "loop": {"waypoints": WAYPOINTS, "turn_radius_m": 150, "loop": True},
    "manoeuvre": {"course_deg": 300.0, "speed_kn": 14, "manoeuvre": [
        {"time_s": 80, "speed_kn": 3}, {"time_s": 130, "course_deg": 60, "turn_rate_deg_s": 1.5}]},
}  # fmt: skip
COASTER = HullForm(75.0, 12.5, 5.0, 0.7, 0.8, 8.9, 0.1)
STREAM = {"current_kn": 2.5, "current_to_deg": 70}
H = 1e-4  # s; a central difference over it errs by 1e-8


def motion_of(course: str, stream: bool = False, **more: Any) -> Motion:
    environment = {"seaway": SEA} | (STREAM if stream else {})
    return scene([SHIP | COURSES[course] | more], environment=environment).bodies[0].motion


def law_of(motion: Motion) -> SeawayMotion:
    assert isinstance(motion.sway, SeawayMotion)
    return motion.sway


@pytest.mark.parametrize("stream", [False, True])
@pytest.mark.parametrize("course", COURSES)
def test_rates_are_derivatives(course: str, stream: bool) -> None:
    """Also late in a run, where a difference errs by the rounding of the time."""
    motion = motion_of(course, stream)
    knots = motion.time
    for start in (1.0, 36_000.0):
        time = start + np.linspace(0.0, 300.0, 67)
        lap = time if motion.period is None else time % motion.period
        clear = np.abs(lap[:, None] - np.append(knots, knots[-1] + 1e9)).min(axis=1) > 1e-3
        before, after = (motion.sway_state(time[clear] + h).values for h in (-H, H))
        np.testing.assert_allclose(motion.sway_state(time[clear]).rates, (after - before) / (2 * H), atol=2e-6)


@pytest.mark.parametrize("stream", [False, True])
@pytest.mark.parametrize("course", [name for name in COURSES if name != "at rest"])
def test_sway_is_continuous_where_speed_jumps(course: str, stream: bool) -> None:
    """At each knot, of many laps and at the start too: it changes by its rate times 2 us. In a stream its heading jumps where its
    speed does: so does sway."""
    motion = motion_of(course, stream)
    knots = motion.time
    if motion.period is not None:
        knots = np.concatenate([knots + lap * motion.period for lap in (0, 1, 40)])
    ends = [(motion.upright(knots + h).heading, motion.sway_state(knots + h).values) for h in (-1e-6, 1e-6)]
    steady = np.abs(np.angle(np.exp(1j * (ends[1][0] - ends[0][0])))) < 1e-5
    assert steady.sum() > (len(knots) - 1) // 2 or stream
    np.testing.assert_allclose(ends[1][1][steady], ends[0][1][steady], atol=4e-6)  # rates are below 2


def test_it_responds_to_its_new_speed_after_a_while() -> None:
    """10 s after 14 became 3 knots a third of the change is left; after minutes it rolls as if it had never been faster."""
    motion = motion_of("manoeuvre")
    easing = law_of(motion).easing
    assert np.hypot(*easing.at(np.array([90.0]))[0]) == pytest.approx(11.0 * KNOT / math.e, rel=1e-9)
    assert not easing.at(np.array([79.0])).any()
    late = np.array([4000.0, 4001.0])
    steady = replace(law_of(motion), easing=easing_of(Motion(np.zeros(1), np.zeros((1, 3)), np.zeros(1))))
    expected = replace(motion, sway=steady).sway_state(late).values
    np.testing.assert_allclose(motion.sway_state(late).values, expected, atol=1e-12)


@pytest.mark.parametrize(("course", "more"), [("at rest", 0), ("straight", 0), ("turning", 2)])
def test_a_steady_course_takes_one_response(course: str, more: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The response of a ship that neither turns nor changes speed is kept, and never differentiated."""
    motion, calls = motion_of(course), []
    motion.sway_state(np.array([0.0, 2.5]))
    monkeypatch.setattr(seaway_motion, "response", lambda *given: calls.append(0) or response(*given))
    motion.sway_state(np.array([30.0, 32.5]))
    assert len(calls) == more


def test_the_rest_before_the_first_knot_is_felt_before_it() -> None:
    """The velocity to which a ship responds differs from its own before time 0, and equals it from then on."""
    easing = law_of(motion_of("straight")).easing
    before, after = np.array([-0.5]), np.array([0.0, 7.0])
    assert easing.at(before).any() and not easing.vanishes(np.append(before, after))
    assert not easing.at(after).any() and easing.vanishes(after)


@pytest.mark.parametrize("course", COURSES)
def test_a_time_alone_is_as_among_others(course: str) -> None:
    """To the last bit, forward, backward, and a day later."""
    motion = motion_of(course)
    times = np.array([3.0, 86_400.7, 55.5, 131.0, 700.25])
    together, pose = motion.sway_state(times), motion.pose(times)
    for k, time in enumerate(times):
        for column, one in zip(together, motion.sway_state(np.array([time])), strict=True):
            np.testing.assert_array_equal(column[k], one[0])
        np.testing.assert_array_equal(motion.pose(time).position[0], pose.position[k])


def plain_sum(waves: Waves, form: HullForm, pose: Any, time: float, velocity: Floats) -> list[float]:
    """Roll, pitch and heave wave by wave."""
    result = [0.0, 0.0, 0.0]
    heading = float(pose.heading[0])
    for a, w, (ke, kn), phase in zip(waves.amplitude, waves.frequency, waves.wavenumber, waves.phase, strict=True):
        sine, cosine = math.sin(heading), math.cos(heading)
        along, aside = np.array([ke * sine + kn * cosine]), np.array([ke * cosine - kn * sine])
        met = np.array([w - ke * velocity[0] - kn * velocity[1]])
        angle = ke * pose.position[0, 0] + kn * pose.position[0, 1] - w * time + phase
        for m, amplitude in enumerate(response(form, np.array([w]), along, aside, met)):
            result[m] += float((a * amplitude[0] * np.exp(1j * angle)).real)
    return result


@pytest.mark.parametrize(("course", "time"), [("straight", 86_400.0), ("turning", 1234.5), ("rounded", 60.0)])
def test_sway_is_the_sum_of_its_responses(course: str, time: float) -> None:
    motion = motion_of(course, list_deg=0.0, trim_deg=0.0)
    upright = replace(motion, sway=None).pose(time)
    law = law_of(motion)
    expected = plain_sum(
        law.waves, law.form, upright, time, upright.velocity[0] + [*law.easing.at(np.array([time]))[0], 0.0]
    )
    got = motion.sway_state(np.array([time])).values[0]
    np.testing.assert_allclose(got[[0, 1, 3]], expected, atol=1e-9)
    assert got[2] == 0.0
    pose = motion.pose(time)
    assert pose.position[0, 2] == upright.position[0, 2] + got[3]
    assert pose.velocity[0, 2] == motion.sway_state(np.array([time])).rates[0, 3]


def test_a_small_boat_floats_on_the_sea() -> None:
    """In long waves a boat has the height and the slope of the sea where it is: one sea for all."""
    sea = {"height_m": 1.0, "period_s": 30.0, "list_deg": 0.0, "trim_deg": 0.0}
    boat = {"name": "boat", "shape": "hull", "length_m": 5.0, "beam_m": 2.0, "height_m": 2.0, "heading_deg": 70.0,
            "hull": {"draught_m": 0.5, "roll_period_s": 1.5}}  # fmt: skip
    boats = [boat | {"name": f"{k}", "position_m": [300.0 * k, -150.0 * k, 0.0]} for k in (1, 2)]
    made = scene(boats, environment={"seaway": sea})
    time = np.linspace(0.0, 500.0, 2001)
    for body in made.bodies:
        law, place = law_of(body.motion), np.repeat(body.motion.position, len(time), axis=0)
        sway, step = body.motion.sway_state(time).values, 0.5
        ahead, aside = (step * np.array([[math.sin(a), math.cos(a), 0.0]]) for a in np.deg2rad([70.0, 160.0]))
        height = law.waves.elevation(place, time)
        slope, side = (
            (law.waves.elevation(place + w, time) - law.waves.elevation(place - w, time)) / 1.0 for w in (ahead, aside)
        )
        for got, expected in ((sway[:, 3], height), (sway[:, 1], slope), (sway[:, 0], -side)):
            assert np.std(got - expected) < 0.1 * expected.std()


def variance_in_theory(sea: Seaway, form: HullForm, heading: float, speed: float) -> Floats:
    """Integrals of |response|^2 S(w) D(theta) over the bands of which waves are drawn, for roll, pitch and heave."""
    peak = 2.0 * np.pi / sea.period
    edges = np.geomspace(0.55 * peak, 3.5 * peak, 401)
    energy = np.diff(energy_below(edges, peak))
    energy *= (sea.height / 4.0) ** 2 / energy.sum()
    frequency = np.sqrt(edges[1:] * edges[:-1])
    off = (np.arange(90) + 0.5) / 90.0 * np.pi - np.pi / 2.0
    share = np.cos(off) ** (2.0 * sea.spread)
    share /= share.sum()
    result = np.zeros(3)
    for angle, part in zip(sea.towards + off - heading, share, strict=True):
        k = frequency**2 / 9.80665
        answers = response(form, frequency, k * np.cos(angle), k * np.sin(angle), frequency - speed * k * np.cos(angle))
        result += part * np.array([(np.abs(each) ** 2 * energy).sum() for each in answers])
    return result


@pytest.mark.parametrize(("course", "speed"), [(180.0, 6.0), (90.0, 0.0), (40.0, 7.0)])
def test_variances_of_drawn_motions_are_those_of_the_spectrum(course: float, speed: float) -> None:
    """Means of 60 seas, which vary by frequency and direction; to 4 of their own standard errors, one of 10,000 by chance."""
    sea = Seaway(2.0, 7.5, 0.0, 1.0, 0, 0.0, 0.0)
    heading = np.deg2rad([-course])
    velocity = speed * np.stack([np.sin(heading), np.cos(heading)], axis=1)
    drawn = []
    for seed in range(60):
        waves = drawn_waves(replace(sea, seed=seed))
        drawn.append((np.abs(amplitudes(waves, COASTER, heading, velocity)[0]) ** 2).sum(axis=-1) / 2.0)
    expected = variance_in_theory(sea, COASTER, float(heading[0]), speed)
    error = np.std(drawn, axis=0) / np.sqrt(len(drawn))
    assert (error < 0.1 * expected).all()
    np.testing.assert_array_less(np.abs(np.mean(drawn, axis=0) - expected), 4.0 * error)


def test_a_motion_has_the_variance_of_its_amplitudes() -> None:
    """Over ten hours; sums of waves with different frequencies are orthogonal."""
    motion = motion_of("straight", list_deg=1.5, trim_deg=-0.5)
    law = law_of(motion)
    sway = motion.sway_state(np.linspace(0.0, 36_000.0, 12_001)).values
    np.testing.assert_allclose(sway.std(axis=0), law.bounds.deviation, rtol=0.02)
    assert np.rad2deg(sway.mean(axis=0)[:2]) == pytest.approx([1.5, -0.5], abs=0.02)
    about = motion.sway_rates(np.linspace(0.0, 3600.0, 1801))
    rates = motion.sway_state(np.linspace(0.0, 3600.0, 1801)).rates
    assert (about + 1e-12 >= np.sqrt(1.25) * np.abs(rates)).all()
    assert np.sqrt((about**2).mean(axis=0)) == pytest.approx(np.sqrt(1.5) * rates.std(axis=0), rel=0.05, abs=1e-9)


@pytest.mark.parametrize(("state", "low", "high"), [(3, 0.5, 1.5), (5, 2.0, 5.0)])
def test_a_coaster_of_75_m_rolls_in_a_beam_sea_as_such_ships_do(state: int, low: float, high: float) -> None:
    """Degrees rms, at rest and at 8 knots."""
    height = significant_wave_height(state)
    sea = Seaway(height, float(np.interp(height, PERIOD_HEIGHT, PEAK_PERIOD)), 0.0, 1.0, 0, 0.0, 0.0)
    for speed in (0.0, 8.0 * KNOT):
        assert low < np.rad2deg(np.sqrt(variance_in_theory(sea, COASTER, np.pi / 2.0, speed)[0])) < high


@pytest.mark.parametrize("course", COURSES)
def test_bounds_hold(course: str) -> None:
    motion = motion_of(course)
    law = law_of(motion)
    state = motion.sway_state(np.linspace(0.0, 7200.0, 701))
    assert (np.abs(state.values) <= law.max_values + 1e-12).all()
    assert (np.abs(state.rates) <= law.max_rates + 1e-12).all()
    assert (law.likely_values <= law.max_values).all() and (law.likely_rates <= law.max_rates).all()
    assert np.abs(state.values).max(axis=0)[[0, 1, 3]] == pytest.approx(law.likely_values[[0, 1, 3]], rel=0.75)
    assert 3.0 < law.shortest_period < 12.0


def test_bounds_on_any_course_hold_between_their_headings_and_speeds() -> None:
    """1200 draws of courses: none exceeds them, and MARGIN is not much more than needed."""
    waves = drawn_waves(Seaway(2.0, 6.0, 1.0, 1.0, 9, 0.0, 0.0))
    rng, worst = np.random.default_rng(3), 0.0
    for form in (COASTER, HullForm(12.0, 4.0, 1.5, 0.5, 0.7, 4.5, 0.05), HullForm(160.0, 25.0, 9.0, 0.8, 0.87, 13.0, 0.02)):
        bounds = bounds_on_any_course(waves, form, 10.0, 0.0)
        heading = rng.uniform(0.0, 2.0 * np.pi, 400)
        velocity = rng.uniform(0.0, 10.0, (400, 1)) * np.stack([np.sin(heading), np.cos(heading)], axis=1)
        for part, bound in zip(bounds_of(waves, form, heading, velocity), bounds, strict=True):
            worst = max(worst, float((part[[0, 1, 3]] / bound[[0, 1, 3]]).max()))
    assert 1.0 < worst * MARGIN < MARGIN


def test_a_ship_is_moved_by_the_waves_at_its_middle() -> None:
    """A frame with its origin at the stern: the middle of the hull moves as one amidships, to the square of angles."""
    sea = drawn_waves(Seaway(1.0, 7.0, 1.0, 1.0, 3, 0.0, 0.0))
    time, heading = np.linspace(0.0, 200.0, 501), 0.7
    middle = np.array([1.0, 37.0, 0.0])
    bow = np.array([math.sin(heading), math.cos(heading), 0.0])
    starboard = np.array([math.cos(heading), -math.sin(heading), 0.0])
    results = []
    for offset in (np.zeros(3), middle):
        form = replace(COASTER, middle=(float(offset[0]), float(offset[1])))
        bounds = bounds_of(sea, form, np.array([heading]), np.zeros((1, 2)))
        origin = (500.0 * bow - offset[1] * bow - offset[0] * starboard)[None]
        pose = Motion(np.zeros(1), origin, np.array([heading]), sway=SeawayMotion(sea, form, bounds)).pose(time)
        assert pose.rotation is not None
        results.append((pose.position + pose.rotation @ offset, pose.rotation))
    np.testing.assert_allclose(results[1][0], results[0][0], atol=0.01)
    np.testing.assert_allclose(results[1][1], results[0][1], atol=1e-12)


def test_commands_leave_sway_continuous() -> None:
    """Speed, course at a rate, and a turn without end, one after the other, of a turning ship; also in the truth's motion."""
    motion = motion_of("turning", steerable={})
    assert isinstance(motion, SteeredMotion)
    for time, change in ((40.0, {"speed": 2.0}), (47.0, {"turn_rate": -0.03}), (60.0, {"speed": 9.0, "turn_rate": 0.0})):
        before = motion.segment_at(time)
        old = motion.sway_state(np.array([time])).values
        motion.steer(before._replace(turn_time=math.inf, **change).after(before))
        motion.follow()
        np.testing.assert_allclose(motion.sway_state(np.array([time])).values, old, atol=1e-9)
        past = motion.past.sway_state(np.array([time - 1e-7, time + 1e-7]))
        np.testing.assert_allclose(past.values[0], past.values[1], atol=1e-6)
        here = motion.past.sway_state(np.array([time + 3.0])).rates
        ends = [motion.past.sway_state(np.array([time + 3.0 + h])).values for h in (-H, H)]
        np.testing.assert_allclose(here, (ends[1] - ends[0]) / (2 * H), atol=2e-6)
    assert np.hypot(*law_of(motion).excess(0.0)) == 0.0
    state = motion.sway_state(np.linspace(60.0, 4000.0, 401))
    assert (np.abs(state.values) <= law_of(motion).max_values).all() and (
        np.abs(state.rates) <= law_of(motion).max_rates
    ).all()
    assert EASING == 10.0


# Responses of a hull: limits of theory, the published expressions written out as they are printed, scaling.
FREQUENCY = np.array([0.16, *np.linspace(0.3, 2.5, 45)])  # rad/s; the first is of waves 24 hulls long


def at(form: HullForm, frequency: Floats, course: float, speed: float = 0.0) -> Response:
    """The response to waves that travel `course` degrees off the bow's direction, to starboard: 180 is a head sea."""
    k, off = frequency**2 / GRAVITY, np.deg2rad(course)
    return response(form, frequency, k * np.cos(off), k * np.sin(off), frequency - speed * k * np.cos(off))


@pytest.mark.parametrize("course", [0.0, 50.0, 90.0, 180.0, 250.0])
def test_a_ship_follows_long_waves(course: float) -> None:
    """Heave over the wave 1, pitch and roll over the slopes 1: waves of 40 km, whose k T is 7e-4, and k L 0.01."""
    frequency = np.array([0.04])
    k, off = frequency**2 / GRAVITY, np.deg2rad(course)
    roll, pitch, heave = at(COASTER, frequency, course)
    assert heave == pytest.approx(1.0, abs=2e-3)
    assert pitch / k == pytest.approx(1j * np.cos(off), abs=2e-3), "bow up where the sea rises ahead"
    assert roll / k == pytest.approx(-1j * np.sin(off), abs=2e-2), "starboard down where it falls; damping lags by 1 %"


@pytest.mark.parametrize("speed", [0.0, 6.0])
@pytest.mark.parametrize("course", [0.0, 30.0, 135.0, 180.0])
def test_heave_and_pitch_are_the_published_ones(course: float, speed: float) -> None:
    """Amplitudes of Jensen, Mansour and Olsen 2004, written out with their alpha, A, f, kappa, F, G and eta."""
    form, g = COASTER, GRAVITY
    breadth, draught, length = form.breadth * form.block, form.draught, form.length
    _, pitch, heave = at(form, FREQUENCY, course, speed)
    for n, omega in enumerate(FREQUENCY.tolist()):
        k = omega**2 / g
        froude = speed / np.sqrt(g * length)
        alpha = 1.0 - froude * np.sqrt(k * length) * np.cos(np.deg2rad(course))
        k_e = abs(k * np.cos(np.deg2rad(course)))
        a = 2.0 * np.sin(k * breadth * alpha**2 / 2.0) * np.exp(-k * draught * alpha**2)
        f = np.sqrt((1.0 - k * draught) ** 2 + (a**2 / (k * breadth * alpha**3)) ** 2)
        kappa = np.exp(-k * draught)
        big_f = kappa * f * 2.0 / (k_e * length) * np.sin(k_e * length / 2.0)
        big_g = kappa * f * 24.0 / ((k_e * length) ** 2 * length)
        big_g *= np.sin(k_e * length / 2.0) - k_e * length / 2.0 * np.cos(k_e * length / 2.0)
        eta = 1.0 / np.sqrt((1.0 - 2.0 * k * draught * alpha**2) ** 2 + (a**2 / (k * breadth * alpha**2)) ** 2)
        assert abs(heave[n]) == pytest.approx(abs(eta * big_f), rel=1e-9)
        assert abs(pitch[n]) == pytest.approx(abs(eta * big_g), rel=1e-9, abs=1e-15)


def test_roll_is_a_resonance() -> None:
    """At its natural period a hull rolls 1 / (2 damping) times the effective slope, a quarter of a period later; far above it
    it does not. Of waves as long as three beams the effective slope is known: 3 (sin x - x cos x) / x^3 at x = 0.8 pi / 3."""
    natural = np.array([2.0 * np.pi / COASTER.roll_period])
    k = natural**2 / GRAVITY
    x = 0.8 * COASTER.breadth * k / 2.0
    slope = k * np.exp(-k * COASTER.draught) * 3.0 * (np.sin(x) - x * np.cos(x)) / x**3
    assert at(COASTER, natural, 90.0).roll / slope == pytest.approx(1.0 / (2.0 * 0.1), rel=1e-9)
    assert abs(at(COASTER, 3.0 * natural, 90.0).roll[0]) < 0.01 * 9.0 * k[0]
    assert not at(COASTER, natural, 0.0).roll[0] and at(COASTER, natural, 90.0).pitch[0] == pytest.approx(0.0, abs=1e-15)


def test_responses_scale_by_froude() -> None:
    """A ship 3 times as large in waves 3 times as long answers by the same angles a wave slope, and the same heave a height."""
    size = 3.0
    large = HullForm(225.0, 37.5, 15.0, 0.7, 0.8, 8.9 * np.sqrt(size), 0.1)
    small, scaled = at(COASTER, FREQUENCY, 130.0, 5.0), at(large, FREQUENCY / np.sqrt(size), 130.0, 5.0 * np.sqrt(size))
    for one, other, factor in zip(small, scaled, (size, size, 1.0), strict=True):
        np.testing.assert_allclose(factor * other, one, rtol=1e-9, atol=1e-12)


def test_a_ship_that_overtakes_waves_lags_behind_them_too() -> None:
    """With exp(-i w t), a frequency below 0 is the conjugate motion: damping takes energy at either sign."""
    k = FREQUENCY**2 / GRAVITY
    met, overtaken = (response(COASTER, FREQUENCY, 0.6 * k, 0.8 * k, sign * 0.7 * FREQUENCY) for sign in (1.0, -1.0))
    np.testing.assert_allclose(overtaken.heave, np.conj(met.heave), rtol=1e-12)
    np.testing.assert_allclose(overtaken.roll, -np.conj(met.roll), rtol=1e-12)
    still = response(COASTER, FREQUENCY, k, 0.0 * k, 0.0 * FREQUENCY)
    assert np.isfinite(still.heave).all() and np.isfinite(still.pitch).all(), "at rest in a wave that it rides"


def test_a_planing_craft_has_a_largest_speed_for_its_response() -> None:
    assert COASTER.max_speed == pytest.approx(0.4 * np.sqrt(9.80665 * 75.0))
    assert replace(COASTER, length=8.0).max_speed < 4.0  # m/s
