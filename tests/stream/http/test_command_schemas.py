"""The models of commands have the keys of commands."""

import pytest
from pydantic import ValidationError

from radar_service.scene.commands import KEYS, Command
from radar_service.stream.http.command_schemas import CommandChange, CommandState


def test_their_keys_are_those_of_a_command() -> None:
    assert set(CommandChange.model_fields) == set(KEYS)
    assert set(CommandState.model_fields) == {"body", "spoke", "time", *KEYS}


def test_a_command_becomes_its_state() -> None:
    command = Command(7, 0.5, None, course_deg=3.0, position_m=(1.0, 2.0))
    assert CommandState.model_validate(command.as_dict()).model_dump(exclude_none=True) == {
        "spoke": 7, "time": 0.5, "course_deg": 3.0, "position_m": (1.0, 2.0)
    }  # fmt: skip


@pytest.mark.parametrize("change", [{"course_deg": 361}, {"speed_kn": -1}, {"position_m": [1, 2, 3]}, {"rudder": 1}])
def test_what_no_scene_allows_is_refused(change: dict[str, object]) -> None:
    with pytest.raises(ValidationError):
        CommandChange.model_validate(change)
