"""Bodies of REST: controls with the limits of their declaration, and nothing unknown."""

from typing import Any

import pytest
from pydantic import ValidationError

from radar_service.ports.rest.schemas import ControlsChange, ControlsState
from radar_service.service.controls import CONTROLS


@pytest.mark.parametrize("control", [c for c in CONTROLS if c.kind == "number"], ids=lambda control: control.name)
def test_numbers_have_the_limits_of_their_control(control: Any) -> None:
    for limit, beyond in ((control.minimum, -1.0), (control.maximum, 1.0)):
        if limit is not None:
            assert getattr(ControlsChange.model_validate({control.name: limit}), control.name) == limit
            with pytest.raises(ValidationError):
                ControlsChange.model_validate({control.name: limit + beyond * 1e-3})
    with pytest.raises(ValidationError):
        ControlsChange.model_validate({control.name: float("nan")})


def test_what_is_not_given_is_not_changed() -> None:
    assert ControlsChange().model_dump(exclude_none=True) == {}
    with pytest.raises(ValidationError):
        ControlsChange.model_validate({"colour": "red"})


def test_the_schemas_show_descriptions_and_examples_of_the_controls() -> None:
    properties = ControlsChange.model_json_schema()["properties"]
    assert {name: field["description"] for name, field in properties.items()} == {c.name: c.description for c in CONTROLS}
    example = ControlsState.model_json_schema()["examples"][0]
    assert ControlsState.model_validate(example).model_dump() == example
