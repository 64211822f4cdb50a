"""Bodies that hold scenes: read here where they are small, in a process where they are big, refused where they are too big."""

import errno
import json
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from radar_service.ports.rest.bodies import SMALL, read_body
from radar_service.ports.rest.schemas import SceneUpload
from tests.ports.playing import playing

CASES = [
    (b'{"name": "a", "scene": {"name": "s"}}', 201, ""), (b'{"name": "a", "scene": 3}', 422, "scene: 3;"),
    (b"{", 400, "body: not JSON"), (b'{"name": "a", "scene": {}}', 422, "scene: it is empty; give it a name"),
    (b'{"name": "a", "scene": {"radar": {"azimuths": NaN}}}', 422, "radar.azimuths"),
]  # fmt: skip


@pytest.mark.parametrize(("size", "cases"), [(0, CASES), (SMALL + 1, CASES[:3])], ids=["here", "in a process"])
async def test_bodies_are_read_alike_here_and_in_a_process(size: int, cases: list[tuple[bytes, int, str]]) -> None:
    async with playing() as server:
        for body, status, line in cases:
            answer = await server.http.post(
                "/api/scenes", content=body.rjust(size), headers={"content-type": "application/json"}
            )
            assert answer.status_code == status, answer.text
            assert not line or answer.json()["detail"][0].startswith(line)
        kinds = [job["kind"] for job in (await server.http.get("/api/jobs")).json()]
        assert kinds.count("body") == len(cases) * (size > 0)


async def test_a_full_disk_is_an_answer_and_not_a_fault() -> None:
    """There is no room for the folder, for the body, and for the files of a form."""
    wheres, body = ("tempfile.mkdtemp", "pathlib.Path.open", "shutil.copyfileobj"), {"name": "a", "scene": {"name": "s"}}
    async with playing() as server:
        for where, number in product(wheres, (errno.ENOSPC, errno.EDQUOT)):

            def full(*_: object, number: int = number, **__: object) -> None:
                raise OSError(number, "No space left on device")

            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(where, full)
                form: dict[str, Any] = {"data": {"name": "a"}, "files": {"scene": ("m.toml", b"")}}
                answer = await server.http.post("/api/scenes", **(form if where.startswith("shutil") else {"json": body}))
            assert (answer.status_code, answer.json()["detail"]) == (
                507,
                ["body: the server's disk is full; try again later"],
            )
            assert (await server.http.post("/api/scenes", json=body)).status_code == 201


def test_the_scene_lies_beside_the_body(tmp_path: Path) -> None:
    (tmp_path / "body.json").write_text(json.dumps({"name": "a", "scene": {"name": "b"}}))
    fields, refusal = read_body(tmp_path / "body.json", SceneUpload)
    assert fields == {"name": "a", "scene": {}} and refusal is None
    assert json.loads((tmp_path / "scene.json").read_text()) == {"name": "b"}
