"""The short modules of records, each under its name."""

import numpy as np
import pytest

from radar_service.records.plan_item import PlanItem
from radar_service.records.reports import FeedErrorCounts, Readings
from radar_service.records.truth import BodyTruth, Truth


# plan_item: error and cost of a plan's line as text.
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


# reports: readings of several spokes, and sums of what happened to them.
COLUMN = np.arange(4.0)
READINGS = Readings(COLUMN, COLUMN + 10, np.stack([COLUMN, COLUMN + 20], axis=1), COLUMN + 30, COLUMN + 40)


def test_a_part_has_the_rows_of_each_column() -> None:
    part = READINGS.part(slice(1, 3))
    assert [column.tolist() for column in part] == [[1, 2], [11, 12], [[1, 21], [2, 22]], [31, 32], [41, 42]]
    assert READINGS.part(2).position.tolist() == [2, 22] and READINGS.part(2).speed == 42


def test_counts_add_up() -> None:
    one = FeedErrorCounts(dropped=1, repeated=2, late=3, out_of_order=4, stuck=5, heading_lost=6)
    assert one.plus(None) is one
    assert vars(one.plus(one)) == {name: 2 * count for name, count in vars(one).items()}


# truth: the records of the ground truth as plain data.
def test_truth_is_plain_data() -> None:
    body = BodyTruth(
        "b", (1.0, 2.0, 3.0), (0.0, 0.0, 0.0), 0.1, 0.2, 0.3, 4.0, 0.5, 0.6, False, "shadowed", None, None, 7, 12.0
    )
    plain = Truth(1.5, body, (body,)).as_dict()
    assert plain["time"] == 1.5 and plain["bodies"][0] == plain["own_ship"]
    assert plain["own_ship"]["position"] == (1.0, 2.0, 3.0) and plain["own_ship"]["mmsi"] == 7
