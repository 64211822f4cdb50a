"""A set of bodies of several models: echoes by rising body, whatever order the models have."""

from dataclasses import replace

import numpy as np

import radar_service as rs
from radar_service.records.fidelity import PRESETS
from radar_service.scattering.model import Instant, ScatteringContext
from radar_service.scattering.scatterer_set import ScattererSet, build_scatterers
from radar_service.trace.line_of_sight import OcclusionScene
from tests.scenes import point, scene

BOX = {"shape": "box", "length_m": 9, "width_m": 9, "height_m": 9}


def mixed() -> rs.Scene:
    """Models in turn, at bearings of their own."""
    kinds = [{"material": "wood"}, {"scattering": "optics"}, {"rcs_dbsm": 5}, {"material": "wood"}, {"scattering": "optics"}]
    bodies = [{**BOX, "name": f"b{k}", "position_m": [400 * k - 800, 500, 0], **kind} for k, kind in enumerate(kinds)]
    return scene([*bodies, point("p", -700, 300)])


def built(made: rs.Scene, keys: list[int], sampler: str = "scatterers") -> ScattererSet:
    fidelity = replace(PRESETS["balanced"], sampler=sampler)  # type: ignore[arg-type]
    context = ScatteringContext(made.radar, fidelity, 3, made.antenna(0.0)[0], made.environment, made.bodies, np.inf)
    return build_scatterers([made.bodies[k] for k in keys], keys, context)


def echoes(made: rs.Scene, scatterers: ScattererSet):  # type: ignore[no-untyped-def]
    antenna = made.antenna(0.0)[0]
    return scatterers.echoes(antenna, Instant(0.0, OcclusionScene(made.bodies, np.inf), 1e5))


def test_echoes_are_those_of_each_body_alone_in_order() -> None:
    """Indices count the set's bodies, not the scene's: body 2 is left out."""
    made, keys = mixed(), [0, 1, 3, 4, 5]
    whole = echoes(made, built(made, keys))
    assert (np.diff(whole.body) >= 0).all() and set(whole.body.tolist()) == {0, 1, 2, 3, 4}
    for b, key in enumerate(keys):
        alone = echoes(made, built(made, [key]))
        np.testing.assert_array_equal(whole.position[whole.body == b], alone.position)
        np.testing.assert_array_equal(whole.amplitude[whole.body == b], alone.amplitude)


def test_models_share_their_bodies_and_count_their_scatterers() -> None:
    made, keys = mixed(), [0, 1, 2, 3, 4, 5]
    scatterers = built(made, keys)
    assert len(scatterers) == 6 and [model.key.tolist() for model in scatterers.models] == [[0, 3], [1, 4], [2, 5]]
    counts = scatterers.scatterers
    assert counts[[1, 4]].tolist() == [0, 0] and counts[5] == 1 and (counts[[0, 3]] >= 48).all()
    assert built(made, keys, "sobol").scatterers[[0, 3]].tolist() == [0, 0]


def test_an_empty_set_has_no_echoes() -> None:
    made = mixed()
    none = built(made, [])
    assert len(none) == 0 and len(echoes(made, none)) == 0 and none.scatterers.shape == (0,)


def test_models_by_aspect_are_apart_from_the_steady_ones() -> None:
    """The steady part keeps the indices of the whole set."""
    made, keys = mixed(), [0, 1, 2, 3, 4, 5]
    scatterers = built(made, keys)
    assert [model.key.tolist() for model in scatterers.aspect_models] == [[1, 4]]
    assert set(echoes(made, scatterers.steady).body.tolist()) == {0, 2, 3, 5} and len(scatterers.steady) == 6
