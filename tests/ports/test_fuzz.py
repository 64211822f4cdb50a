"""REST fuzzed from its OpenAPI, scenes and meshes by hypothesis: no answer of 500 or above, no hang, nothing left behind."""

import contextlib
import gc
import json
import os
import time
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import schemathesis
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from radar_service.ports.app import create_app
from radar_service.scene_file.document import validated
from radar_service.scene_file.readers.mesh import MeshFile
from radar_service.scene_file.readers.sandbox import Sandbox
from radar_service.service.settings import Pace, Settings
from radar_service.world.error import SceneError
from tests.ports.playing import station
from tests.ports.serving import served
from tests.scene_file.readers.mesh_files import exported

SHORT_RUN, SPOILT, MANY = 60, 50, 10_000
HANG = 60.0  # s; a picture of 2048 pixels takes 1.4 s of processor time, and a machine may have much else to do
THERE = {"radar": "0", "name": "harbour"}  # a radar and a scene that the server has
QUICK = settings(
    deadline=None, database=None, suppress_health_check=list(HealthCheck), phases=[Phase.generate], print_blob=False
)  # fmt: skip


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    only = station(settings=Settings(pace=Pace(factor=5)), allow_truth=True)
    with served(create_app([only]), [only]) as (host, port):
        yield f"http://{host}:{port}"


def fuzz(address: str, cases: int) -> dict[str, int]:
    """So many requests made from the OpenAPI; how often each status came. Raises where one is 500 or above, or hangs."""
    schema = schemathesis.openapi.from_url(f"{address}/api/openapi.json")
    seen: dict[str, int] = {}
    with httpx.Client(base_url=address, timeout=HANG) as http:

        @seed(1)
        @settings(QUICK, max_examples=cases)
        @given(case=schema.as_strategy(), known=st.integers(0, 3))
        def ask(case: Any, known: int) -> None:
            if known:  # three quarters go to a radar and a scene that are there, where there is more to break
                case.path_parameters = {name: THERE.get(name, made) for name, made in case.path_parameters.items()}
            request = case.as_transport_kwargs()
            arguments = {key: request.get(key) for key in ("params", "headers")}
            arguments |= {"content": request["data"]} if isinstance(request.get("data"), bytes | str) else {}
            arguments |= {"data": request["data"]} if isinstance(request.get("data"), dict) else {}
            arguments |= {"json": request["json"]} if "json" in request else {}
            arguments |= {"files": request["files"]} if request.get("files") else {}
            try:
                answer = http.request(request["method"], case.formatted_path, **arguments)
            except (httpx.LocalProtocolError, httpx.InvalidURL, UnicodeEncodeError, TypeError, AttributeError):
                return  # the client's own library will not send that
            assert answer.status_code < 500 or (answer.status_code == 503 and "/health" in case.path), (request, answer.text)
            seen[str(answer.status_code)] = seen.get(str(answer.status_code), 0) + 1

        ask()
    return seen


def test_some_requests_made_from_the_openapi(address: str) -> None:
    seen = fuzz(address, SHORT_RUN)
    assert sum(seen.values()) > SHORT_RUN / 2 and seen.get("200", 0) > 2 and seen.get("422", 0) > 2, seen
    assert httpx.get(f"{address}/api/health/ready", timeout=HANG).status_code == 200


@contextlib.contextmanager
def nothing_left_behind() -> Iterator[None]:
    """Files and objects are as many afterwards as before."""

    def held() -> tuple[int, int]:
        gc.collect()
        return len(os.listdir("/proc/self/fd")), len(gc.get_objects())

    files, objects = held()
    began = time.monotonic()
    yield
    after = held()
    print(f"{time.monotonic() - began:.0f} s; files {files} -> {after[0]}, objects {objects} -> {after[1]}")
    assert after[0] <= files + 5 and after[1] < 1.2 * objects


@pytest.mark.study
def test_ten_thousand_requests_made_from_the_openapi(address: str) -> None:
    fuzz(address, SHORT_RUN)
    with nothing_left_behind():
        seen = fuzz(address, MANY)
    print(f"{sum(seen.values())} answers: {seen}")


KEY_PATHS = st.sampled_from(
    ["name", "radar", "radar.azimuths", "radar.rpm", "radar.range_max_m", "radar.window", "radar.pattern", "environment",
     "environment.sea_state", "own_ship.heading_deg", "own_ship.waypoints", "body", "body.0", "body.0.shape",
     "body.0.position_m", "body.0.mesh", "body.0.heightmap", "body.0.rcs_dbsm", "body.0.waypoints", "origin"]
)  # fmt: skip
ODD = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(-(2**70), 2**70), st.floats(), st.text(max_size=8),
        st.sampled_from(["../../etc/passwd", "C:\\x", "a.obj", "\x00", "point", "sphere", "hull", 1e308]),
    ),
    lambda inner: st.one_of(st.lists(inner, max_size=4), st.dictionaries(st.text(max_size=5), inner, max_size=3)),
    max_leaves=6,
)  # fmt: skip


def good() -> dict[str, Any]:
    return {
        "name": "good", "radar": {"azimuths": 24, "beamwidth_deg": 20, "range_max_m": 200}, "environment": {}, "origin": None,
        "own_ship": {"heading_deg": 0},
        "body": [{"name": "a", "shape": "sphere", "radius_m": 1, "position_m": [50, 50, 1]}],
    }  # fmt: skip


def spoilt(changes: list[tuple[str, Any]]) -> dict[str, Any]:
    """A good scene with odd values in some places."""
    made: Any = good()
    for key_path, value in changes:
        *way, last = key_path.split(".")
        here = made
        for step in way:
            here = here[int(step)] if isinstance(here, list) and step.isdigit() and int(step) < len(here) else (
                here.get(step) if isinstance(here, dict) else None
            )  # fmt: skip
        if isinstance(here, dict):
            here[last] = value
        elif isinstance(here, list) and last.isdigit() and int(last) < len(here):
            here[int(last)] = value
    return made  # type: ignore[no-any-return]


def spoil_scenes(address: str, cases: int) -> dict[int, int]:
    """Send so many odd scenes; how often each status came."""
    seen: dict[int, int] = {}
    with httpx.Client(base_url=address, timeout=HANG) as http:

        @seed(2)
        @settings(QUICK, max_examples=cases)
        @given(changes=st.lists(st.tuples(KEY_PATHS, ODD), min_size=1, max_size=3))
        def ask(changes: list[tuple[str, Any]]) -> None:
            body = json.dumps({"scene": spoilt(changes)}).encode()  # NaN and Infinity as Python writes them
            answer = http.put("/api/radars/0/scene", content=body, headers={"content-type": "application/json"})
            assert answer.status_code in (200, 404, 422), (changes, answer.status_code, answer.text)
            seen[answer.status_code] = seen.get(answer.status_code, 0) + 1
            if answer.status_code == 422:
                assert all(": " in line for line in answer.json()["detail"])
            else:
                validated(spoilt(changes))  # what was taken is what the loader takes

        ask()
    return seen


def test_spoilt_scenes_are_accepted_or_refused_with_the_location(address: str) -> None:
    seen = spoil_scenes(address, SPOILT)
    assert seen.get(200, 0) and seen.get(422, 0) > SPOILT / 4, seen


@pytest.mark.study
def test_ten_thousand_odd_scenes(address: str) -> None:
    spoil_scenes(address, SHORT_RUN)
    with nothing_left_behind():
        seen = spoil_scenes(address, MANY)
    print(seen)


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    limited = Sandbox()
    yield limited
    limited.close()


def spoil_meshes(sandbox: Sandbox, cases: int) -> tuple[int, int]:
    """Give so many spoilt mesh files to be read; how many were taken and refused."""
    taken, refused = 0, 0

    @seed(3)
    @settings(QUICK, max_examples=cases)
    @given(kind=st.sampled_from(["obj", "stl", "ply", "glb"]), data=st.data())
    def read(kind: str, data: st.DataObject) -> None:
        nonlocal taken, refused
        content = bytearray(exported(kind))
        for _ in range(data.draw(st.integers(1, 6))):
            at = data.draw(st.integers(0, len(content) - 1))
            content[at] = data.draw(st.integers(0, 255))
        cut = data.draw(st.integers(1, len(content)))
        try:
            (body,) = sandbox.read(MeshFile(bytes(content[: cut if cut % 3 == 0 else None]), f"a.{kind}", "here"))
        except SceneError as fault:
            assert str(fault).startswith("here")
            refused += 1
        else:
            mesh = body.mesh
            assert 0 < len(mesh.faces) <= 2 * 12 and 0 <= mesh.faces.min() <= mesh.faces.max() < len(mesh.vertices)
            taken += 1

    read()
    return taken, refused


def test_spoilt_mesh_files_are_taken_or_refused(sandbox: Sandbox) -> None:
    taken, refused = spoil_meshes(sandbox, SPOILT)
    assert taken and refused


@pytest.mark.study
def test_ten_thousand_spoilt_mesh_files(sandbox: Sandbox) -> None:
    spoil_meshes(sandbox, SHORT_RUN)
    with nothing_left_behind():
        seen = spoil_meshes(sandbox, MANY)
    print("taken and refused:", seen)
