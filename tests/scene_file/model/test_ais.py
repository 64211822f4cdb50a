"""Keys of AIS that contradict each other are refused."""

from typing import Any

import pytest

from tests.scene_file.scene_sources import point, problems


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        ({"body": [point("p", ais={})]}, "body[0].ais: a transponder has a number"),
        ({"own_ship": {"ais": {}}}, "own_ship.ais: a transponder has a number"),
        ({"body": [point("p", mmsi=5), point("q", mmsi=5)]}, "body[1].mmsi: 5 is taken"),
        ({"own_ship": {"mmsi": 5}, "body": [point("p", mmsi=5)]}, "body[0].mmsi: 5 is taken"),
        ({"body": [point("p", mmsi=5, ais={"off_s": [[3, 3]]})]}, "body[0].ais.off_s[0]: 3 is not after 3"),
        ({"body": [point("p", mmsi=5, ais={"name": "é"})]}, "body[0].ais.name"),
        ({"body": [point("p", mmsi=5, ais={"call_sign": "12345678"})]}, "body[0].ais.call_sign"),
        ({"body": [point("p", mmsi=5, ais={"destination": "x" * 21})]}, "body[0].ais.destination"),
        ({"ais": {"loss_percent": 101}}, "ais.loss_percent"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_refused(scene: dict[str, Any], message: str) -> None:
    (problem,) = problems(scene)
    assert problem.startswith(message), problem
