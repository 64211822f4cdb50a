"""The records of the ground truth as plain data."""

from radar_service.records.truth import BodyTruth, Truth


def test_truth_is_plain_data() -> None:
    body = BodyTruth(
        "b", (1.0, 2.0, 3.0), (0.0, 0.0, 0.0), 0.1, 0.2, 0.3, 4.0, 0.5, 0.6, False, "shadowed", None, None, 7, 12.0
    )
    plain = Truth(1.5, body, (body,)).as_dict()
    assert plain["time"] == 1.5 and plain["bodies"][0] == plain["own_ship"]
    assert plain["own_ship"]["position"] == (1.0, 2.0, 3.0) and plain["own_ship"]["mmsi"] == 7
