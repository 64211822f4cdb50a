"""Metal over the sea near the horizon and beyond: against points, and against sums over heights with a field of its own."""

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import radar_service as rs
from radar_service.propagation.sea_surface import sea_water_permittivity
from radar_service.scattering.physical_optics import body_legs
from tests.propagation.test_diffraction import units
from tests.reference.smooth_sea import EARTH, LIGHT, contour_field
from tests.scenes import point, scene

Complexes = NDArray[np.complex128]
Floats = NDArray[np.float64]

SEA, FREE = {"multipath": True, "diffraction": True}, {"earth": "flat"}
RADAR = {
    "azimuths": 64, "beamwidth_deg": 12, "beamwidth_el_deg": 90, "height_m": 15, "range_max_m": 45_000,
    "modulation": "none", "pulse_s": 2e-6, "sample_rate_hz": 1e6, "rpm": 60,
}  # fmt: skip
WAVENUMBER = 2.0 * np.pi * 9.41e9 / LIGHT


def peak_db(body: dict[str, Any], environment: dict[str, Any], **radar: Any) -> float:
    """The strongest sample of a scan of one body [dB]."""
    made = scene([body], radar={**RADAR, **radar}, environment=environment)
    return float(10.0 * np.log10(rs.Simulator(made, "balanced").scan().power.max()))


def metal(shape: str, distance: float, height: float, **sizes: float) -> dict[str, Any]:
    """A body that faces the radar; plates by their middle, corners by their apex."""
    place = {"position_m": [0, distance, height], "heading_deg": 180}
    return {"name": "metal", "shape": shape, "scattering": "optics", **place, **sizes}


def field(distance: float, height: Floats) -> Complexes:
    """One-way field at heights (N,) over that of the direct ray, by a contour integral (horizontal polarization)."""
    along, up, m = units(9.41e9)
    q = 1j * m * np.sqrt(np.conj(sea_water_permittivity(9.41e9)) - 1.0)
    return np.array([contour_field(distance / along, 15.0 / up, each / up, q) for each in height.tolist()])


@pytest.mark.sample(5)
@pytest.mark.parametrize("height", [2.0, 6.0, 20.0])
@pytest.mark.parametrize("distance", [9_000.0, 15_000.0, 20_000.0, 27_000.0, 40_000.0])
def test_a_small_corner_follows_the_horizon_like_a_point(distance: float, height: float) -> None:
    """Over what both have in empty space, within 0.1 dB up to -140 dB: the corner spans 0.4 m of height, over which |F|^4 of a
    point 2 m high changes by 1 % of its mean, and points lie on range samples alike. Before, metal had no echo beyond 21 km."""
    corner, buoy = metal("trihedral", distance, height, edge_m=0.4), point("metal", 0.0, distance, height)
    over_sea, free = (peak_db(corner, each) - peak_db(buoy, each) for each in (SEA, FREE))
    assert over_sea == pytest.approx(free, abs=0.1)


@pytest.mark.sample(4)
@pytest.mark.parametrize(("low", "high"), [(0.0, 3.0), (1.0, 3.0), (0.0, 12.0)])
@pytest.mark.parametrize("distance", [12_000.0, 13_500.0, 30_000.0])
def test_a_wall_on_the_sea_has_the_mean_of_the_squared_field_over_its_height(
    distance: float, low: float, high: float
) -> None:
    """Each strip of a plate counts by F^2 and the phase of its distance (Gauss and Legendre). Within 0.05 dB: facets linear over
    a twelfth of the height err by 0.7 % in F^2, and the profile by 0.1 %."""
    place, weight = np.polynomial.legendre.leggauss(12)
    height = low + (place + 1.0) / 2.0 * (high - low)
    fields = [field(distance, height) ** 2, np.ones(12)]
    drops = [distance**2 / (2.0 * EARTH), 0.0]
    ways = [np.hypot(distance, height - 15.0 - drop) for drop in drops]
    over, free = (abs(weight @ (f * np.exp(-2j * WAVENUMBER * (way - way[0])))) for f, way in zip(fields, ways, strict=True))
    wall = metal("plate", distance, (low + high) / 2.0, width_m=16.0, height_m=high - low)
    found = peak_db(wall, SEA) - peak_db(wall, FREE)
    assert found == pytest.approx(20.0 * np.log10(over / free), abs=0.05)


def test_a_ray_that_bounces_has_the_field_where_it_comes_in_times_that_where_it_goes_out() -> None:
    """What enters a corner on one side of its apex leaves it opposite: the mean of F(z + u) F(z - u) over its aperture, the part
    of its outline that is alike turned about the apex. F^2 at the apex would be 1.0 dB too strong. Within 0.1 dB."""
    distance, apex, edge = 24_000.0, 1.4, 1.6
    across, down = edge * np.sqrt(2.0) / 2.0, edge / np.sqrt(6.0)
    u, v = np.meshgrid(np.linspace(-1, 1, 401) * across, np.linspace(-1, 1, 401) * 2.0 * down)
    tips = np.array([[0.0, 2.0 * down], [across, -down], [-across, -down]])  # as seen along the axis of symmetry

    def inside(x: Floats, y: Floats) -> NDArray[np.bool_]:
        sides = [(tips[k], tips[(k + 1) % 3]) for k in range(3)]
        return np.all([(b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]) <= 0.0 for a, b in sides], axis=0)

    heights = v[inside(u, v) & inside(-u, -v)]
    grid = np.linspace(0.0, apex + 2.0 * down, 12)
    at = np.polynomial.Polynomial.fit(grid, field(distance, grid), 8)
    expected = abs(np.mean(at(apex + heights) * at(apex - heights)))
    corner = metal("trihedral", distance, apex, edge_m=edge)
    found = peak_db(corner, SEA) - peak_db(corner, FREE)
    assert found == pytest.approx(20.0 * np.log10(expected), abs=0.1)
    assert abs(20.0 * np.log10(abs(at(apex)) ** 2 / expected)) > 0.5


@pytest.mark.parametrize("distance", [8_000.0, 13_500.0, 26_000.0])
def test_metal_that_creeps_has_the_echo_of_metal_at_rest(distance: float) -> None:
    """At 1 mm/s, in single precision and the table of the beam: 0.02 dB."""
    box = metal("box", distance, 0.0, length_m=6.0, width_m=3.0, height_m=3.0)
    creeping = box | {"course_deg": 180, "speed_kn": 0.002}
    assert peak_db(creeping, SEA) == pytest.approx(peak_db(box, SEA), abs=0.02)


def test_metal_changes_little_where_one_leg_begins_to_stand_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both ways at the distance of the change: a box and a hull off their flashes. Measured: 0.01 of the field, on hulls of 30 m
    0.07, as the sea's ray does not light their decks; here 0.02."""
    slope, drop = body_legs.ONE_LEG / units(9.41e9)[2], 1.0 / EARTH
    distance = (np.sqrt(slope**2 + 2.0 * 15.0 * drop) - slope) / drop
    bodies = [
        metal("box", distance, 0.0, length_m=12.0, width_m=6.0, height_m=6.0) | {"heading_deg": 25},
        metal("hull", distance, 0.0, length_m=30.0, beam_m=8.0, height_m=6.0) | {"heading_deg": 80},
    ]
    for body in bodies:
        fields = []
        for limit in (0.45, 0.55):
            monkeypatch.setattr(body_legs, "ONE_LEG", limit)
            fields.append(rs.Simulator(scene([body], radar=RADAR, environment=SEA), "balanced").scan().field)
        assert 0.0 < np.abs(fields[0] - fields[1]).max() < 0.02 * np.abs(fields[0]).max()


@pytest.mark.parametrize("distance", [5_000.0, 12_000.0])
def test_without_diffraction_and_before_it_counts_metal_keeps_its_bytes(distance: float) -> None:
    """At 5 km both rays alone reach a box; at 12 km the ray by the sea is another one."""
    box = metal("box", distance, 0.0, length_m=20.0, width_m=20.0, height_m=6.0)
    fields = [rs.Simulator(scene([box], radar=RADAR, environment=each)).scan().field for each in (SEA, {"multipath": True})]
    assert np.abs(fields[0]).max() > 0.0
    assert (fields[0].tobytes() == fields[1].tobytes()) == (distance == 5_000.0)
