"""JSON bodies of REST: each key once, and values of exactly the type that OpenAPI says, on every route that takes one."""

from collections.abc import Iterator, Mapping
from itertools import product
from typing import Any

from radar_service.ports.app import create_app
from tests.ports.playing import playing, station
from tests.ports.rest.test_command_routes import station as steerable

Route = tuple[str, str]
WRONG: dict[str, tuple[object, ...]] = {
    "number": (True, "90", "1e3", [1]), "integer": (True, "2", 2.5), "boolean": (1, 0, "true", "on"), "string": (7, True),
}  # fmt: skip
JSON = {"content-type": "application/json"}
NUMBERED = {"radar": "0", "name": "buoy"}


def openapi() -> dict[str, Any]:
    return create_app([station()]).openapi()


def json_routes() -> list[Route]:
    """Method and path of each route that takes JSON."""
    return [
        (method.upper(), path.format(**NUMBERED))
        for path, methods in openapi()["paths"].items()
        for method, its in methods.items()
        if "application/json" in its.get("requestBody", {}).get("content", {})
    ]


def wrong_bodies() -> Iterator[tuple[str, str, object, str]]:
    """Method, path and a body with one value of a wrong type, and its key."""
    document = openapi()
    for path, methods in document["paths"].items():
        for method, its in methods.items():
            schema = its.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
            for keys, kinds in leaves(schema, document["components"]["schemas"]):
                for wrong in {repr(value): value for kind in kinds for value in WRONG[kind]}.values():
                    if not any(fits(wrong, kind) for kind in kinds):
                        yield method.upper(), path.format(**NUMBERED), nested(keys, wrong), keys[0]


def leaves(schema: Mapping[str, Any], named: Mapping[str, Any]) -> Iterator[tuple[tuple[str, ...], set[str]]]:
    """The paths of keys to plain values, and their types."""
    choices = [resolved(choice, named) for choice in resolved(schema, named).get("anyOf", [schema])]
    if (kinds := {choice.get("type") for choice in choices} & WRONG.keys()) and not has_constants(choices):
        yield (), kinds
    for choice in choices:
        for key, value in choice.get("properties", {}).items():
            yield from (((key, *keys), kinds) for keys, kinds in leaves(value, named))


def resolved(schema: Mapping[str, Any], named: Mapping[str, Any]) -> Mapping[str, Any]:
    return named[schema["$ref"].rpartition("/")[2]] if "$ref" in schema else schema


def has_constants(choices: list[Mapping[str, Any]]) -> bool:
    return any("enum" in choice for choice in choices)


def fits(value: object, kind: str) -> bool:
    types: dict[str, tuple[type, ...]] = {"number": (int, float), "integer": (int,), "boolean": (bool,), "string": (str,)}
    return isinstance(value, types[kind]) and isinstance(value, bool) == (kind == "boolean")


def nested(keys: tuple[str, ...], value: object) -> object:
    return {keys[0]: nested(keys[1:], value)} if keys else value


async def test_a_value_of_another_type_is_refused_everywhere() -> None:
    bodies = list(wrong_bodies())
    assert {("PATCH", "/api/radars/0/own-ship"), ("PATCH", "/api/radars/0/controls"), ("PATCH", "/api/radars/0/errors")} <= {
        body[:2] for body in bodies
    }
    async with playing(steerable()) as server:
        for method, path, body, key in bodies:
            answer = await server.http.request(method, path, json=body)
            assert answer.status_code == 422, (path, body, answer.text)
            assert any(line.startswith(key) for line in answer.json()["detail"]), (path, body, answer.text)


async def test_a_position_is_two_numbers() -> None:
    async with playing(steerable()) as server:
        for position in ([True, 1], ["1", 1], "12"):
            answer = await server.http.patch("/api/radars/0/own-ship", json={"position_m": position})
            assert answer.status_code == 422 and answer.json()["detail"][0].startswith("position_m")


async def test_a_key_that_occurs_twice_is_refused_and_named_on_every_route() -> None:
    routes = json_routes()
    assert len(routes) >= 6
    async with playing(steerable()) as server:
        for method, path in routes:
            for body in ('{"scene": {"a": 1, "a": 2}}', '{"gain": 1, "gain": 2}'):
                key = "a" if "scene" in body else "gain"
                answer = await server.http.request(method, path, content=body, headers=JSON)
                assert answer.status_code == 422, (method, path, answer.text)
                assert answer.json() == {"detail": [f'body: the key "{key}" occurs twice in one table; remove one']}


async def test_a_number_that_is_not_finite_is_refused_and_named() -> None:
    places = [
        ("own-ship", '{"course_deg": X}', "course_deg"), ("bodies/buoy", '{"speed_kn": X}', "speed_kn"),
        ("own-ship", '{"position_m": [X, 0]}', "position_m"), ("controls", '{"gain": X}', "gain"),
        ("errors", '{"gyro": {"bias_deg": X}}', "gyro.bias_deg"),
    ]  # fmt: skip
    async with playing(steerable()) as server:
        for (path, body, key), number in product(places, ("NaN", "Infinity", "-Infinity", "1e999")):
            answer = await server.http.patch(f"/api/radars/0/{path}", content=body.replace("X", number), headers=JSON)
            assert answer.status_code == 422 and answer.json()["detail"][0].startswith(key), answer.text
