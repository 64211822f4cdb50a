"""Equal meshes of one material are prepared once; their facets stay for more half octaves of range."""

import numpy as np

import radar_service as rs
from radar_service.scattering.physical_optics.shared_bodies import optical_bodies
from tests.scenes import scene

BOX = {"shape": "box", "length_m": 10, "width_m": 4, "height_m": 3, "position_m": [0, 500, 0], "material": "steel"}


def bodies(*changes: dict[str, object]) -> rs.Scene:
    return scene([{**BOX, "name": f"b{k}", **change} for k, change in enumerate(changes)])


def test_equal_boxes_are_one_wherever_they_are_and_others_are_not() -> None:
    made = bodies({}, {"position_m": [900, 0, 0], "speed_kn": 9}, {"length_m": 11}, {"material": "aluminium"})
    optical = optical_bodies(made.bodies, made.radar, 3)
    assert optical[0] is optical[1]
    assert len({id(one) for one in optical}) == 3


def test_a_shared_cache_of_facets_is_larger_up_to_a_bound() -> None:
    sizes = []
    for count in (1, 3, 30):
        made = bodies(*[{}] * count)
        sizes.append(optical_bodies(made.bodies, made.radar, 3)[0].facets.size)
    assert sizes == [sizes[0], 3 * sizes[0], 8 * sizes[0]]


def test_a_box_among_equal_ones_echoes_as_alone() -> None:
    """A field is the sum of the fields of its bodies; rounding of float32 sums, 1e-5 of the peak."""
    sections = {"radar": {"range_max_m": 1500, "azimuths": 90, "beamwidth_deg": 8}, "environment": {"noise": False}}
    given = [{**BOX, "name": "a", "speed_kn": 5}, {**BOX, "name": "b", "position_m": [300, -900, 0], "speed_kn": 5}]

    def field(*which: int) -> np.ndarray:
        return np.asarray(rs.Simulator(scene([given[k] for k in which], **sections), "fast").scan().field)

    both, alone = field(0, 1), field(0) + field(1)
    np.testing.assert_allclose(both, alone, rtol=0, atol=1e-5 * np.abs(both).max())
