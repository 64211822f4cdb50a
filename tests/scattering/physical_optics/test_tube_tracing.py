"""Where tubes hit: divided and cut at edges, in one order of a pair of surfaces."""

from pathlib import Path

import numpy as np
import pytest

from radar_service.scattering.physical_optics import tube_tracing
from radar_service.scattering.physical_optics.path_fields import tube_fields
from radar_service.scattering.physical_optics.ray_tubes import launched_tubes
from radar_service.scattering.physical_optics.tube_tracing import Ends, hits
from tests.scattering.physical_optics.meshes import dihedral, direct, loaded, optical, toward, trihedral
from tests.scattering.physical_optics.test_ray_tubes import SMALLEST, bounced, footprints


@pytest.mark.parametrize(("halvings", "cuts", "least", "most"), [(9, 1, 0.0, 0.002), (0, 99, 0.012, 1.0)])
def test_tubes_are_cut_where_they_hit_an_edge(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, halvings: int, cuts: int, least: float, most: float
) -> None:
    """Plates of 0.6 and 0.222 m across and 0.5 m along their fold, seen at 45 degrees: either lights 0.222 x 0.5 m
    of the other. Cut along the edges that they hit, tubes miss less than 0.2 % of the area (samples stay 2 % off
    corners); undivided ones more than 1.2 %."""
    body = optical(loaded(tmp_path, np.concatenate([dihedral(0.6, 0.5, 1)[:2], 0.37 * dihedral(0.6, 0.5 / 0.37, 1)[2:]])))
    monkeypatch.setattr(tube_tracing, "MAX_HALVINGS", halvings)
    monkeypatch.setattr(tube_tracing, "CUT_LEVEL", cuts)
    ((twice, _),) = bounced(body, toward([1, 1.0, 0.0], 5000), 2)
    lit = np.bincount((np.abs(twice.normal[1]) > 0.5).astype(int), footprints(twice))
    assert least <= np.abs(lit / 0.111 - 1.0).max() < most


def test_the_largest_tubes_are_divided_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Without leave to divide any, fewer tubes arrive than there are parts otherwise; what arrives is as large to 20 %."""
    body = optical(loaded(tmp_path, trihedral(0.6, 1, True)))
    arrived = [footprints(bounced(body, toward([1, 0.9, 1.1], 1000), 2)[0][0])]
    monkeypatch.setattr(tube_tracing, "MAX_DIVIDED", (0, 0))
    arrived.append(footprints(bounced(body, toward([1, 0.9, 1.1], 1000), 2)[0][0]))
    assert len(arrived[1]) < len(arrived[0])
    assert arrived[1].sum() == pytest.approx(arrived[0].sum(), rel=0.2)


def test_tubes_count_where_they_end_on_a_larger_surface(tmp_path: Path) -> None:
    """A small plate before a large one: of the two orders of the pair only that from the small plate is followed, and none of
    its footprints lies on the small plate. With one order alone the field is the same as with both to 3 % (ragged edges)."""
    mesh = np.concatenate([dihedral(0.6, 0.5, 1)[:2], 0.5 * dihedral(0.6, 1.0, 1)[2:]])
    body = optical(loaded(tmp_path, mesh))
    here = toward([1, 0.8, 0.0], 2000)
    leg, faces = direct(body, here), len(body.mesh.faces)
    ends = Ends(body.mesh, np.ones(faces, dtype=np.bool_), body.rank, np.full(faces, SMALLEST))
    surface = body.lit_facets((leg,), -np.inf)[0]
    tubes = launched_tubes(surface, [leg], "h", body.planes, body.rank, [False])
    (arrived,) = hits(tubes, body.planes, body.scene, 2, ends)
    assert (body.rank[arrived.triangle] >= arrived.launch.rank[arrived.launched]).all()
    once = tube_fields(arrived, leg, body.wave)[1].amplitude.sum()
    ((_, both),) = bounced(body, here, 2)
    assert abs(2.0 * once / both.amplitude.sum() - 1) < 0.03
