"""Error and cost of a plan's line as text."""

import pytest

from radar_service.records.plan_item import PlanItem


@pytest.mark.parametrize(
    ("known", "text"),
    [
        ({}, ""),
        ({"power_db": 0.468}, "0.47 dB"),
        ({"power_db": 0.0}, "0 dB"),
        ({"field_db": -61.46}, "field -61 dB"),
        ({"microseconds": 5.5612}, "5.56 us"),
        ({"microseconds": 0.0}, "0 us"),
        ({"power_db": 0.2, "field_db": -40.0, "microseconds": 1234.5}, "0.2 dB, field -40 dB, 1.23e+03 us"),
    ],
)
def test_the_price_has_what_is_known(known: dict[str, float], text: str) -> None:
    assert PlanItem("beam", True, "full circle", **known).price() == text
