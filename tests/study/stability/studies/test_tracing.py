"""Studies of ray tracing, against theory."""

import numpy as np

from tests.study.stability.run import WAVELENGTH, finding_of


def test_single_precision_of_a_range_is_half_a_unit_in_its_last_place() -> None:
    """From 2^k m to 2^(k+1) m the unit is 2^(k-23) m, so the phase error is at most 360 x 2^(k-23) / lambda degrees. The
    largest of 2000 draws is within 1 % of it."""
    finding = finding_of("float32_range")
    bound = 360.0 * np.array(finding.values) * 2.0**-23 / WAVELENGTH
    assert (finding.curve("float32") <= bound).all()
    assert (finding.curve("float32") >= 0.99 * bound).all()
    assert (finding.curve("the engine, float64") < 1e-6).all()


def test_the_watertight_test_meets_every_triangle_and_embree_those_from_a_millimetre() -> None:
    """The watertight test meets every triangle from 1 um to 100 km; Embree meets all from 1 mm, at 1 km."""
    for name in ("triangle_size", "sliver_width"):
        assert (finding_of(name).curve("watertight") == 0.0).all()
    sizes = np.array(finding_of("triangle_size").values)
    assert (finding_of("triangle_size").curve("Embree")[sizes >= 1e-3] == 0.0).all()
