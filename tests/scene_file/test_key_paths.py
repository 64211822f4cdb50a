"""Keys with dots: where they put a value, and what they refuse."""

from typing import Any

import pytest

from radar_service.scene_file.key_paths import put
from radar_service.world.error import SceneError


def content() -> dict[str, Any]:
    return {
        "name": "a",
        "radar": [{"id": "bow", "rpm": 24}, {"id": "pier", "rpm": 24}],
        "body": [{"name": "ferry", "position_m": [0, 900, 0]}, {"name": "buoy 1", "track": [[0, 1], [2, 3]]}],
    }


@pytest.mark.parametrize(
    ("key", "found"),
    [
        ("name", lambda c: c["name"]),
        ("environment.sea_state", lambda c: c["environment"]["sea_state"]),
        ("errors.gyro.bias_deg", lambda c: c["errors"]["gyro"]["bias_deg"]),
        ("body.ferry.speed_kn", lambda c: c["body"][0]["speed_kn"]),
        ("body.buoy 1.rcs_dbsm", lambda c: c["body"][1]["rcs_dbsm"]),
        ("radar.pier.rpm", lambda c: c["radar"][1]["rpm"]),
        ("body.ferry.position_m.1", lambda c: c["body"][0]["position_m"][1]),
        ("body.buoy 1.track.1.0", lambda c: c["body"][1]["track"][1][0]),
    ],
)
def test_a_value_goes_where_the_key_says_and_nowhere_else(key: str, found: Any) -> None:
    changed, other = content(), content()
    put(changed, key, 7, "here")
    put(other, key, 8, "here")
    assert (found(changed), found(other)) == (7, 8)
    put(changed, key, 8, "here")
    assert changed == other


def test_a_star_is_each_table_of_a_list() -> None:
    changed = content()
    put(changed, "radar.*.rpm", 48, "here")
    put(changed, "body.*.position_m", [1, 2, 3], "here")
    assert [radar["rpm"] for radar in changed["radar"]] == [48, 48]
    assert [body["position_m"] for body in changed["body"]] == [[1, 2, 3]] * 2


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("body.tug.speed_kn", r"^here: there is no 'tug'; there are ferry, buoy 1, or write \* for each$"),
        ("body.speed_kn", r"^here: 'speed_kn' is a key of each table of a list; write the name of one, or \*, before it$"),
        ("name.first", "^here: 'name' is no table; correct the key$"),
        ("body.ferry.position_m.3", "^here: '3' is no number of a list of 3 values; give 0 to 2$"),
        ("body.ferry.position_m.east", "^here: 'east' is no number of a list of 3 values; give 0 to 2$"),
        ("body.ferry.position_m.1.x", "^here: '1' is no table; correct the key$"),
    ],
)
def test_a_key_that_leads_nowhere_is_named(key: str, message: str) -> None:
    with pytest.raises(SceneError, match=message):
        put(content(), key, 7, "here")
