"""The REST interface as OpenAPI describes it."""

from typing import Any

from tests.stream.asgi import Server
from tests.stream.http.playing import play


def test_openapi_lists_every_answer_and_gives_examples() -> None:
    async def test(server: Server) -> None:
        schema = (await server.http.get("/api/openapi.json")).json()
        expected = {
            ("/api/health", "get"): {"200", "503"},
            ("/api/health/alive", "get"): {"200"},
            ("/api/health/ready", "get"): {"200", "503"},
            ("/api/tickets", "post"): {"201"},
            ("/api/scenes", "get"): {"200"},
            ("/api/scenes", "post"): {"201", "400", "409", "413", "422", "503", "507"},
            ("/api/scenes/{name}", "delete"): {"204", "404", "409", "422"},
            ("/api/radars", "get"): {"200"},
            ("/api/radars/{radar}", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "get"): {"200", "404", "422"},
            ("/api/radars/{radar}/controls", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/radars/{radar}/scene", "put"): {"200", "400", "404", "409", "413", "422", "503", "507"},
            ("/api/radars/{radar}/truth", "get"): {"200", "403", "404", "422"},
            ("/api/radars/{radar}/ppi.png", "get"): {"200", "404", "422", "503"},
            ("/api/radars/{radar}/errors", "get"): {"200", "403", "404", "422"},
            ("/api/radars/{radar}/errors", "patch"): {"200", "400", "404", "413", "422"},
            ("/api/radars/{radar}/errors", "delete"): {"200", "404", "422"},
            ("/api/radars/{radar}/own-ship", "get"): {"200", "403", "404", "409", "422"},
            ("/api/radars/{radar}/own-ship", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/radars/{radar}/bodies/{name}", "get"): {"200", "403", "404", "409", "422"},
            ("/api/radars/{radar}/bodies/{name}", "patch"): {"200", "400", "404", "409", "413", "422", "503"},
            ("/api/jobs", "get"): {"200"},
            ("/api/jobs/{job}", "get"): {"200", "404", "422"},
            ("/api/jobs/{job}", "delete"): {"204", "404", "422"},
        }
        described = {
            (path, method): set(about["responses"])
            for path, ways in schema["paths"].items()
            for method, about in ways.items()
        }
        assert described == {way: answers | {"401", "421"} for way, answers in expected.items()}

        def body(path: str, method: str) -> dict[str, Any]:
            return schema["paths"][path][method]["requestBody"]["content"]["application/json"]["schema"]

        change = body("/api/radars/{radar}/controls", "patch")["$ref"]
        assert schema["components"]["schemas"][change.rsplit("/", 1)[1]]["examples"]
        assert body("/api/radars/{radar}/scene", "put")["examples"]
        problem = schema["paths"]["/api/radars/{radar}/scene"]["put"]["responses"]["422"]["content"]["application/json"]
        assert problem["schema"]["$ref"].endswith("/Problem")

    play(test)
