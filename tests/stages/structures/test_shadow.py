"""The pattern past structures against elements summed one by one, behind a black strip and beside a metal cylinder."""

import numpy as np
import pytest

from radar_service.numerics.types import Complexes, Floats
from radar_service.radar.aperture import ChangedPattern, aperture_of
from radar_service.radar.patterns import PATTERNS
from radar_service.stages.registry import changed_pattern
from radar_service.stages.structures.structure import Structure, TakenTable
from tests.reference.cylinder_shadow import elements, past_cylinder, past_strip, received
from tests.scenes import radar

WAVELENGTH, BEAMWIDTH = 0.03186, np.radians(0.95)
WEIGHTS = {"sinc2": {0.0: 1.0}, "cosine": {0.5: 1.0}}  # of cosines by cycles
MAST, FUNNEL = Structure("mast", 0.3, 2.5, 0.15), Structure("funnel", 0.3, 10.0, 1.5)
ASIDES = np.radians([-25.0, -8.9, -3.0, 2.0, 9.0])
OFFSETS = np.radians([0.0, -1.3, 6.0])


def shadow_of(pattern: str, *structures: Structure) -> ChangedPattern:
    aperture = aperture_of(PATTERNS[pattern], BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    return ChangedPattern(
        aperture, WAVELENGTH, [TakenTable(each, aperture, WAVELENGTH, 10.0 * BEAMWIDTH) for each in structures]
    )


def fields(
    pattern: str, structure: Structure, asides: Floats, offsets: Floats, polarization: str = ""
) -> tuple[Complexes, Complexes]:
    """One-way fields by the tables and by elements, for all asides and offsets; polarization: "" for the black strip."""
    aperture = aperture_of(PATTERNS[pattern], BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    slow = []
    for target in structure.bearing + asides:
        for offset in offsets:
            points, along = elements(aperture.length, 100, target - offset)
            taken = target, structure.bearing, structure.distance, structure.radius, points, WAVELENGTH
            field = past_cylinder(*taken, polarization) if polarization else past_strip(*taken)
            slow.append(received(field, along, aperture.length, WEIGHTS[pattern]))
    from_bow, offset = np.meshgrid(structure.bearing + asides, offsets, indexing="ij")
    return shadow_of(pattern, structure).one_way(from_bow, offset).ravel(), np.array(slow)


@pytest.mark.sample(2)
@pytest.mark.parametrize("pattern", ["sinc2", "cosine"])
@pytest.mark.parametrize("structure", [MAST, FUNNEL], ids=lambda structure: structure.name)
def test_shadows_are_those_of_a_black_strip(structure: Structure, pattern: str) -> None:
    """Over boresight -54 dB: small angles, the offset's cosine 6 degrees off, and linear interpolation (-60 dB)."""
    table, slow = fields(pattern, structure, ASIDES, OFFSETS)
    assert 20.0 * np.log10(np.abs(table - slow).max()) < -54.0


@pytest.mark.sample(2)
@pytest.mark.parametrize("polarization", ["h", "v"])
@pytest.mark.parametrize("structure", [MAST, FUNNEL], ids=lambda structure: structure.name)
def test_shadows_are_nearly_those_of_a_metal_cylinder(structure: Structure, polarization: str) -> None:
    """A black strip has no polarization: what creeps around metal is 0.45 dB two ways where less than 12 dB are lost."""
    table, slow = fields("cosine", structure, np.radians([-14.0, -10.0, 9.0, 11.0]), np.zeros(1), polarization)
    assert 40.0 * np.log10(np.abs(slow).min()) > -12.0
    assert np.abs(40.0 * np.log10(np.abs(table / slow))).max() < 0.45


def test_a_mast_takes_its_share_of_the_aperture() -> None:
    """Within the shadow of a thin mast the field is 1 less the illumination there times width over length (a ray's view)."""
    aperture = aperture_of(PATTERNS["cosine"], BEAMWIDTH, WAVELENGTH)
    assert aperture is not None
    mast = Structure("mast", 0.0, 2.5, 0.2)
    one_way = shadow_of("cosine", mast).one_way(np.zeros(1), np.zeros(1))[0]
    share = np.sin(np.pi / 2.0 * 0.4 / aperture.length)  # of a cosine, about its middle
    assert abs(one_way) == pytest.approx(1.0 - share, abs=0.02)  # edges err by a tenth of a Fresnel unit each, 0.02 of D


def test_sidelobes_rise_beside_a_mast() -> None:
    """3 degrees off boresight, behind a mast, a Taylor pattern rises from below -30 to above -21 dB."""
    offset = np.radians([3.0])
    assert abs(shadow_of("taylor", MAST).one_way(np.array([MAST.bearing + 1.5]), offset)[0]) < 10.0 ** (-30 / 20)
    beside = np.abs(shadow_of("taylor", MAST).one_way(np.full(9, MAST.bearing), np.radians(np.linspace(2.5, 3.5, 9))))
    assert beside.max() > 10.0 ** (-21 / 20)


def test_two_structures_take_each_their_part() -> None:
    other = Structure("post", 2.5, 4.0, 0.05)
    both = shadow_of("taylor", MAST, other)
    for structure in (MAST, other):
        from_bow = structure.bearing + np.radians([-3.0, 0.0, 20.0])
        alone = shadow_of("taylor", structure).one_way(from_bow, np.full(3, 0.004))
        np.testing.assert_allclose(both.one_way(from_bow + 2.0 * np.pi, np.full(3, 0.004)), alone, atol=1e-6)


def test_clutter_is_the_beam_to_the_fourth_summed() -> None:
    """Behind the edge of a funnel, against a finer sum over all directions (to the interpolation of a smooth edge, 2 %)."""
    shadow, boresight = shadow_of("cosine", FUNNEL), FUNNEL.bearing + np.radians([-9.5, -8.0, 0.0, 40.0])
    offset = np.linspace(-0.15, 0.15, 6001)
    field = shadow.one_way(boresight[:, None] + offset, np.broadcast_to(offset, (4, len(offset))))
    without = PATTERNS["cosine"].gain(offset, BEAMWIDTH) ** 2
    expected = (np.abs(field) ** 4).sum(axis=1) / without.sum()
    np.testing.assert_allclose(shadow.clutter_power(boresight - 2.0 * np.pi), expected, rtol=0.02, atol=1e-4)
    assert expected[0] > 0.1 and expected[2] < 1e-4


def test_a_radar_without_structures_has_no_shadow() -> None:
    assert changed_pattern(radar()) is None
    structure = [{"bearing_deg": 0, "distance_m": 3, "width_m": 0.2}]
    assert changed_pattern(radar(structure=structure)) is changed_pattern(radar(structure=structure, tilt_deg=1))


def test_what_changes_is_the_difference_to_the_plain_beam() -> None:
    """Two ways, with all that a structure reaches; nothing where it does not. 3e-6: of the table of the pattern, two ways."""
    shadow, from_bow = shadow_of("taylor", MAST), MAST.bearing + np.radians([0.0, 20.0, 120.0])
    offset = np.radians([0.2, -1.0, 0.4])
    plain = PATTERNS["taylor"].gain(offset, BEAMWIDTH)
    np.testing.assert_allclose(
        shadow.two_way_change(from_bow, offset), shadow.one_way(from_bow, offset) ** 2 - plain, atol=3e-6
    )
    assert shadow.reaches(from_bow).tolist() == [True, True, False]
    assert shadow.two_way_change(from_bow, offset)[2] == 0.0 and shadow.extent == pytest.approx(10.0 * BEAMWIDTH)
