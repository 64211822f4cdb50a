"""The command `schema`."""

import json

import pytest
from jsonschema import Draft202012Validator

from radar_service.__main__ import main
from tests.scenes import ONE_TARGET


def test_schema_accepts_a_good_scene_and_refuses_a_bad_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema"]) == 0
    validator = Draft202012Validator(json.loads(capsys.readouterr().out))
    assert validator.is_valid(ONE_TARGET) and not validator.is_valid(ONE_TARGET | {"colour": "red"})


def test_the_schema_of_a_sweep_is_another(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["schema", "sweep"]) == 0
    validator = Draft202012Validator(json.loads(capsys.readouterr().out))
    assert validator.is_valid({"scene": "harbour", "seeds": 3}) and not validator.is_valid(ONE_TARGET)
