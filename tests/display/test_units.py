"""Ranges as text and the distance of range rings, in nautical miles and in metres."""

import pytest

from radar_service.display.units import Unit, range_text, ring_step
from radar_service.numerics.constants import NAUTICAL_MILE

RANGES = (60.0, 463.0, 750.0, 999.6, 1852.0, 2999.0, 3000.0, 4999.3, 5000.0, 9999.9, 12_000.0, 44_448.0, 96_000.0, 200_000.0)


@pytest.mark.parametrize(
    ("distance", "unit", "text"),
    [
        (231.5, "nm", "0.125 NM"), (926.0, "nm", "0.5 NM"), (5556.0, "nm", "3 NM"), (5000.0, "nm", "2.7 NM"),
        (37.5, "m", "37.5 m"), (500.0, "m", "500 m"), (5000.0, "m", "5000 m"), (12_500.0, "m", "12.5 km"),
    ],
)  # fmt: skip
def test_ranges_are_written_as_on_the_page(distance: float, unit: Unit, text: str) -> None:
    assert range_text(distance, unit) == text


def test_rings_stand_at_round_distances() -> None:
    assert [ring_step(nm * NAUTICAL_MILE, "nm") / NAUTICAL_MILE for nm in (0.75, 3, 6, 12, 96)] == [0.125, 0.5, 1, 2, 16]
    assert [ring_step(reach, "m") for reach in (5000.0, 3000.0, 750.0, 60.0, 96_000.0)] == [1000, 500, 200, 10, 20_000]


@pytest.mark.parametrize("unit", ["nm", "m"])
def test_a_picture_has_three_to_six_rings(unit: Unit) -> None:
    """Of 2.0 (metres: steps of 1, 2 and 5) or 3 to 6; the last cell may end a thousandth short of the sixth."""
    assert all(2.0 < reach / ring_step(reach, unit) < 6.007 for reach in RANGES)
