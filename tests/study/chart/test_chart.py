"""Charts of scenes."""

from collections.abc import Callable

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.echoes import Echoes
from radar_service.numerics.frames import wrap_angle
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.radar.antenna import AntennaPattern
from radar_service.radar.patterns import PATTERNS, Table, Taylor
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes
from radar_service.study.chart import chart
from radar_service.study.chart.figure import summary, summary_text
from radar_service.study.chart.frozen_scene import all_echoes, all_scatterers, frozen, is_diffuse, occlusion_of, only_diffuse
from radar_service.study.chart.point import Point, drawn_points, mean_and_spread, pareto, time_interleaved
from radar_service.study.chart.power_panel import (
    powers_in,
    ray_powers,
    samplers,
    scatterer_powers,
    target_windows,
)
from radar_service.study.chart.reference_surface import ReferenceSurface, Window, beam, compressed_pulse
from radar_service.study.chart.scattering_panel import (
    canonical_targets,
    coherent_cross_sections,
    random_turns,
    scattering_points,
    targets_scene,
)
from tests.batch.pickling import Pickling
from tests.reference.compressed_pulse import compressed_pulse as other_pulse
from tests.reference.point_scene import other_chirp
from tests.scenes import point, radar, scene
from tests.study.chart.settings import PLATE, SMALL


def test_panels_are_measured_wherever_an_executor_says() -> None:
    """Where nothing is in sight, none but those that show it."""
    elsewhere = Pickling()
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK, executor=elsewhere)
    assert elsewhere.calls == 2


# point: points of the chart: interleaved timing and the Pareto front.
def test_tasks_share_a_time_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """One task takes 1 s, the other 3 s. A budget of ten seconds gives five to each."""
    clock = [0.0]
    monkeypatch.setattr("radar_service.study.chart.point.time.process_time", lambda: clock[0])

    def lasting(seconds: float) -> Callable[[], object]:
        return lambda: clock.append(clock.pop() + seconds)

    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], "tasks", budget=10.0)
    assert times == [(1.0,) * 5, (3.0,) * 2]
    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], "tasks", budget=20.0)
    assert times == [(1.0,) * 9, (3.0,) * 4]
    assert time_interleaved([lasting(9.0)], [5], "tasks", budget=4.0) == [(9.0,) * 2]  # a spread needs two


def test_no_point_beats_the_pareto_front() -> None:
    def at(seconds: float, error: float | None, missed: float | None = None) -> Point:
        return Point("field", "f", "s", (seconds,), False, error, missed=missed)

    points = [at(3, -10), at(1, -5), at(2, -4), at(4, -10), at(0.5, None), at(0.1, -90, missed=0.4)]
    assert pareto(points) == [points[1], points[0]]


# power_panel: samplers and their panel, against the reference lattice and the binomial law.
def test_samplers_agree_with_the_lattice_and_documented_rays_miss() -> None:
    """A plate of 200 m^2: scatterers have its mean power within their noise, 0.5 dB. Of 2000 documented rays in a box of 36 x 75
    degrees, 0.82 sr, at least one meets its 0.00031 sr with probability 0.54: 0.46 of 170 draws miss, 4 sigma are 0.15."""
    world = only_diffuse(frozen(scene([PLATE], radar=SMALL)))
    windows = target_windows(world, all_echoes(world, 0), 1)
    truth = np.array([ReferenceSurface(world).power(windows[0], 64, 128)])
    chosen = [s for s in samplers(world, windows, occlusion_of(world), 2000) if s.setting in ("4 per cell", "2000")]
    points = {p.family: p for p in drawn_points("power", chosen, truth, 170)}
    assert points["scatterers"].error_db == pytest.approx(0.0, abs=0.5) and points["scatterers"].missed == 0.0
    assert points["documented rays"].missed == pytest.approx((1 - 200 / 640000 / 0.823) ** 2000, abs=0.15)
    assert points["documented rays"].preset == "documented" and points["scatterers"].preset == "balanced"


def test_misses_bias_and_spread_are_separate() -> None:
    """Draws of 2 and 4 for a truth of 1: mean 3 (4.77 dB), deviation sqrt 2, spread 10 log10(1 + sqrt 2 / 3)."""
    error, spread, missed = mean_and_spread(np.array([[2.0, 0.0], [4.0, 0.0]]), np.array([1.0, 1.0]))
    assert error == pytest.approx(4.771, abs=1e-3) and spread == pytest.approx(1.678, abs=1e-3) and missed == 0.5
    assert mean_and_spread(np.zeros((2, 1)), np.ones(1)) == (None, None, 1.0)


def test_each_draw_has_its_own_truth() -> None:
    """Every draw is twice its truth: 3.01 dB in the mean; the errors of the draws are 1 and 3."""
    error, spread, missed = mean_and_spread(np.array([[2.0], [6.0]]), np.array([[1.0], [3.0]]))
    assert error == pytest.approx(3.0103, abs=1e-4) and missed == 0.0
    assert spread == pytest.approx(10 * np.log10(1 + np.sqrt(2) / 4), abs=1e-9)


# reference_surface: the reference of the samplers, against the radar equation and geometry.
def test_mean_power_of_a_plate_at_normal_incidence() -> None:
    """sigma = gamma A; the tolerance is the step of the lattice at the edges, 1/128 + 1/256, 0.05 dB."""
    world = frozen(scene([PLATE], radar=SMALL, environment={"earth": "flat"}))
    (window,) = target_windows(world, all_echoes(world, 0), 1)
    exact = float(received_amplitude(world.radar, np.full(1, 800.0))[0] ** 2) * world.bodies[0].material.gamma * 200.0
    assert 10 * np.log10(ReferenceSurface(world).power(window, 128, 256) / exact) == pytest.approx(0.0, abs=0.05)


def test_a_wall_shadows_the_plate_behind_it() -> None:
    """Antenna at 15 m, plate from 10 to 20 m at 800 m. A wall of 3 m at 400 m shadows nothing (the line over its top meets
    the sea before the plate). A wall of 40 m shadows all (the line is at 65 m at the plate)."""
    low, high = ({**PLATE, "name": "w", "height_m": h, "position_m": [0, 400, h / 2]} for h in (3, 40))
    powers = []
    for wall in (low, high):
        world = frozen(scene([PLATE, wall], radar=SMALL))
        (window,) = target_windows(world, all_echoes(frozen(scene([PLATE], radar=SMALL)), 0), 1)
        powers.append(ReferenceSurface(world).power(window, 32, 64))
    assert powers[0] > 0.0 and powers[1] == 0.0


# power_panel: samplers of diffuse surfaces: windows, settings, and two independent samplers on one plate.
WINDOW = Window(-0.1, 0.2, 700.0, 900.0)


def test_a_window_has_the_power_of_its_echoes() -> None:
    """|1|^2 + |2i|^2 = 5; the third echo is too far, the fourth on another bearing."""
    echoes = Echoes(np.array([800.0, 750.0, 950.0, 800.0]), np.array([0.0, 0.05, 0.0, 1.0]), np.array([1.0, 2.0j, 4.0, 8.0]))
    assert powers_in([WINDOW], echoes) == pytest.approx([5.0])


def test_scatterers_and_rays_agree_on_a_plate() -> None:
    """The mean of 16 draws of some 50 echoes each errs by 0.21 dB for both; 1.2 dB are 4 sigma."""
    world = only_diffuse(frozen(scene([{**PLATE, "width_m": 60, "height_m": 30}], radar=SMALL)))
    occlusion = occlusion_of(world)
    scatterers = [scatterer_powers(world, [WINDOW], occlusion, 4.0, seed)[0] for seed in range(16)]
    rays = [ray_powers(world, [WINDOW], occlusion, "sobol", 8000, seed)[0] for seed in range(16)]
    assert len(set(scatterers)) == len(set(rays)) == 16
    assert 10 * np.log10(np.mean(scatterers) / np.mean(rays)) == pytest.approx(0.0, abs=1.2)


def test_settings_end_at_the_largest_number_of_rays() -> None:
    world = only_diffuse(frozen(scene([PLATE], radar=SMALL)))
    chosen = samplers(world, [WINDOW], occlusion_of(world), 2000)
    settings = {(s.family, s.setting): s.preset for s in chosen}
    assert {setting for family, setting in settings if "rays" in family} == {"500", "2000"}
    presets = {settings["scatterers", f"{density} per cell"] for density in (1, 4, 16)}
    assert presets == {"fast", "balanced", "reference"} and settings["documented rays", "2000"] == "documented"


# scattering_panel: targets of known cross-section, against textbook values.


def test_cross_sections_of_the_canonical_targets() -> None:
    """Textbook values in wavelengths, r = 4, a = 20: pi r^2; 2 pi r a^2; 4 pi a^4; 8 pi a^4; 4 pi a^4 / 3, of lambda^2."""
    targets = canonical_targets(0.03)
    facing = {target.name: float(target.cross_section(np.zeros(1))[0]) for target in targets}
    textbook = {"sphere": np.pi * 16, "cylinder": np.pi * 3200, "plate": 4 * np.pi * 160_000, "dihedral": 8 * np.pi * 160_000,
                "trihedral": 4 * np.pi * 160_000 / 3}  # fmt: skip
    assert facing == {name: pytest.approx(value * 0.0009, rel=1e-9) for name, value in textbook.items()}
    assert facing == {target.name: target.facing for target in targets}
    plate = targets[2]  # turns half way to its first null
    assert plate.cross_section(np.array([2.0 * plate.max_turn]))[0] < 1e-6 * plate.facing


# reference_surface: the closed form of the chart, against other derivations.
@pytest.mark.parametrize(("modulation", "compression"), [("nlfm", "matched"), ("nlfm", "inverse")])
def test_the_forms_of_other_chirps_agree_with_those_of_the_tests(modulation: str, compression: str) -> None:
    """Two ways to sum the phase and to join samples agree to 2e-5 of the peak."""
    small = radar(**SMALL, window="nuttall", modulation=modulation, compression=compression)
    delay = np.linspace(-1.2, 1.2, 2001) * small.pulse
    expected = other_chirp(small)(delay, delay)
    np.testing.assert_allclose(compressed_pulse(delay, small), expected, atol=2e-5)


@pytest.mark.parametrize(
    ("window", "series"), [("hamming", (0.54, 0.46)), ("nuttall", (0.355768, 0.487396, 0.144232, 0.012604))]
)
def test_closed_form_agrees_with_that_of_the_tests(window: str, series: tuple[float, ...]) -> None:
    """Two derivations, about the middle of the pulse and of the overlap, agree to the rounding of 64 bits."""
    small = radar(**SMALL, window=window)
    delay = np.linspace(-4.1e-6, 4.1e-6, 501)
    np.testing.assert_allclose(
        compressed_pulse(delay, small), other_pulse(delay, small.bandwidth, small.pulse, series), atol=1e-12
    )


@pytest.mark.parametrize("pattern", [*PATTERNS.values(), Taylor(25.0, 3)], ids=lambda pattern: pattern.description)
def test_two_formulas_of_a_beam_agree(pattern: AntennaPattern) -> None:
    """The product of zeros and the sum of sincs agree to 1e-6 of boresight: -120 dB, below the error of every method."""
    offset = np.linspace(-np.pi, np.pi, 1001)[:-1]
    np.testing.assert_allclose(beam(offset, 0.07, pattern), pattern.gain(offset, 0.07), atol=1e-6)


def test_a_pattern_without_a_formula_uses_its_own_gain() -> None:
    """Offsets wrap around; equal to the rounding of 64 bits."""
    table = Table(((0.0, 1.0), (0.05, 0.4), (0.2, 0.001)))
    offset = np.linspace(-0.3, 0.3, 101)
    np.testing.assert_allclose(beam(offset + 2.0 * np.pi, 0.07, table), table.gain(offset), atol=1e-12)


# frozen_scene: frozen scenes and their echoes.
SHIP = point("ship", 300, 400, speed_kn=20, course_deg=90, swerling=1)


def test_a_frozen_scene_keeps_the_poses_of_the_start() -> None:
    moving = scene([SHIP], radar={**SMALL, "blind_sectors_deg": [[10, 20]]}, own_ship={"speed_kn": 10, "course_deg": 45})
    start = frozen(moving)
    (body,) = start.bodies
    assert body.motion.at_rest and start.own_ship.at_rest and body.swerling == 0
    assert start.radar.blind_sectors == () and not start.radar.eclipsing
    np.testing.assert_array_equal(body.motion.pose(99.0).position, moving.bodies[0].motion.pose(0.0).position)
    np.testing.assert_array_equal(start.antenna(99.0), moving.antenna(0.0))
    assert start.own_ship.pose(0.0).heading == moving.own_ship.pose(0.0).heading


def test_echoes_end_where_their_sidelobes_no_longer_reach_a_bin() -> None:
    """cT/2 of a pulse of 4 us is 600 m, so echoes end at 2100 m of a range of 1500 m."""
    near, far = point("near", 0, 2095), point("far", 0, 2105)
    echoes = all_echoes(frozen(scene([near, far], radar=SMALL)), 0)
    assert echoes.range == pytest.approx([2095.0], abs=1.0) and echoes.azimuth == pytest.approx([0.0])


def test_only_diffuse_surfaces_remain() -> None:
    world = only_diffuse(scene([PLATE, SHIP], radar=SMALL, environment={"multipath": True, "noise": True}))
    assert [body.name for body in world.bodies] == ["p"] and is_diffuse(world.bodies[0])
    assert not world.environment.multipath and not world.environment.noise


def test_scatterers_follow_the_fidelity() -> None:
    """Sixteen to a cell are four times those of four to a cell, within 5 % of rounding to whole points."""
    plate = frozen(scene([{**PLATE, "width_m": 1000, "height_m": 300}], radar=SMALL))
    some, more = (int(all_scatterers(plate, PRESETS[name], 0).scatterers.sum()) for name in ("balanced", "reference"))
    assert more == pytest.approx(4 * some, rel=0.05)


# figure: the chart in words.
def test_the_summary_lists_presets_the_fastest_and_the_slow() -> None:
    points = [
        Point("field", "integer-delay chirps", "printed beam", (0.04,), True, -2.0, preset="documented"),
        Point("field", "integer-delay chirps", "12 beamwidths", (0.05,), True, -17.0),
        Point("field", "Kaiser-Bessel grid", "4 bins", (3.3e-4,), False, -62.0, preset="fast"),
        Point("field", "azimuth by azimuth", "3 beamwidths", (4e-4,), False, -60.0, preset="fast under way"),
    ]
    assert summary(points, 3.5e-3) == {
        "field": [
            "documented: -2 dB in 40 ms",
            "fast: -62 dB in 330 us; under way -60 dB in 400 us",
            "documented chain with corrected beam: -17 dB",
            "fastest within -40 dB: Kaiser-Bessel grid (4 bins), -62 dB in 330 us",
            "slower than real time (3.5 ms): 2 of 4 settings",
        ]
    }


def test_the_summary_names_misses_and_models() -> None:
    points = [
        Point("power", "scatterers", "4 per cell", (5e-4,), False, 0.2, 0.9, 0.0, "balanced"),
        Point("power", "documented rays", "2000", (6e-4,), False, 9.6, 4.9, 0.63, "documented"),
        Point("power", "uniform rays", "500", (1e-4,), False, None, None, 1.0),
        Point("power", "uniform rays", "8000", (1e-3,), False, 1.0, 2.0, 0.016),
        Point("scattering", "physical optics", "2 bounces", (1e-5,), False, 23.0, 18.0, 0.0, "fast"),
    ]
    lines = summary(points, 3.5e-3)
    assert lines["power"] == [
        "balanced: mean 0.2 dB, spread 0.9 dB, 500 us",
        "documented: mean 9.6 dB, spread 4.9 dB, 63 % missed, 600 us",
        "best rays, uniform rays (8000): mean 1 dB, spread 2 dB, 1.6 % missed, 1 ms",
        "miss more than half of their targets: 2 of 4 settings",
    ]
    assert lines["scattering"] == ["physical optics, 2 bounces = fast: mean 23 dB, spread 18 dB"]
    text = summary_text(lines)
    assert text.startswith("Samplers\n- balanced") and "\nScattering models\n- physical optics" in text


# scattering_panel: scattering models on the canonical targets.
def test_a_corner_needs_as_many_bounces_as_it_has_faces() -> None:
    """Three bounces reach 0.2 dB on five targets. Without the third the trihedral is over 33 dB too weak, 15 dB in the root mean
    square; without the second the dihedral is too."""
    points = {p.setting: p for p in scattering_points(frozen(scene([PLATE], radar=SMALL)), 4, 0)}
    one, two, three = (points[key].error_db or 0.0 for key in ("1 bounce", "2 bounces", "3 bounces"))
    assert three < 0.2 and 15 < two < one and points["3 bounces"].missed == 0.0
    assert {p.preset for p in points.values()} == {None, "fast", "balanced, reference"}


def test_echoes_add_with_the_phase_of_their_range() -> None:
    """Two echoes of 1 m^2, the second 0.3 wavelengths behind. A phase that compensates it gives 4 m^2, no phase
    4 cos^2(0.6 pi). 1e-4: of the range."""
    made = frozen(scene([PLATE]))
    antenna, wavelength = made.antenna(0.0)[0], made.radar.wavelength
    position = antenna + np.array([[0.0, 1000.0, 0.0], [0.0, 1000.0 + 0.3 * wavelength, 0.0]])
    for phase, expected in ((1.2j * np.pi, 4.0), (0j, 4.0 * np.cos(0.6 * np.pi) ** 2)):
        echoes = BodyEchoes.of_points(position, np.array([1.0, np.exp(phase)]), np.zeros(2, dtype=np.int64))
        assert coherent_cross_sections(made, position, echoes) == pytest.approx(expected, rel=1e-4)


def test_targets_have_the_turn_of_their_draw() -> None:
    """Draw k is that of scan k: each target faces the antenna but for its turn."""
    made = frozen(scene([PLATE]))
    targets = canonical_targets(made.radar.wavelength)
    turns = random_turns(targets, 3, 5)
    bodies = targets_scene(made, targets, turns, "optics").bodies
    for k, body in enumerate(bodies):
        heading = body.motion.pose(made.radar.rotation_period * np.arange(3)).heading
        np.testing.assert_allclose(wrap_angle(heading - (k + 0.5) * 2 * np.pi / 5 - np.pi - turns[:, k]), 0.0, atol=1e-9)
