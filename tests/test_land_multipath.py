"""Multipath before and over land, through the whole engine: coasts, masts on smooth ground, marks afloat, and ships that pass."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import radar_service as rs
from radar_service.numerics.types import Floats
from radar_service.records.fidelity import PRESETS
from tests.reference.reflecting_ground import Piece, factor, water
from tests.scenes import point, scene

EARTH = 4 / 3 * 6_371_000.0
WIDE: dict[str, Any] = {"azimuths": 8, "beamwidth_deg": 60, "beamwidth_el_deg": 180, "height_m": 15.0, "pulse_s": 2.5e-7}
UNDER_WAY = {"speed_kn": 8.0, "course_deg": 90.0}
CONCRETE = (5.24, 0.02)  # permittivity, rms height [m]
FEW = replace(PRESETS["balanced"], min_scatterers=2000)


def land(begin: float, end: float, up: float, material: str = "land", **more: Any) -> dict[str, Any]:
    """Land of one height to the north, 400 m wide, between two distances [m]."""
    size = {"length_m": end - begin, "width_m": 400.0, "height_m": up}
    return {"name": "land", "shape": "box", "material": material, "position_m": [0, (begin + end) / 2, 0], **size, **more}


def multipath_db(
    bodies: list[dict[str, Any]], between: list[tuple[float, float]], own_ship: dict[str, Any] | None = None,
    radar: dict[str, Any] | None = None, **air: Any,
) -> Floats:  # fmt: skip
    """Power of a scan with multipath over that without [dB], in parts of the range [m]."""
    power = []
    for multipath in (True, False):
        settings, environment = {**WIDE, "range_max_m": 4500, **(radar or {})}, {"multipath": multipath, **air}
        made = scene(bodies, radar=settings, own_ship=own_ship or {}, environment=environment)
        field = rs.Simulator(made, FEW, seed=2).scan().field.astype(complex)
        cell = made.radar.range_step * (np.arange(field.shape[1]) + 0.5)
        power.append([np.sum(np.abs(field[:, (cell >= low) & (cell < high)]) ** 2) for low, high in between])
    return np.asarray(10.0 * np.log10(np.array(power[0]) / power[1]))


@pytest.mark.parametrize("own_ship", [{}, UNDER_WAY])
def test_land_has_no_lobes_of_a_sea_that_is_not_there(own_ship: dict[str, Any]) -> None:
    """Land of 4 m, its coast 1.7 km off: from 2.15 km on all of it has its point of reflection on land. There it has by rings of
    250 m what it has without multipath (0.01 dB: sidelobes of the pulse); a sea would add up to 11.5 dB and take up to 28.
    Before, the sea reflects: between 1.8 and 2 km it takes 1 to 12 dB."""
    rings = [(edge, edge + 250.0) for edge in np.arange(2200.0, 4200.0, 250.0).tolist()]
    *over_land, by_sea = multipath_db([land(1700.0, 5000.0, 4.0)], [*rings, (1800.0, 2000.0)], own_ship)
    assert np.abs(over_land).max() < 0.01 and -12.0 < by_sea < -1.0


@pytest.mark.parametrize(("plates", "own_ship"), [(False, {}), (True, {}), (False, {"speed_kn": 0.5, "course_deg": 90.0})])
def test_smooth_ground_has_the_lobes_of_its_closed_form_under_a_mast(plates: bool, own_ship: dict[str, Any]) -> None:
    """A mast 15 m over concrete that is 3 m above the sea, and marks and steel plates 6 m over it: points to 0.002 dB (mask and
    field are single precision; 0.02 dB under way at 0.5 knots, 0.6 m aside), plates of 0.2 m to 0.2 dB where the lobe is not
    within 12 dB of a null, which their height fills. Those of the plane of the sea are up to 30 dB away."""
    distances = [800.0, 900.0, 1000.0, 1300.0, 1500.0, 1900.0]
    size = {"shape": "box", "length_m": 0.2, "width_m": 0.2, "height_m": 0.2, "material": "steel", "scattering": "optics"}
    marks = [
        {"name": f"plate {d}", "position_m": [0, d, 8.9], **size} if plates else point(f"mark {d}", 0, d, 9.0)
        for d in distances
    ]
    apron = land(-50.0, 3000.0, 3.0, "concrete", rcs_dbsm=-90)  # of its own it has no echo
    measured = multipath_db(
        [apron, *marks], [(d - 8.0, d + 8.0) for d in distances], own_ship, radar={"height_m": 18.0, "range_max_m": 2200}
    )
    ground = [Piece(3000.0, 3.0, *CONCRETE)]
    expected = np.array([40.0 * np.log10(abs(factor(d, 9.0, 18.0, ground, EARTH))) for d in distances])
    clear = expected > -12.0 if plates else np.ones(6, dtype=np.bool_)
    np.testing.assert_allclose(measured[clear], expected[clear], atol=0.2 if plates else 0.02 if own_ship else 0.002)
    assert expected.min() < -18.0 and expected.max() > 10.0


@pytest.mark.parametrize("own_ship", [{}, UNDER_WAY])
@pytest.mark.parametrize("earth", ["4/3", "flat"])
def test_a_buoy_before_the_coast_keeps_its_lobes(own_ship: dict[str, Any], earth: str) -> None:
    """F^4 of buoys 3 m high, up to 20 m before a coast, at rest and as own ship passes, is that of the sea within 0.1 dB."""
    distances = [900.0, 1200.0, 1450.0, 1680.0]
    buoys = [point(f"buoy {d}", 0, d, 3.0, 20.0) for d in distances]
    coast = land(1700.0, 2500.0, 4.0, rcs_dbsm=-90)
    measured = multipath_db([coast, *buoys], [(d - 8.0, d + 8.0) for d in distances], own_ship, earth=earth)
    radius = EARTH if earth == "4/3" else np.inf
    expected = [40.0 * np.log10(abs(factor(d, 3.0, 15.0, [water(1e4)], radius))) for d in distances]
    np.testing.assert_allclose(measured, expected, atol=0.1)


def test_a_racon_ashore_has_its_own_reflection() -> None:
    """Its answer over the concrete of a mole has F^2 of that ground, that of vegetation none, each way."""
    power = {}
    for material in ("concrete", "vegetation", "none"):
        racon = point("racon", 0, 1300, 9.0, -30.0, racon={"letter": "K"})
        bodies = [racon] if material == "none" else [racon, land(-50.0, 3000.0, 3.0, material, rcs_dbsm=-90)]
        air = {"multipath": material != "none"}
        made = scene(bodies, radar={**WIDE, "height_m": 18.0, "range_max_m": 3000, "modulation": "none"}, environment=air)
        field = rs.Simulator(made, FEW, seed=2).scan().field
        power[material] = float(np.sum(np.abs(field.astype(complex)) ** 2))
    lobe = 20.0 * np.log10(abs(factor(1300.0, 9.0, 18.0, [Piece(3000.0, 3.0, *CONCRETE)], EARTH)))
    measured = 10.0 * np.log10(np.array([power["concrete"], power["vegetation"]]) / power["none"])
    np.testing.assert_allclose(measured, [lobe, 0.0], atol=0.01)


@pytest.mark.parametrize("material", ["vegetation", "concrete"])
def test_a_mover_has_the_reflection_of_where_its_point_is(material: str) -> None:
    """A launch 5 m high at 15 m/s, 1200 m off, before which land of 0.5 m ends at its way: as long as the point of reflection is
    on land it has the lobes of that land, none of vegetation, and on water those of the sea: at each scan, within 0.02 dB (a
    block of azimuths, 8 cm of way)."""
    size = {"shape": "box", "length_m": 700.0, "width_m": 400.0, "height_m": 0.5, "material": material, "rcs_dbsm": -90}
    before = {"name": "land", "position_m": [-200.0, 700.0, 0.0], **size}
    launch = point("launch", -18.0, 1200.0, 5.0, 20.0, speed_kn=30, course_deg=90)
    power = []
    for multipath in (True, False):
        made = scene([before, launch], radar={**WIDE, "rpm": 60, "range_max_m": 1300}, environment={"multipath": multipath})
        sim = rs.Simulator(made, FEW)
        power.append([np.abs(sim.scan().field[0].astype(complex)).max() ** 2 for _ in range(4)])
    ground = Piece(1e4, 0.5, *(CONCRETE if material == "concrete" else (0.0, 0.0)))
    reflects = [ground, ground, water(1e4), water(1e4)]
    distances = np.hypot(1200.0, -18.0 + 30.0 * 1852.0 / 3600.0 * np.arange(4)).tolist()
    lobes = [40.0 * np.log10(abs(factor(d, 5.0, 15.0, [at], EARTH))) for d, at in zip(distances, reflects, strict=True)]
    np.testing.assert_allclose(10.0 * np.log10(np.divide(*power)), lobes, atol=0.02)
    assert abs(lobes[1] - lobes[2]) > 3.0


def test_each_azimuth_has_the_reflection_where_own_ship_turns_short() -> None:
    """At a corner of own ship's course echoes are exact at each azimuth: a mark over concrete 1 km north of the corner has the
    lobe of the ground there, one over vegetation none, within 0.02 dB."""
    corner = {"waypoints": [{"position_m": [15.9, 0], "speed_kn": 30}, {"position_m": [15.9, -300], "speed_kn": 30}]}
    size = {"shape": "box", "length_m": 900.0, "width_m": 200.0, "height_m": 0.5, "rcs_dbsm": -90}
    measured = []
    for material in ("concrete", "vegetation"):
        shore = {"name": "shore", "material": material, "position_m": [0.0, 550.0, 0.0], **size}
        fields = []
        for multipath in (True, False):
            made = scene(
                [shore, point("mark", 15.9, 1000.0, 4.5, 20.0)],
                radar={**WIDE, "azimuths": 128, "rpm": 60, "range_max_m": 1200},
                own_ship=corner, environment={"multipath": multipath},
            )  # fmt: skip
            sim = rs.Simulator(made, FEW)
            sim.skip_to(1)
            fields.append(np.abs(sim.scan().field[4].astype(complex)).max())  # 1.031 s: it turned at 1.030 s
        measured.append(20.0 * np.log10(fields[0] / fields[1]))
    lobe = 40.0 * np.log10(abs(factor(1000.0, 4.5, 15.0, [Piece(1e4, 0.5, *CONCRETE)], EARTH)))
    np.testing.assert_allclose(measured, [lobe, 0.0], atol=0.02)
    assert abs(lobe) > 1.0
