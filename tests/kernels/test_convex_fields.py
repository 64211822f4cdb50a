"""The kernel that has the fields of small convex bodies at many instants, against what evaluates each instant by itself."""

from typing import Any

import numpy as np
import pytest

from radar_service.engine.preparation import Prepared
from radar_service.numerics.types import Complexes
from radar_service.scattering.physical_optics import model
from radar_service.scattering.physical_optics.optical_body import OpticalBody
from tests.scattering.physical_optics.test_convex_bodies import BEFORE, TIMES, evaluated, hull, prepared_for

EQUAL = 1e-6  # of the strongest centre: -120 dB


def assert_alike(ready: Prepared) -> Complexes:
    """The kernel has the amplitude of each centre at each instant; returns these amplitudes."""
    compiled = evaluated(ready)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(OpticalBody, "centres_at", lambda *_: None)
        one_by_one = evaluated(ready)
    assert compiled is not None and one_by_one is not None
    tables = [
        {(*np.round(position, 6), path): row for position, path, row in zip(echoes.position, echoes.path, rows, strict=True)}
        for echoes, rows in (compiled, one_by_one)
    ]
    none = np.zeros(len(TIMES))
    errors = [np.abs(tables[0].get(key, none) - tables[1].get(key, none)).max() for key in {*tables[0], *tables[1]}]
    assert max(errors, default=0.0) <= EQUAL * np.abs(one_by_one[1]).max(initial=0.0)
    return compiled[1]


# One that nothing shades; hulls before it, aside and before each other, of odd courses; one that hides it as a whole.
FIELDS: dict[str, tuple[list[dict[str, Any]], dict[str, Any], dict[str, Any]]] = {
    "alone": ([], {}, {}),
    "shaded": (BEFORE, {}, {}),
    "upright-polarization": (BEFORE, {}, {"polarization": "v"}),
    "no-sea-reflection": (BEFORE, {"multipath": False}, {}),
    "low-antenna": (BEFORE, {"multipath": True}, {"height_m": 4}),
    "near-a-half-octave": ([hull(60.0, 1.0, height_m=1.0)], {"multipath": True}, {}),
    "hidden": ([hull(700.0, height_m=40.0, width_m=60.0, length_m=60.0)], {"multipath": True}, {}),
}


@pytest.mark.parametrize("kind", FIELDS)
def test_fields_are_those_of_each_instant(kind: str) -> None:
    others, environment, radar = FIELDS[kind]
    first = hull(90.6 if kind == "near-a-half-octave" else 760.0, speed_kn=30.0, course_deg=10.0)
    amplitude = assert_alike(prepared_for(first, *others, environment=environment, **radar))
    changed = np.abs(np.diff(amplitude, axis=1)).max(initial=0.0) / np.abs(amplitude).max(initial=1e-30)
    assert (changed > 0.05) == (kind in ("shaded", "upright-polarization", "no-sea-reflection", "low-antenna")), changed


def test_a_hull_that_lies_deep_is_cut_at_the_sea() -> None:
    sunk = hull(760.0)
    sunk["position_m"] = [0.0, 760.0, -1.2]
    amplitude = assert_alike(prepared_for(sunk, *BEFORE))
    assert np.abs(amplitude).max() > 0.1


def test_shadows_of_more_triangles_than_are_exact_are_sampled_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    """With room for no triangle at all each instant is computed alone."""
    ready = prepared_for(hull(760.0), *BEFORE)
    exact = evaluated(ready)
    monkeypatch.setattr(model, "most_triangles", lambda _: 0)
    alone = assert_alike(ready)
    assert exact is not None and alone.shape[1] == exact[1].shape[1]
