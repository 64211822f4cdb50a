"""The two estimators of diffuse surfaces, rays and scatterers, against closed forms and against each other."""

import functools
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats

import radar_service as rs
from radar_service.engine.preparation import prepare
from radar_service.numerics.frames import effective_earth_radius
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import BodyEchoes
from radar_service.scattering.rays import RayCaster, RayHits
from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers
from radar_service.trace.ray_sampling import SAMPLERS
from tests.scattering.test_fixed_scatterers import context, instant
from tests.scenes import point, scene

LEVEL = 1e-4  # of each statistical test here; seeds are fixed
EARTH = 4 / 3 * 6_371_000.0
COARSE = {"range_max_m": 1200, "pulse_s": 1e-6, "azimuths": 16, "beamwidth_deg": 40, "beamwidth_el_deg": 20}

BOX = {"shape": "box", "length_m": 60, "width_m": 40, "height_m": 20}
HOUSE = {"name": "h", **BOX, "position_m": [0, 300, 0], "material": "wood"}


def caster(made: rs.Scene, sampler: str = "rays", seed: int = 0) -> RayCaster:
    return RayCaster(made.bodies, made.radar, effective_earth_radius(made.environment.earth_factor), sampler, seed)


def estimators(made: rs.Scene, seed: int) -> dict[str, ScattererSet]:
    """Each estimator of the bodies of a scene, none of them declared."""
    return {name: scatterers(made, name, seed) for name in (*SAMPLERS, "scatterers")}


def scatterers(made: rs.Scene, sampler: Any, seed: int) -> ScattererSet:
    """All bodies of a scene by one estimator."""
    earth = effective_earth_radius(made.environment.earth_factor)
    return build_scatterers(made.bodies, range(len(made.bodies)), context(made, seed, earth, sampler=sampler))


def echoes_at_start(made: rs.Scene, source: ScattererSet) -> BodyEchoes:
    """Echoes of them at t = 0."""
    earth = effective_earth_radius(made.environment.earth_factor)
    return source.echoes(made.antenna(0.0)[0], instant(made, earth=earth))


def level_land(folder: Path, up: float, near: float, far: float, half: float) -> dict[str, Any]:
    """A level strip `half` each side of north, from `near` to `far`, `up` above the sea, as a mesh of 100-m squares."""
    x, y = np.meshgrid(np.arange(-half, half + 1, 100), np.arange(near, far + 1, 100))
    corner = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (q.ravel() + 1 for q in (corner[:-1, :-1], corner[:-1, 1:], corner[1:, 1:], corner[1:, :-1]))
    lines = [f"v {p} {q} {up}" for p, q in zip(x.ravel(), y.ravel(), strict=True)]
    lines += [f"f {i} {j} {k} {m}" for i, j, k, m in zip(a, b, c, d, strict=True)]
    (folder / "strip.obj").write_text("\n".join(lines))
    return {"name": "strip", "mesh": "strip.obj", "material": "land"}


def test_level_land_over_the_curved_earth_has_its_cross_section(tmp_path: Path) -> None:
    """Land 10 m up, 2 to 12 km off, observed from 30 m: the ray grazes it at (h - u)/d - d/(2 ae), so the sum of sigma is
    gamma times the integral of that over the strip. The earth's curve takes 12 % of it away; both estimators show it.

    Scatterers: every one of 100 000 a random position, sampling error 0.3 %, 5 sigma. Rays: 6 sigma of the Poisson count.
    """
    radar = {"range_max_m": 13_000, "height_m": 30, "beamwidth_el_deg": 0.4, "beamwidth_deg": 10, "rays": 20_000,
             "bandwidth_hz": 5e6}  # fmt: skip
    made = rs.load_scene({"body": [level_land(tmp_path, 10, 2000, 12_000, 500)], "radar": radar}, folder=tmp_path)
    x, y = np.meshgrid(np.arange(-499.5, 500), np.arange(2002.5, 12_000, 5))
    d = np.hypot(x, y)
    exact = made.bodies[0].material.gamma * np.sum(20 / d - d / (2 * EARTH)) * 5.0
    assert 0.80 < exact / (made.bodies[0].material.gamma * np.sum(20 / d) * 5.0) < 0.90
    for name, source in estimators(made, seed=1).items():
        echoes = echoes_at_start(made, source)
        total = float(np.sum(np.abs(echoes.amplitude) ** 2))
        assert total == pytest.approx(exact, rel=0.015 if name == "scatterers" else 6 / np.sqrt(len(echoes))), name


@pytest.mark.sample(2)
@pytest.mark.parametrize("sampler", SAMPLERS)
def test_a_facing_plate_has_the_cross_section_of_its_area(sampler: str) -> None:
    """sigma = gamma A for a plate square on at 800 m: 5 turns of rays, 5 sigma of the Poisson count."""
    plate = {"name": "p", "shape": "plate", "width_m": 60, "height_m": 20, "position_m": [0, 800, 15], "heading_deg": 180}
    made = scene([{**plate, "material": "concrete"}], radar={**COARSE, "beamwidth_el_deg": 4, "rays": 20_000})
    sums, counts = [], 0
    for seed in range(5):
        echoes = echoes_at_start(made, scatterers(made, sampler, seed))
        sums.append(float(np.sum(np.abs(echoes.amplitude) ** 2)))
        counts += len(echoes)
    assert counts > 200
    assert np.mean(sums) == pytest.approx(made.bodies[0].material.gamma * 1200, rel=5 / np.sqrt(counts))


def compact_target() -> rs.Scene:
    """A plate of 20 x 20 m, square on at 2 km: so few rays to its solid angle that half the turns or so miss it."""
    plate = {"name": "p", "shape": "plate", "width_m": 20, "height_m": 20, "position_m": [0, 2000, 15], "heading_deg": 180}
    return scene(
        [{**plate, "material": "concrete"}],
        radar={"range_max_m": 2500, "beamwidth_deg": 4, "beamwidth_el_deg": 4, "rays": 256},
        environment={"earth": "flat"},
    )


def test_uniform_rays_starve_a_compact_target_as_the_binomial_law_says() -> None:
    """p = (w/R)(h/R) over 2 pi x 3 beamwidths; of 200 turns a share (1 - p)^M meets nothing: exact binomial test. What is
    met carries more for it: the mean stays the area, with the spread of Poisson counts, 5 sigma. Scatterers see it."""
    made = compact_target()
    turns = [caster(made, "rays", seed).hits(made.antenna(0.0)[0], 0.0, 1e5) for seed in range(200)]
    thrown, chance = 256 * 30, (20 / 2000) ** 2 / (2 * np.pi * np.deg2rad(12))
    missed = sum(len(hits) == 0 for hits in turns)
    expected = (1 - chance) ** thrown
    assert 0.2 < expected < 0.7
    assert stats.binomtest(missed, len(turns), expected).pvalue > LEVEL
    areas = np.array([np.sum(hits.range**2 * hits.solid_angle) for hits in turns])
    assert areas.mean() == pytest.approx(400.0, rel=5 / np.sqrt(len(turns) * chance * thrown))
    echoes = echoes_at_start(made, scatterers(made, "scatterers", 0))
    assert np.sum(np.abs(echoes.amplitude) ** 2) == pytest.approx(
        made.bodies[0].material.gamma * 400, rel=1e-4
    )  # slant: 10 m to 2 km, squared


def test_declared_bodies_occlude_rays_and_scatter_themselves() -> None:
    """A declared wall in front of a diffuse plate: no hit on the plate counts, and the wall's hits are dropped for what it
    declares; a point behind no wall is there as it is without rays."""
    plate = {"name": "p", "shape": "plate", "width_m": 30, "height_m": 10, "position_m": [0, 1000, 15], "heading_deg": 180}
    wall = {"name": "w", "shape": "plate", "width_m": 60, "height_m": 60, "position_m": [0, 500, 15], "rcs_dbsm": 7}
    bodies = [{**plate, "material": "concrete"}, wall, point("t", 700, 0)]
    made = scene(bodies, radar=COARSE)
    hits = caster(made).hits(made.antenna(0.0)[0], 0.0, 1e5)
    assert set(hits.body) == {1}
    rays = prepare(made, replace(PRESETS["balanced"], sampler="rays"), 3)
    plain = prepare(made, PRESETS["balanced"], 3)
    np.testing.assert_array_equal(rays.resting.position, plain.resting.position)
    np.testing.assert_array_equal(rays.resting.echoes.amplitude, plain.resting.echoes.amplitude)


def test_hits_lie_on_the_bodies_that_were_hit() -> None:
    """Turned boxes, two at rest and one under way: each hit lies on the surface of its body in that body's own frame (1 mm:
    bent corners against a chord of 20 m), and is where the ray found it."""
    box = {"shape": "box", "length_m": 20, "width_m": 10, "height_m": 8}
    bodies = [
        point("p", 0, -900),
        {**box, "name": "a", "position_m": [150, 400, 0], "heading_deg": 30, "material": "wood"},
        {**box, "name": "b", "position_m": [-500, 200, 1], "heading_deg": 70, "material": "wood"},
        {**box, "name": "m", "position_m": [200, -300, 0], "course_deg": 200, "speed_kn": 20, "material": "wood"},
    ]
    made = scene(bodies, radar={**COARSE, "rays": 60_000})
    antenna = made.antenna(0.0)[0]
    hits = caster(made).hits(antenna, 7.0, 1e5)
    assert set(hits.body) == {1, 2, 3}
    x, y, z = hits.position.T
    outside = np.maximum(np.maximum(np.abs(x) - 5, np.abs(y) - 10), np.abs(z - 4) - 4)
    assert np.abs(outside).max() < 1e-3
    assert set(caster(made).hits(antenna, 7.0, 1e5, movers=False).body) == {1, 2}
    assert set(caster(made).hits(antenna, 7.0, 410.0).body) == {3}


def test_each_instant_has_rays_of_its_own_and_the_same_again() -> None:
    made = scene([HOUSE], radar=COARSE)
    antenna = made.antenna(0.0)[0]

    def hits(seed: int, time: float) -> RayHits:
        return caster(made, "sobol", seed).hits(antenna, time, 1e5)

    assert np.array_equal(hits(1, 2.5).position, hits(1, 2.5).position)
    assert not np.array_equal(hits(1, 2.5).position, hits(1, 2.6).position)
    assert not np.array_equal(hits(1, 2.5).position, hits(2, 2.5).position)


COAST_RADAR = {
    "range_max_m": 2600, "beamwidth_deg": 6, "beamwidth_el_deg": 8, "pulse_s": 1e-6, "azimuths": 120, "height_m": 30,
    "bandwidth_hz": 20e6, "rays": 5000,
}  # fmt: skip
SECTORS, RINGS = 20, 6  # patches of 18 degrees, three beams wide, and 430 m


@functools.cache
def coast(knots: float) -> rs.Scene:
    """The coast from own ship that goes east."""
    with tempfile.TemporaryDirectory() as folder:
        return coast_of(Path(folder), {"speed_kn": knots, "course_deg": 90})


def coast_of(folder: Path, own_ship: dict[str, Any]) -> rs.Scene:
    """Hills of a hundred facets over a slack coast, a quay before it and a hull off the quay: all diffuse."""
    x, y = np.meshgrid(np.linspace(-1500, 1500, 61), np.linspace(-1500, 1500, 61))
    hills = 40 * np.exp(-((x - 300) ** 2 + (y - 200) ** 2) / 400**2) + 25 * np.exp(
        -((x + 600) ** 2 + (y + 100) ** 2) / 250**2
    )
    np.save(folder / "land.npy", (hills - 3 + 2 * np.sin(x / 90) * np.cos(y / 70)).astype(np.float32))
    bodies = [
        {"name": "land", "heightmap": "land.npy", "extent_m": [3000, 3000], "position_m": [0, 1800, 0], "material": "land"},
        {"name": "quay", "shape": "box", "length_m": 60, "width_m": 400, "height_m": 6, "position_m": [0, 900, 0],
         "material": "concrete"},
        {"name": "hull", "shape": "hull", "length_m": 120, "beam_m": 20, "height_m": 25, "position_m": [-500, 700, 0],
         "heading_deg": 60, "scattering": "diffuse"},
    ]  # fmt: skip
    return rs.load_scene({"radar": COAST_RADAR, "body": bodies, "own_ship": own_ship}, folder=folder)


@functools.cache
def patch_energies(knots: float, sampler: Any, seeds: range) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Energy (seeds, patches) of the first scan of the coast."""
    made = coast(knots)
    fidelity = replace(PRESETS["balanced"], sampler=sampler)
    rows = []
    for seed in seeds:
        power = rs.Simulator(made, fidelity, seed).scan().power.astype(np.float64)
        bins = power.shape[1] // RINGS
        rows.append(power[:, : RINGS * bins].reshape(SECTORS, -1, RINGS, bins).sum(axis=(1, 3)).ravel())
    return np.array(rows)


@pytest.mark.parametrize(
    ("sampler", "knots", "count"),
    [
        ("rays", 0.0, 12),
        pytest.param("rays", 0.0, 24, marks=pytest.mark.study),
        pytest.param("sobol", 0.0, 24, marks=pytest.mark.study),
        pytest.param("stratified", 12.0, 24, marks=pytest.mark.study),
    ],
)
def test_both_estimators_agree_patch_by_patch(sampler: str, knots: float, count: int) -> None:
    """Mean power of every patch that counts, over so many seeds each: Welch's t of each patch as a normal deviate, their squares
    summed against chi-square at LEVEL over the tests here, and the mean over the patches likewise.

    The error of the whole is computed too, and is below 0.3 dB for 24 seeds: the test would see an error of 1.3 dB (4.4 sigma),
    and of 1.9 dB with half of them.
    """
    mine = patch_energies(knots, "scatterers", range(count))
    theirs = patch_energies(knots, sampler, range(1000, 1000 + count))
    counts = mine.mean(axis=0) > 1e-3 * mine.mean(axis=0).max()
    assert counts.sum() >= 12
    p_value = stats.ttest_ind(mine[:, counts], theirs[:, counts], equal_var=False).pvalue
    deviates = stats.norm.isf(p_value / 2)
    tests = 6  # three scenes, two tests in each
    assert stats.chi2(counts.sum()).sf(np.sum(deviates**2)) > LEVEL / tests
    alike = (mine + theirs).mean(axis=0)[counts] / 2  # so that every patch counts alike
    wholes = [(energies[:, counts] / alike).mean(axis=1) for energies in (mine, theirs)]
    assert stats.ttest_ind(*wholes, equal_var=False).pvalue > LEVEL / tests
    spread = [np.std(whole) / np.mean(whole) / np.sqrt(count) for whole in wholes]
    assert 4.34 * np.hypot(*spread) < 0.3 * np.sqrt(24 / count)  # dB; it scatters by a seventh itself, over 24 seeds


def test_rays_that_meet_what_is_one_sided_from_behind_have_no_echo() -> None:
    """A wall that faces north, with a house behind it: as land it reflects nothing to the south, but hides the house."""
    made = scene([HOUSE, {"name": "w", "shape": "plate", "width_m": 300, "height_m": 80, "position_m": [0, 250, 30],
                          "material": "wood"}], radar=COARSE)  # fmt: skip
    house, wall = made.bodies
    antenna = made.antenna(0.0)[0]
    hits = {
        sides: RayCaster([house, replace(wall, one_sided=sides)], made.radar, EARTH, "stratified", 0).hits(antenna, 0.0, 1e5)
        for sides in (False, True)
    }
    assert set(hits[False].body.tolist()) == {1} and len(hits[True]) == 0
    turned = RayCaster([house, replace(wall, one_sided=True)], made.radar, EARTH, "stratified", 0)
    assert set(turned.hits(antenna + [0.0, 800.0, 0.0], 0.0, 1e5).body.tolist()) == {0, 1}
