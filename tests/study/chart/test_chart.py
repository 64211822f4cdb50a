"""Charts of scenes."""

import pickle
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.echo.echoes import Echoes
from radar_service.propagation.radar_equation import received_amplitude
from radar_service.study.chart import chart
from radar_service.study.chart.frozen_scene import all_echoes, frozen, occlusion_of, only_diffuse
from radar_service.study.chart.point import Point, pareto, time_interleaved
from radar_service.study.chart.power_panel import (
    mean_and_spread,
    power_points,
    powers_in,
    ray_powers,
    samplers,
    scatterer_powers,
    target_windows,
)
from radar_service.study.chart.reference_surface import ReferenceSurface, Window
from radar_service.study.chart.scattering_panel import canonical_targets
from tests.scenes import scene
from tests.study.chart.settings import PLATE, SMALL


def test_a_scene_with_nothing_in_sight_is_refused() -> None:
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK)


class Pickling:
    """An executor that does each job at once, with what is left of it after pickling."""

    def __init__(self) -> None:
        self.calls = 0

    def submit(self, function: Any, /, *arguments: Any) -> "Future[Any]":
        self.calls += 1
        function, arguments = pickle.loads(pickle.dumps((function, arguments)))
        future: Future[Any] = Future()
        future.set_result(function(*arguments))
        return future


def test_panels_are_measured_wherever_an_executor_says() -> None:
    elsewhere = Pickling()
    with pytest.raises(rs.SceneError, match="add a body in sight"):
        chart.measure(scene([], radar=SMALL), effort=chart.QUICK, executor=elsewhere)
    assert elsewhere.calls == 2  # panels that show whether there is anything to compare


# point: points of the chart: interleaved timing and the Pareto front.
def test_tasks_share_a_time_budget(monkeypatch: pytest.MonkeyPatch) -> None:
    """One task takes 1 s, the other 3 s. A budget of ten seconds gives five to each."""
    clock, calls = [0.0], []
    monkeypatch.setattr("radar_service.study.chart.point.time.process_time", lambda: clock[0])

    def lasting(seconds: float) -> Callable[[], object]:
        return lambda: clock.append(clock.pop() + seconds)

    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], lambda: calls.append(1), budget=10.0)
    assert times == [(1.0,) * 5, (3.0,) * 2] and len(calls) == 18
    times = time_interleaved([lasting(1.0), lasting(3.0)], [9, 9], lambda: None, budget=20.0)
    assert times == [(1.0,) * 9, (3.0,) * 4]
    assert time_interleaved([lasting(9.0)], [5], lambda: None, budget=4.0) == [(9.0,) * 2]  # a spread needs two


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
    points = {p.family: p for p in power_points(chosen, truth, 170, 0, lambda: None)}
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


# samplers: samplers of diffuse surfaces: windows, settings, and two independent samplers on one plate.
WINDOW = Window(-0.1, 0.2, 700.0, 900.0)


def test_a_window_has_the_power_of_its_echoes() -> None:
    """|1|^2 + |2i|^2 = 5; the third echo is too far, the fourth on another bearing."""
    echoes = Echoes(np.array([800.0, 750.0, 950.0, 800.0]), np.array([0.0, 0.05, 0.0, 1.0]), np.array([1.0, 2.0j, 4.0, 8.0]))
    assert powers_in([WINDOW], echoes) == pytest.approx([5.0])


def test_scatterers_and_rays_agree_on_a_plate() -> None:
    """The mean of 32 draws of some 50 echoes each errs by 0.15 dB for both; 1 dB are more than 4 sigma."""
    world = only_diffuse(frozen(scene([{**PLATE, "width_m": 60, "height_m": 30}], radar=SMALL)))
    occlusion = occlusion_of(world)
    scatterers = [scatterer_powers(world, [WINDOW], occlusion, 4.0, seed)[0] for seed in range(32)]
    rays = [ray_powers(world, [WINDOW], occlusion, "sobol", 8000, seed)[0] for seed in range(32)]
    assert len(set(scatterers)) == len(set(rays)) == 32
    assert 10 * np.log10(np.mean(scatterers) / np.mean(rays)) == pytest.approx(0.0, abs=1.0)


def test_settings_end_at_the_largest_number_of_rays() -> None:
    world = only_diffuse(frozen(scene([PLATE], radar=SMALL)))
    chosen = samplers(world, [WINDOW], occlusion_of(world), 2000)
    settings = {(s.family, s.setting): s.preset for s in chosen}
    assert {setting for family, setting in settings if "rays" in family} == {"500", "2000"}
    presets = {settings["scatterers", f"{density} per cell"] for density in (1, 4, 16)}
    assert presets == {"fast", "balanced", "reference"} and settings["documented rays", "2000"] == "documented"


# canonical_targets: targets of known cross-section, against textbook values.


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
