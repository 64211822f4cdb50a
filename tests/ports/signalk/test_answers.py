"""Reports of the Signal K API from what is raised for a request."""

import pytest
from fastapi import HTTPException

from radar_service.ports.signalk.answers import problem, report
from radar_service.ports.signalk.controls import UnknownControlError
from radar_service.processes.limits import MachineBusyError
from radar_service.service.controls import ControlError
from radar_service.world.error import SceneError


def test_reports() -> None:
    assert report(200) == {"state": "COMPLETED", "statusCode": 200, "message": "OK"}
    assert report(404, "no") == {"state": "FAILED", "statusCode": 404, "message": "no"}


@pytest.mark.parametrize(
    ("error", "status", "message"),
    [
        (UnknownControlError("none"), 404, "none"), (HTTPException(422, ["a", "b"]), 400, "a; b"),
        (HTTPException(404, "gone"), 404, "gone"), (ControlError("gain: 500"), 400, "gain: 500"),
        (SceneError("scene: bad"), 400, "scene: bad"), (MachineBusyError("later"), 503, "later"),
    ],
)  # fmt: skip
def test_refusals_have_the_statuses_of_the_api(error: Exception, status: int, message: str) -> None:
    assert problem(error) == (status, message)


def test_what_is_no_refusal_is_raised_again() -> None:
    with pytest.raises(ZeroDivisionError):
        problem(ZeroDivisionError())
