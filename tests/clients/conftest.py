"""A browser, a service with a known picture, and pages opened on it.

The browser ends with the tests of this folder: an open page draws on, at the cost of a core.
"""

from collections.abc import Iterator
from typing import Any

import pytest

from tests.clients.chromium import Browser, Page
from tests.clients.fake_radar import Air, FakeRadar, Served, fake_app
from tests.clients.screen import DRAWN, TARGETS


@pytest.fixture(scope="package")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    opened = Browser(tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


@pytest.fixture(scope="package")
def air() -> Air:
    return Air()


@pytest.fixture(scope="package")
def served(air: Air) -> Iterator[Served]:
    running = Served(fake_app(air))
    yield running
    running.close()


@pytest.fixture
def radar(air: Air) -> FakeRadar:
    air.radar = FakeRadar()
    for bearing_deg, distance in TARGETS:
        air.radar.picture.spot(bearing_deg, distance)
    return air.radar


STILL = """window.requestAnimationFrame = () => 0;
  window.fetch = () => new Promise(() => {});
  window.WebSocket = class { close() {} };"""


@pytest.fixture(scope="package")
def modules(browser: Browser, served: Served) -> Page:
    """A page whose modules can be imported; it asks its service nothing, and draws nothing."""
    page = browser.open(served.url, first=STILL)
    page.wait("document.readyState === 'complete'")
    return page


# What the page does after 0.1 s and more, or as often, comes after a tenth of that: reconnections, its address, its second. But
# messages stay for 8 s.
QUICK = """for (const name of ['setTimeout', 'setInterval']) {
  const given = window[name];
  window[name] = (call, ms) => given(call, ms >= 100 && ms !== 8000 ? ms / 10 : ms);
}\n"""


class Opened:
    """Pages of this test; each must have run without an error."""

    def __init__(self, browser: Browser, url: str) -> None:
        self._browser, self._url, self._pages = browser, url, list[Page]()
        self.refusal = "nothing"  # in the text of the one failure that a test means to see

    def __call__(self, query: str = "", drawn: str = "one:720", first: str = "", **size: Any) -> Page:
        page = self._browser.open(f"{self._url}?detail=full&{query}", first=QUICK + first, **size)
        self._pages.append(page)
        page.wait(DRAWN.format(drawn))
        return page

    def close(self) -> list[str]:
        faults = [fault for page in self._pages for fault in page.faults() if self.refusal not in fault]
        for page in self._pages:
            page.ask("localStorage.clear()")
            page.close()
        return faults


@pytest.fixture
def opened(browser: Browser, served: Served, radar: FakeRadar) -> Iterator[Opened]:
    pages = Opened(browser, served.url)
    yield pages
    assert pages.close() == []
