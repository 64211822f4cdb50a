"""The kernel that follows ray tubes against numpy, and what it does where rays fail."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from radar_service.kernels.library import RAY_CALL
from radar_service.scattering.physical_optics import tube_tracing
from radar_service.scattering.physical_optics.lit_facets import Surface
from radar_service.scattering.physical_optics.optical_body import OpticalBody
from radar_service.scattering.physical_optics.path_fields import Wave, received_fields
from radar_service.scattering.physical_optics.ray_tubes import RayTubes, launched_tubes
from radar_service.scattering.physical_optics.tube_tracing import Ends, hits
from radar_service.trace.embree import TriangleScene
from tests.kernels.both import both
from tests.scattering.physical_optics.meshes import dihedral, direct, loaded, optical, toward, trihedral
from tests.scattering.physical_optics.test_ray_tubes import SMALLEST

COARSE = trihedral(0.6, 1, True)
UNEQUAL = np.concatenate([dihedral(0.6, 0.5, 1)[:2], 0.37 * dihedral(0.6, 0.5 / 0.37, 1)[2:]])
HERE = toward([1, 0.9, 1.1], 200)


def launched(body: OpticalBody, polarization: str = "h", every: bool = True) -> RayTubes:
    leg = direct(body, HERE)
    surface: Surface = body.lit_facets((leg,), -np.inf)[0]
    return launched_tubes(surface, [leg], polarization, body.planes, body.rank, [every])


def ends_on(body: OpticalBody, smallest: float, lit: bool = True) -> Ends:
    faces = len(body.mesh.faces)
    return Ends(body.mesh, np.full(faces, lit), body.rank, np.full(faces, smallest))


def assert_same(compiled: list[RayTubes], by_numpy: list[RayTubes]) -> None:
    assert len(compiled) == len(by_numpy)
    for one, other in zip(compiled, by_numpy, strict=True):
        for name in ("launched", "triangle", "bounces", "chain"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)
        for name in ("corners", "centre", "normal", "direction", "field", "length", "begin", "first_length"):
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-12, atol=1e-12, err_msg=name)


@pytest.mark.parametrize("lean", [None, 0.3], ids=["upright", "leaning"])
@pytest.mark.parametrize("every", [True, False], ids=["every tube counts", "by rank"])
@pytest.mark.parametrize("smallest", [SMALLEST, 0.05, 9.0], ids=["fine", "coarse", "undivided"])
@pytest.mark.parametrize("triangles", [COARSE, UNEQUAL, trihedral(0.6, 4, False)], ids=["square", "unequal", "fine mesh"])
def test_tubes_are_those_of_numpy(
    tmp_path: Path, triangles: np.ndarray, smallest: float, every: bool, lean: float | None
) -> None:
    """In the same order, within rounding of some metres; divided, cut and left as a whole."""
    body = optical(loaded(tmp_path, triangles))
    scene = body.scene
    if lean is not None:
        rotation = np.array([[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]])
        body, scene = body.leaning(rotation), body.scene.rotated(rotation)
        direct_body = optical(loaded(tmp_path, triangles @ rotation.T))
        tubes = launched(direct_body, every=every)
    else:
        tubes = launched(body, every=every)
    compiled, by_numpy = both(lambda: list(hits(tubes, body.planes, scene, 3, ends_on(body, smallest))))
    assert len(compiled) > 0
    assert_same(compiled, by_numpy)


@pytest.mark.parametrize("most", [(0, 0), (1, 1), (5, 2)])
def test_where_few_may_be_divided_the_same_ones_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, most: tuple[int, int]
) -> None:
    """Tubes that may not be divided any more are cut by the line that was found; only the largest have rays at their corners."""
    monkeypatch.setattr(tube_tracing, "MAX_DIVIDED", most)
    body = optical(loaded(tmp_path, np.concatenate([UNEQUAL, trihedral(0.3, 3, True) + [0.1, 0.1, 0.0]])))
    tubes = launched(body)
    assert_same(*both(lambda: list(hits(tubes, body.planes, body.scene, 3, ends_on(body, SMALLEST)))))


@pytest.mark.parametrize("polarization", ["h", "v"])
def test_fields_of_tubes_of_which_legs_reach_a_share(tmp_path: Path, polarization: str) -> None:
    """Within -120 dB of the strongest one; positions within rounding."""
    body = optical(loaded(tmp_path, COARSE))
    leg, tubes = direct(body, HERE), launched(body, polarization)
    share = np.random.default_rng(9).uniform(0.1, 1.0, len(tubes.launch.share))
    tubes = replace(tubes, launch=tubes.launch._replace(share=share))
    for part in [tubes.chosen(np.arange(0)), *hits(tubes, body.planes, body.scene, 3, ends_on(body, 0.05))]:
        rays, wave = leg.rays(part.centre.T), Wave(body.wave.wavelength, polarization)
        compiled, by_numpy = both(lambda part=part, rays=rays, wave=wave: received_fields(part, rays, leg, wave))
        peak = np.abs(by_numpy.amplitude).max(initial=1e-300)
        np.testing.assert_allclose(compiled.amplitude, by_numpy.amplitude, rtol=0.0, atol=1e-6 * peak)
        np.testing.assert_allclose(compiled.position, by_numpy.position, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("few", [0, 1])
def test_few_tubes_and_none(tmp_path: Path, few: int) -> None:
    body = optical(loaded(tmp_path, COARSE))
    tubes = launched(body).chosen(np.arange(few))
    compiled, by_numpy = both(lambda: list(hits(tubes, body.planes, body.scene, 2, ends_on(body, SMALLEST))))
    assert [len(part) for part in compiled] == [len(part) for part in by_numpy]


def test_tubes_that_no_leg_receives_land_nowhere(tmp_path: Path) -> None:
    body = optical(loaded(tmp_path, COARSE))
    tubes = launched(body)
    compiled, by_numpy = both(lambda: list(hits(tubes, body.planes, body.scene, 2, ends_on(body, SMALLEST, lit=False))))
    assert compiled == by_numpy == []


def test_what_rays_raise_is_raised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    body = optical(loaded(tmp_path, COARSE))
    tubes, calls = launched(body), []

    def failing(scene: TriangleScene, begin: np.ndarray, direction: np.ndarray) -> np.ndarray:
        calls.append(len(begin))
        if len(calls) < 3:
            return np.zeros(len(begin), dtype=np.int64)
        raise KeyboardInterrupt

    monkeypatch.setattr(TriangleScene, "first_hit_of", failing)
    with pytest.raises(KeyboardInterrupt):
        list(hits(tubes, body.planes, body.scene, 2, ends_on(body, SMALLEST)))
    assert len(calls) == 3


@pytest.mark.parametrize("returned", [0, 1])
def test_an_interrupt_that_ctypes_drops_is_raised(returned: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal may come as C calls Python, before the first line there: nothing is traced, and what is returned is not set."""
    body = optical(loaded(tmp_path, COARSE))
    tubes = launched(body)
    monkeypatch.setattr("radar_service.kernels.library.RAY_CALL", lambda _: RAY_CALL(lambda *_: returned))
    with pytest.raises(KeyboardInterrupt):
        list(hits(tubes, body.planes, body.scene, 2, ends_on(body, SMALLEST)))
