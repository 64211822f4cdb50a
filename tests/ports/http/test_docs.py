"""The documentation page: whole, from this server alone, and within its content security policy."""

import contextlib
import re
from pathlib import Path

import pytest

from radar_service.ports.app import create_app
from radar_service.service.access import Access
from radar_service.service.radio.station import Station
from radar_service.service.settings import Pace, Settings
from tests.clients.chromium import CHROMIUM, Browser
from tests.ports.playing import playing
from tests.ports.serving import served
from tests.service.fake import FakeEngine, factory, scene


async def test_every_file_of_the_page_comes_from_this_server() -> None:
    async with playing() as server:
        page = await server.http.get("/docs")
        assert page.status_code == 200 and page.headers["content-security-policy"].startswith("default-src 'self'")
        links = re.findall(r'(?:src|href)="([^"]+)"', page.text)
        assert len(links) == 4
        for link in links:
            assert not re.match(r"[a-z]+:|//", link)
            answer = await server.http.get(f"/{link}")
            assert answer.status_code == 200 and answer.content, link
        assert "SwaggerUIBundle" in (await server.http.get("/docs/files/swagger-ui-bundle.js")).text
        assert (await server.http.get("/docs/start.js")).headers["content-type"].startswith("text/javascript")


async def test_the_page_has_no_inline_script_or_style() -> None:
    """The policy has no 'unsafe-inline': a browser would not run them."""
    async with playing() as server:
        page = (await server.http.get("/docs")).text
        assert "<style" not in page and " style=" not in page
        assert re.findall(r"<script[^>]*>([^<]*)</script>", page) == ["", ""]


@pytest.mark.parametrize("path", ["/docs/files/../../pyproject.toml", "/docs/files/%2e%2e/core.py", "/docs/files/nothing"])
async def test_only_the_files_of_the_page_are_served(path: str) -> None:
    async with playing() as server:
        assert (await server.http.get(path)).status_code == 404


async def test_the_page_is_not_part_of_the_interface_that_it_shows() -> None:
    async with playing() as server:
        paths = (await server.http.get("/api/openapi.json")).json()["paths"]
        assert all(path.startswith("/api/") for path in paths)


@pytest.mark.browser
@pytest.mark.skipif(not CHROMIUM.exists(), reason="needs Chromium")
def test_a_browser_shows_every_operation_without_breaking_the_policy(tmp_path: Path) -> None:
    """The page asks for the token once, and keeps it for the tab as the radar's page does."""
    browser, token = Browser(tmp_path), "reading-" * 3
    only = Station("0", FakeEngine(scene()), factory(), settings=Settings(pace=Pace("pause")))
    app = create_app([only], access=Access("command-" * 3, token))
    with contextlib.closing(browser), served(app, [only]) as (host, port):
        page = browser.open(f"http://{host}:{port}/docs", first=f'window.prompt = () => "{token}";')
        page.wait("document.querySelectorAll('.opblock').length === 24")
        text = page.ask("document.body.innerText")
        assert "/api/radars/{radar}/controls" in text and "Change Controls" in text
        assert [fault for fault in page.faults() if "401" not in fault] == []
