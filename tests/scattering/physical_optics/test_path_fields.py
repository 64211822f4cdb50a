"""Fields from one leg into another: bistatic plates by closed form, and both orders of a mixed path."""

import numpy as np
import pytest

from radar_service.scattering.physical_optics.body_legs import BodyLeg
from radar_service.scattering.physical_optics.path_fields import facet_fields, facet_phases
from radar_service.world.poses import MAP_POSE
from tests.scattering.physical_optics.meshes import WAVELENGTH, optical
from tests.scenes import scene

PLATE = {"name": "p", "shape": "plate", "width_m": 0.5, "height_m": 0.3, "scattering": "optics", "position_m": [0, 900, 5]}


def seen(points: np.ndarray, triangle: np.ndarray) -> np.ndarray:
    return np.ones(len(points), dtype=np.bool_)


@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize(("incident", "scattered"), [(20, -20), (20, -21.5), (35, -30), (50, -49), (10, 5), (-3, 60)])
def test_a_bistatic_plate_follows_the_closed_form(polarization: str, incident: float, scattered: float) -> None:
    """4 pi A^2 / lambda^2 sinc^2(k a (sin i + sin s) / 2) times the obliquity: cos i where the field is along the plate's edge,
    v, and cos s where it lies in the plane of both directions, h (Balanis 2012, section 11.3); both orders add up. At 4 km
    path errors of k a^2 / 8 R are 1.5 mrad; 1 % of the peak."""
    body = optical(scene([PLATE], radar={"polarization": polarization}))
    middle = body.mesh.vertices.mean(axis=0)
    angles = np.deg2rad([incident, scattered])
    antennas = [middle + 4000.0 * np.array([np.sin(a), np.cos(a), 0.0]) for a in angles]
    legs = tuple(BodyLeg(False, MAP_POSE, antenna, np.inf, seen) for antenna in antennas)
    _, lit = body.lit_facets(legs, -np.inf)
    fields = facet_fields(lit, facet_phases(lit, body.wave), 0, 1, body.wave)
    result = fields.sum()
    peak = np.sqrt(4 * np.pi) * 0.15 / WAVELENGTH
    expected = peak * np.cos(angles).sum() * np.sinc(0.5 * np.sin(angles).sum() / WAVELENGTH)
    assert abs(result) == pytest.approx(abs(expected), abs=0.01 * peak)


def test_a_field_is_what_its_corners_share() -> None:
    """The first moment of a plate's field, seen from its normal, lies at its middle; a point is there once for all facets."""
    body = optical(scene([PLATE]))
    middle = body.mesh.vertices.mean(axis=0)
    leg = BodyLeg(False, MAP_POSE, middle + [0.0, 4000.0, 0.0], np.inf, seen)
    surface, lit = body.lit_facets((leg,), -np.inf)
    fields = facet_fields(lit, facet_phases(lit, body.wave), 0, 0, body.wave)
    assert len(fields) == len(np.unique(lit.points, axis=0)) < lit.corner.size
    np.testing.assert_allclose(((fields @ lit.points) / fields.sum()).real, middle, atol=1e-4)
