"""Ray tubes: echoes hold while the antenna moves a little, as the range of their points changes like that of the paths."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from radar_service.scattering.physical_optics.facets import areas
from radar_service.scattering.physical_optics.optical_body import OpticalBody
from radar_service.scattering.physical_optics.path_fields import PathFields, tube_fields
from radar_service.scattering.physical_optics.ray_tubes import RayTubes, launched_tubes
from radar_service.scattering.physical_optics.tube_tracing import Ends, hits
from tests.reference.make_ships import coaster
from tests.reference.tube_witness import Trace, Tubes, moved
from tests.scattering.physical_optics.meshes import (
    ODD,
    dihedral,
    direct,
    echoes_toward,
    loaded,
    optical,
    plate,
    toward,
    trihedral,
)

Floats = NDArray[np.float64]
SMALLEST = 0.02  # m; tubes are not divided below it


def field(body: OpticalBody, evaluated_at: Floats, received_at: Floats) -> complex:
    """The field at one position of the antenna of echoes that were evaluated for another."""
    point, amplitude = echoes_toward(body, evaluated_at)
    return complex(np.sum(amplitude * np.exp(-2j * body.wave.wavenumber * np.linalg.norm(point - received_at, axis=1))))


def started(body: OpticalBody, antenna: Floats) -> RayTubes:
    """Tubes at their first surface, which count wherever they end."""
    leg = direct(body, antenna)
    return launched_tubes(body.lit_facets((leg,), -np.inf)[0], [leg], "h", body.planes, body.rank, [True])


def bounced(body: OpticalBody, antenna: Floats, bounces: int) -> list[tuple[RayTubes, PathFields]]:
    """Tubes at their second surface and beyond that scatter back, and what they scatter."""
    faces = len(body.mesh.faces)
    ends = Ends(body.mesh, np.ones(faces, dtype=np.bool_), body.rank, np.full(faces, SMALLEST))
    result = []
    for tube in hits(started(body, antenna), body.planes, body.scene, bounces, ends):
        which, fields = tube_fields(tube, direct(body, antenna), body.wave)
        result.append((tube.chosen(which), fields))
    return result


def footprints(tubes: RayTubes) -> Floats:
    """Areas (M,) [m^2]."""
    return areas(tubes.corners.transpose(2, 0, 1))


@pytest.mark.parametrize("move", [[2.0, -1.0, 0.5], [-3.0, 2.0, 0.0], [0.3, 0.0, -2.0]])
@pytest.mark.parametrize("name", ["trihedral", "dihedral", "plate"])
def test_moving_the_antenna_a_little_is_a_full_recomputation(tmp_path: Path, name: str, move: list[float]) -> None:
    """Up to 3.6 m at 1000 m turn the aspect by 3.6 mrad: corners hardly change (2 %: lobes of their single bounces,
    tubes at the edge), a plate of 0.3 m changes by its lobe, (k a theta)^2 / 24 at most, 1 %. In phase: 2 % of 3 m
    would be 24 rad."""
    mesh = {"trihedral": trihedral(0.6, 1, True), "dihedral": dihedral(0.6, 0.3, 1), "plate": plate(0.3, 0.3, 1)}[name]
    direction = {"trihedral": [1, 0.9, 1.1], "dihedral": [1, 1.2, 0.0], "plate": [0, 1, 0]}[name]
    body = optical(loaded(tmp_path, mesh @ ODD.T))
    here = ODD @ toward(direction, 1000)
    there = here + np.array(move)
    assert abs(field(body, here, there) / field(body, there, there) - 1) < 0.03


def test_points_where_paths_end_would_not_do(tmp_path: Path) -> None:
    """The same with each path's whole phase put on the place of its last bounce: 9 m aside at 1000 m a corner of 0.6 m falls
    apart, since its tubes enter and leave up to a metre from one another."""
    body = optical(loaded(tmp_path, trihedral(0.6, 1, True)))
    here = toward([1, 1, 1], 1000)
    there = here + np.array([6.4, -6.4, 0.0])
    exact = field(body, there, there)
    k, ends = body.wave.wavenumber, field(optical(loaded(tmp_path, trihedral(0.6, 1, True)), 1), there, there)
    for tubes, fields in bounced(body, here, 3):
        end = np.linalg.norm(tubes.centre.T - here, axis=1)
        assert len(end) == len(fields.amplitude)  # all of them are visible
        ends += np.sum(fields.amplitude * np.exp(-2j * k * (np.linalg.norm(tubes.centre.T - there, axis=1) - end)))
    assert abs(field(body, here, there) / exact - 1) < 0.03
    assert abs(ends / exact - 1) > 0.2


def test_a_corner_reflects_from_its_apex(tmp_path: Path) -> None:
    """However its rays run, the path through a corner is that to its apex and back: there stand the points of all tubes that
    bounced three times, to 3 cm (the lines of sight to two ends 0.6 m apart differ by 0.6 mrad, across 1 m:
    0.6 mm; halves of a tube of 10 cm begin a little aside)."""
    body = optical(loaded(tmp_path, trihedral(0.6, 1, True)))
    here = toward([1, 0.9, 1.1], 1000)
    _, (_, thrice) = bounced(body, here, 3)
    point = thrice.position
    assert len(point) > 30
    assert np.linalg.norm(point, axis=1).max() < 0.03


def test_a_ship_lasts_while_the_beam_passes(tmp_path: Path) -> None:
    """A coaster at 1000 m, the antenna 0.1 m aside (14 kn for the 14 ms of a 2-degree beam): 3 % of the field, mostly of the
    centres' cells of 2 m, k cell d / 2 = 0.02 rad each."""
    body = optical(loaded(tmp_path, coaster()))
    here = np.array([800.0, 600.0, 20.0])
    there = here + np.array([-0.06, 0.08, 0.0])
    assert abs(field(body, here, there) / field(body, there, there) - 1) < 0.05


def test_paths_run_either_way(tmp_path: Path) -> None:
    """Reciprocity: through a dihedral of unlike plates, what enters by one and leaves by the other is the same the other way
    round, in strength and phase, to 3 % (the ragged edge of tubes)."""
    mesh = np.concatenate([dihedral(0.6, 0.5, 1)[:2], 0.5 * dihedral(0.6, 1.0, 1)[2:]])
    body = optical(loaded(tmp_path, mesh))
    here = toward([1, 0.8, 0.0], 2000)
    ((twice, fields),) = bounced(body, here, 2)
    turned = fields.amplitude
    last_is_first = np.isin(twice.triangle, twice.triangle[:1])
    plane = np.abs(twice.normal[1]) > 0.5
    assert last_is_first.any() and plane.any() and (~plane).any()
    one, other = turned[plane].sum(), turned[~plane].sum()
    assert abs(one / other - 1) < 0.03


def test_halves_carry_on_the_wave(tmp_path: Path) -> None:
    """A tube's half has the way and the direction of its own centre, to third order: 1e-6 m and 1e-6 rad at 500 m."""
    body = optical(loaded(tmp_path, dihedral(0.6, 0.5, 1)))
    antenna = toward([1, 0.8, 0.3], 500)
    tubes = started(body, antenna)
    every, launch, (a, b, c) = np.arange(len(tubes)), tubes.launch, tubes.corners
    columns = tubes.corners, tubes.centre, tubes.normal, tubes.direction, tubes.begin, tubes.length
    known = {
        "field": tubes.field,
        "launched": every,
        "out": launch.direction,
        "out_field": launch.field,
        "bounces": 0 * every,
    }
    halves = np.concatenate([np.stack([a, (a + b) / 2.0, c]), np.stack([(a + b) / 2.0, b, c])], axis=2)  # not reflected yet
    both = moved(Trace(known, lambda *_: every), Tubes(every, tubes.triangle, *columns).chosen(np.tile(every, 2)), halves)
    line = both.centre.T - antenna
    length = np.linalg.norm(line, axis=1)
    np.testing.assert_allclose(both.length, length, atol=1e-6)
    np.testing.assert_allclose(both.direction.T, line / length[:, None], atol=1e-6)
    aside = both.begin.T - antenna
    np.testing.assert_allclose(np.cross(aside / length[:, None], both.direction.T), 0.0, atol=1e-6)
    assert areas(both.corners.transpose(2, 0, 1)).sum() == pytest.approx(footprints(tubes).sum())
