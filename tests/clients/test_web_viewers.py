"""Several radars and viewers, lost connections and the page's address; in a real browser."""

from tests.clients.chromium import Page
from tests.clients.conftest import Opened
from tests.clients.fake_radar import FakeRadar
from tests.clients.screen import BARE, BROWSER

pytestmark = BROWSER

OFFLINE = "window.online ??= fetch, window.fetch = () => Promise.reject(new TypeError('Failed to fetch')), 1"
TOASTS = "[...document.querySelectorAll('.toast p')].map((one) => one.textContent)"
QUERY = "Object.fromEntries(new URLSearchParams(location.search))"


def change(page: Page, name: str, value: str) -> None:
    """Selects a value of a list, as a user does."""
    page.ask(f"document.getElementById('{name}').value = '{value}', {name}.dispatchEvent(new Event('change'))")


def test_changes_by_other_viewers_are_told_and_own_ones_are_not(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.wait("document.getElementById('range').selectedOptions[0].textContent === '1.5 NM'")
    page.press("-")
    page.wait("document.getElementById('range').selectedOptions[0].textContent === '0.75 NM'")
    radar.epoch = "two"
    radar.send(radar.hello())  # which tells the range that this page has set
    page.ask("gain.value = 63, gain.dispatchEvent(new Event('input'))")
    page.press("p")
    page.wait("document.getElementById('pause').ariaPressed === 'true'")
    assert page.ask(TOASTS) == []
    radar.epoch = "three"
    pace = {"state": "run", "factor": 1.0}
    radar.controls |= {"range_m": 1852 / 2, "gain": 20, "transmit": False, "pace": pace}
    radar.send(radar.hello())
    page.wait(f"{TOASTS}.length === 4")
    assert sorted(page.ask(TOASTS)) == [
        "Gain set to 20 % by another viewer", "Range set to 0.5 NM by another viewer",
        "Simulation resumed by another viewer", "Standby set by another viewer",
    ]  # fmt: skip
    radar.scene = "elsewhere"
    radar.epoch = "four"
    radar.send(radar.hello())
    page.wait(f"{TOASTS}.includes('Scene elsewhere started by another viewer')")


def test_a_command_that_fails_is_taken_back_and_explained(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE)
    page.wait("document.getElementById('gain').value === '50'")
    page.ask(OFFLINE)
    page.ask("gain.focus(), gain.value = 90, gain.dispatchEvent(new Event('input'))")
    page.wait(f'{TOASTS}.includes("Gain not changed: the radar\'s service does not answer.")')
    page.wait("document.getElementById('gain').value === '50' && document.getElementById('gain-value').value === '50'")
    page.ask("rpm.focus(), rpm.value = 30, rpm.dispatchEvent(new Event('change'))")
    page.wait("document.getElementById('rpm').value === '24'")
    assert page.ask("[...document.querySelectorAll('#alerts .toast')].length") == 1
    page.ask("window.fetch = online, gain.value = 60, gain.dispatchEvent(new Event('input'))")
    page.wait(f"{TOASTS}.length === 0")
    assert radar.patched == [{"gain": 60}]


def test_a_lost_connection_can_be_tried_at_once(radar: FakeRadar, opened: Opened) -> None:
    opened.refusal = "WebSocket"
    # By itself it waits on.
    page = opened(BARE, first="window.setTimeout = ((given) => (call, ms) => given(call, ms > 100 ? 1e9 : ms))(setTimeout);")
    assert page.ask("document.getElementById('retry').checkVisibility()") is False
    page.ask(
        """window.real = WebSocket, window.tries = 0, window.WebSocket = class {
          constructor() { tries++; setTimeout(() => this.onclose({code: 1006, reason: ''})); }
          close() {}
        }, 1"""
    )
    radar.drop()
    page.wait("document.getElementById('retry').checkVisibility()")
    at_once = "document.getElementById('retry').click(), new Promise((done) => setTimeout(() => done(tries)))"
    assert [page.ask(at_once) for _ in range(3)] == [1, 2, 3]
    radar.next = 720
    page.ask("window.WebSocket = real, document.getElementById('retry').click()")
    page.wait("document.getElementById('connection').textContent === 'Connected'")
    assert not page.ask("document.getElementById('retry').checkVisibility()")


def test_radars_are_listed_by_name_and_scene_and_kept_in_the_address(radar: FakeRadar, opened: Opened) -> None:
    radar.radars[0]["scene"] = {"name": "known"}
    radar.radars.append({"id": "aft", "name": "aft", "scene": {"name": "open sea"}})
    page = opened(f"{BARE}&radar=7")
    page.wait("document.getElementById('alerts').textContent.includes('no radar “7” here. This is test radar: known.')")
    options = "[...document.getElementById('radar').options].map((one) => one.textContent)"
    assert page.ask(options) == ["test radar: known", "Radar aft: open sea"]
    page.wait("!location.search.includes('radar')")
    change(page, "radar", "aft")
    page.wait(f"{QUERY}.radar === 'aft'")
    page.call("Page.reload")
    page.wait("document.getElementById('radar').value === 'aft' && document.getElementById('scope').dataset.drawn")
    assert page.ask(TOASTS) == []


def test_radars_that_another_scene_brings_are_offered(radar: FakeRadar, opened: Opened) -> None:
    """The page goes on with the first one, and says why; a radar of another scene that comes changes the list alone."""
    page = opened(BARE)
    options = "[...document.getElementById('radar').options].map(({ value }) => value).join()"
    height = "document.getElementById('radar-row').offsetHeight"
    assert page.ask(height) == 0
    radar.radars.append({"id": "aft", "name": "aft", "scene": {"name": "open sea"}})
    radar.tell("scene", radar="aft", epoch="x", name="open sea", fidelity="fast")
    page.wait(f"{options} === '0,aft' && document.getElementById('radar').value === '0'")
    assert page.ask(TOASTS) == [] and len(radar.joined) == 1 and page.ask(height) > 0
    radar.radars = [{"id": name, "name": name, "scene": {"name": "mine"}} for name in ("ship", "shore")]
    radar.tell("status", radar="ship", state="running", fault=None, factor_reached=None)
    reason = "radar 0 has ended: another scene runs, with ship, shore"
    radar.tell("status", state="ended", fault=reason, factor_reached=None)
    page.wait(f"{options} === 'ship,shore' && document.getElementById('radar').value === 'ship'")
    page.wait("document.getElementById('connection').textContent === 'Connected'")
    assert page.ask(TOASTS) == [f"{reason}. This is Radar ship: mine."]
    assert len(radar.joined) == 2


def test_a_radar_that_is_not_there_any_more_makes_the_page_list_them(radar: FakeRadar, opened: Opened) -> None:
    """As where changes do not arrive: the feed says that there is none."""
    page = opened(BARE)
    radar.radars = [{"id": "ship", "name": "ship", "scene": {"name": "mine"}}]
    radar.drop(4404)
    page.wait("document.getElementById('radar').value === 'ship'")
    page.wait("document.getElementById('alerts').textContent.includes('no radar “0” here. This is Radar ship: mine.')")


def test_the_address_follows_what_the_page_shows(radar: FakeRadar, opened: Opened) -> None:
    radar.range_max = radar.picture.range
    page = opened(f"{BARE.replace('dusk', 'night')}&unit=nm")
    for key in ("n", "z"):
        page.press(key)
    page.press("-")
    page.ask("document.getElementById('scope').focus()")
    for key in ["ArrowRight"] * 3 + ["Enter"]:
        page.press(key)
    radar.controls["range_m"] = 1389
    radar.epoch, radar.picture.step = "two", 1389 / 512
    radar.send(radar.hello(), radar.spokes(0, 60))
    page.wait(f"{QUERY}.range === '1389'")
    page.wait(f"{QUERY}.ebl")
    query = page.ask(QUERY)
    assert (query["zoom"], query["ebl"]) == ("2", "3,1389") and query["palette"] == page.ask("palette.value") != "night"
    page.call("Page.reload")
    page.wait("document.getElementById('marker-range').textContent === '0.75 NM'")
    assert page.text("#marker-bearing") == "003.0° T  003.0° R"
    assert page.text("#range-text") == "0.375 NM" and page.ask(QUERY) == query


def test_a_link_with_another_range_zooms_and_commands_nothing(radar: FakeRadar, opened: Opened) -> None:
    page = opened(f"{BARE}&range=1389&zoom=2")
    page.wait("document.getElementById('zoom-text').textContent === '4×'")
    assert radar.patched == []


def test_letter_keys_can_be_switched_off(radar: FakeRadar, opened: Opened) -> None:
    page = opened(f"{BARE}&range=5556&zoom=x")  # neither of which can be had
    page.wait("document.getElementById('framing-text').textContent === ''")
    page.ask("document.getElementById('keys').click(), document.activeElement.blur()")
    for key in ("z", "-", "p", "n"):
        page.press(key)
    assert page.text("#zoom-text") == "1×" and radar.patched == [] and page.ask("palette.value") == "dusk"
    page.ask("document.getElementById('keys').click()")
    page.press("z")
    assert page.text("#zoom-text") == "2×"


def test_what_others_change_shows_as_it_happens_and_after_a_break(radar: FakeRadar, opened: Opened) -> None:
    """The service tells that something has changed, and the page asks what; without a change it asks nothing."""
    radar.gives_truth = True
    page = opened(BARE)
    radar.controls |= {"gain": 77}
    radar.tell("controls", gain=77)
    page.wait("document.getElementById('gain-value').value === '77'")
    radar.send(radar.spokes(720, 60))  # on a busy machine the picture stands still by now, which the page says first
    radar.tell("status", state="behind", fault=None, factor_reached=0.5)
    page.wait("document.getElementById('banner').textContent.startsWith('Too slow: 0.50')")
    radar.errors = {"gyro": {"bias_deg": 20}}
    radar.tell("errors", gyro={"bias_deg": 20})
    page.wait("document.getElementById('errors-text').textContent === 'Errors: gyro'")
    radar.followed.clear()
    radar.drop_followers()
    radar.controls |= {"gain": 78}
    radar.tell("controls", gain=78)
    page.wait("document.getElementById('gain-value').value === '78'")


def test_poses_that_others_send_and_other_radars_make_the_page_ask_nothing(radar: FakeRadar, opened: Opened) -> None:
    """Poses come ten times a second, and show in the spokes; a change of the controls is asked for."""
    radar.gives_truth, radar.errors = True, {"log": {}}
    page = opened(BARE)
    page.wait("document.getElementById('errors-text').textContent === 'Errors: log'")  # asked for by the hello
    asked = "performance.getEntriesByType('resource').filter(({ name }) => name.endsWith('api/radars/0')).length"
    radar.tell("controls", gain=1)
    radar.controls |= {"gain": 77}
    radar.tell("controls", gain=77)
    page.wait("document.getElementById('gain-value').value === '77'")
    asked_for_errors = radar.asked_for_errors
    radar.tell("errors", radar="1")
    before = page.ask(asked)
    for course in range(20):
        radar.tell("commands", own_ship={"course_deg": course})
    radar.controls |= {"gain": 78}
    radar.tell("controls", gain=78)
    page.wait("document.getElementById('gain-value').value === '78'")
    assert page.ask(asked) - before <= 2  # the last one, and one that may have been under way
    assert radar.asked_for_errors == asked_for_errors
