"""Websockets of JSON text: every one of them refuses in the same way."""

import json

import pytest

from tests.ports.asgi import Closed, Server
from tests.ports.playing import play


@pytest.mark.parametrize("path", ["poses", "truth/stream?radiometric=2"])
def test_an_unknown_radar_is_refused_with_a_reason_and_counted(path: str) -> None:
    async def test(server: Server) -> None:
        socket = await server.open(f"/api/radars/{'7' * 50}/{path}")
        bye = json.loads(await socket.text())
        assert bye == {"type": "bye", "reason": f'radar: there is no "{"7" * 40}"; see /api/radars'}
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4404
        assert 'reason="feed radar"} 1' in (await server.http.get("/metrics")).text

    play(test)


def test_other_refusals_have_codes_of_their_own() -> None:
    async def test(server: Server) -> None:
        socket = await server.open("/api/radars/0/truth/stream")
        assert "start it with --truth" in json.loads(await socket.text())["reason"]
        with pytest.raises(Closed) as closed:
            await socket.text()
        assert closed.value.code == 4403

    play(test)
