"""JSON with each key once, whatever the depth."""

import pytest

from radar_service.strict_json import DuplicateKeyError, parsed


def test_plain_json_is_parsed_as_it_stands() -> None:
    assert parsed('{"a": [1, 2.5, {"b": null}], "c": {"a": true}}') == {"a": [1, 2.5, {"b": None}], "c": {"a": True}}
    assert parsed(b"[]") == []


@pytest.mark.parametrize("text", ['{"a": 1, "b": 2, "a": 1}', '[0, {"b": {"a": 1, "a": 2}}]', b'{"a": {}, "\\u0061": {}}'])
def test_a_key_that_occurs_twice_in_one_table_is_named(text: str | bytes) -> None:
    with pytest.raises(DuplicateKeyError, match='the key "a" occurs twice in one table; remove one'):
        parsed(text)


def test_the_first_of_many_keys_is_found_in_linear_time() -> None:
    keys = [f'"{number}": 0' for number in range(100_000)]
    with pytest.raises(DuplicateKeyError, match='"99999"'):
        parsed(f"{{{', '.join(keys)}, {keys[-1]}}}")


@pytest.mark.parametrize("text", ["{", "", "nul", b"\xff"])
def test_what_is_no_json_is_a_value_error(text: str | bytes) -> None:
    with pytest.raises(ValueError):
        parsed(text)
