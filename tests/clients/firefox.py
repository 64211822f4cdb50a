"""Drives a headless Firefox by WebDriver BiDi (W3C): just enough to open a page, ask it things, type and look at it."""

import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.clients.chromium import Remote, pixels, until

FIREFOX = Path("/usr/bin/firefox-esr")
KEYS = {"ArrowRight": "\ue014"}  # as WebDriver names them
PREFERENCES = {  # nothing is fetched but the page
    "app.normandy.enabled": False, "app.update.auto": False, "browser.safebrowsing.malware.enabled": False,
    "browser.safebrowsing.phishing.enabled": False, "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False, "extensions.update.enabled": False,
    "network.captive-portal-service.enabled": False, "network.connectivity-service.enabled": False,
    "services.settings.server": "data:,#remote-settings-dummy/v1", "toolkit.telemetry.enabled": False,
    # One page in one process, drawn 15 times a second: three seconds of processor time less.
    "browser.aboutwelcome.enabled": False, "browser.newtab.preload": False, "browser.newtabpage.enabled": False,
    "browser.startup.page": 0, "dom.ipc.processPrelaunch.enabled": False, "fission.autostart": False,
    "layout.frame_rate": 15,
}  # fmt: skip


class Firefox(Remote):
    """One Firefox with a profile of its own under `folder`, and one page in it, width x height CSS pixels."""

    def __init__(self, folder: Path, width: int = 1100, height: int = 700) -> None:
        lines = [f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items()]
        (folder / "user.js").write_text("\n".join(lines), encoding="utf-8")
        command = [str(FIREFOX), "--headless", "--no-remote", "--profile", str(folder), "--remote-debugging-port", "0"]
        super().__init__(command, "WebDriver BiDi listening on ", "/session")
        self.call("session.new", capabilities={})
        self._page: str = self.call("browsingContext.getTree")["contexts"][0]["context"]
        self.call("browsingContext.setViewport", context=self._page, viewport={"width": width, "height": height})

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        """The result of a BiDi command."""
        answer = self.answer(method, params)
        assert answer["type"] == "success", f"{method}: {answer}"
        result: dict[str, Any] = answer["result"]
        return result

    def open(self, url: str) -> None:
        """Loads a page."""
        self.call("browsingContext.navigate", context=self._page, url=url, wait="complete")

    def ask(self, script: str) -> Any:
        """The value of an expression, or of the promise it gives: plain data."""
        expression = f"Promise.resolve({script}).then((value) => JSON.stringify(value ?? null))"
        answer = self.call("script.evaluate", expression=expression, target={"context": self._page}, awaitPromise=True)
        assert answer["type"] == "success", answer
        return json.loads(answer["result"]["value"])

    def wait(self, condition: str) -> None:
        """Until the expression is true in the page; fails with the page's status when it does not become so."""
        seen = self.ask(until(condition))
        assert seen == "", f"never true: {condition}\n{seen}"

    def press(self, key: str) -> None:
        """Press and release a key, as a keyboard would."""
        actions = [{"type": kind, "value": KEYS.get(key, key)} for kind in ("keyDown", "keyUp")]
        self.call(
            "input.performActions", context=self._page, actions=[{"type": "key", "id": "keyboard", "actions": actions}]
        )

    def look(self) -> NDArray[np.int16]:
        """What the page shows (height, width, 3)."""
        return pixels(self.call("browsingContext.captureScreenshot", context=self._page)["data"])

    def close(self) -> None:
        """End the browser and wait for it."""
        self.call("browser.close")
        self.gone()
