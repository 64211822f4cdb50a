"""The controls on the page are those that the radar declares: a new declaration needs no edit of the page."""

import re
from dataclasses import replace

import pytest

from radar_service.service import controls
from radar_service.service.controls import CONTROLS, Control
from tests.clients.conftest import Opened
from tests.clients.fake_radar import WEB, FakeRadar
from tests.clients.screen import BARE, BROWSER

pytestmark = BROWSER

TUNE = Control(
    "tune", "number", "display", "Tune", "frequency of the local oscillator", read=lambda settings, scene: 3.5,
    unit="kHz", minimum=-20, maximum=20, step=0.5,
)  # fmt: skip
MUTE = replace(TUNE, name="mute", kind="switch", acts_on="transmitter", label="Sound", label_off="Mute", step=None)
TILT = replace(TUNE, name="tilt", acts_on="engine", label="Tilt", unit="deg", step=None)
SEEN = "(({offsetHeight, title, type, labels, min, max, step, value}) => [offsetHeight > 0, title, type, "
SEEN += "labels[0].textContent.trim(), min, max, step, value])"
SECTION = "document.getElementById('{}').closest('section').ariaLabel"


@pytest.fixture
def declared(radar: FakeRadar, monkeypatch: pytest.MonkeyPatch) -> FakeRadar:
    """A radar that declares a slider, a switch and a typed number which the page has never met."""
    monkeypatch.setattr(controls, "CONTROLS", (*CONTROLS, TUNE, MUTE, TILT))
    radar.controls |= {"tune": 3.5, "mute": False, "tilt": -1.25}
    return radar


def test_a_new_declaration_appears_where_it_acts_and_is_patched_when_it_is_moved(
    declared: FakeRadar, opened: Opened
) -> None:
    page = opened(BARE)
    page.wait("document.getElementById('tilt').value === '-1.25'")
    title = TUNE.description
    assert page.ask(f"{SEEN}(tune)") == [True, title, "range", "Tune, kHz", "-20", "20", "0.5", "3.5"]
    assert page.ask(f"{SEEN}(tilt)") == [True, title, "number", "Tilt, deg", "-20", "20", "any", "-1.25"]
    assert page.text("#tune-value") == "3.5"
    assert page.text("#mute") == "Sound" and page.ask("mute.ariaPressed") == "false"
    assert page.ask(SECTION.format("tune")) == page.ask(SECTION.format("gain")) == "Receiver"
    for name in ("mute", "tilt", "transmit", "rpm"):
        assert page.ask(SECTION.format(name)) == "Transmitter and clock"
    page.ask("tune.value = -7.5, tune.dispatchEvent(new Event('input'))")
    page.wait("document.getElementById('tune-value').value === '-7.5'")
    page.ask("mute.click()")
    page.wait("document.getElementById('mute').ariaPressed === 'true'")
    page.ask("tilt.value = 21, tilt.dispatchEvent(new Event('change'))")  # beyond its limit: the page sends nothing
    page.ask("tilt.value = 2.125, tilt.dispatchEvent(new Event('change')); mute.click()")
    page.wait("document.getElementById('mute').ariaPressed === 'false'")
    sent = {name: [change[name] for change in declared.patched if name in change] for name in ("tune", "mute", "tilt")}
    assert sent == {"tune": [-7.5], "mute": [True, False], "tilt": [2.125]}


def test_gain_and_sea_show_auto_while_their_automatics_are_on(radar: FakeRadar, opened: Opened) -> None:
    radar.controls |= {"gain": 45, "gain_auto": True, "sea": 20, "sea_auto": False}
    page = opened(BARE)
    page.wait("document.getElementById('gain-value').value === 'auto' && document.getElementById('gain').value === '45'")
    assert page.text("#sea-value") == "20" and page.ask("gain_auto.ariaPressed") == "true"
    page.ask("gain_auto.click()")
    page.wait("document.getElementById('gain-value').value === '45' && gain_auto.ariaPressed === 'false'")
    assert radar.patched == [{"gain_auto": False}]


def test_a_new_scene_brings_new_limits(radar: FakeRadar, opened: Opened, monkeypatch: pytest.MonkeyPatch) -> None:
    page = opened(f"{BARE}&unit=m")
    page.ask("window.before = gain")
    radar.epoch = "two"
    hello = radar.hello() | {"controls": dict(radar.controls)}
    radar.controls["gain"] = 77  # which REST alone tells
    radar.send(hello)
    page.wait("document.getElementById('gain-value').value === '77'")
    assert page.ask("window.before === gain")  # equal limits: the elements, and the focus with them, stay
    monkeypatch.setattr(controls, "CONTROLS", tuple(replace(c, minimum=300, maximum=700) for c in CONTROLS))
    radar.epoch = "three"
    radar.send(radar.hello())
    page.wait("document.getElementById('gain').min === '300' && document.getElementById('rpm').max === '700'")
    page.wait("document.getElementById('range').options.length === 4")
    scales = page.ask("[...document.getElementById('range').options].map((one) => one.textContent)")
    assert scales == ["500 m", "750 m", "1500 m", "3000 m"]


# Holds the first answer about the radar, and the first one about its errors, until the page calls `release()`.
LATE = """const given = window.fetch, held = window.held = {};
  window.release = () => Object.values(held).forEach((done) => done());
  window.fetch = async (address, options) => {
    const answer = await given(address, options);
    const ending = ['/radars/0', '/errors'].find((one) => options.method === 'GET' && String(address).endsWith(one));
    if (ending && !held[ending]) await new Promise((done) => (held[ending] = done));
    return answer;
  };"""
RELEASE = "release(), new Promise((done) => setTimeout(() => setTimeout(done)))"  # done after all that the answer sets off


def test_an_answer_from_before_a_change_is_not_shown(radar: FakeRadar, opened: Opened) -> None:
    page = opened(BARE, first=LATE)
    page.wait("held['/radars/0']")
    page.ask("transmit.click()")
    page.wait("document.getElementById('transmit').ariaPressed === 'false'")
    page.ask(RELEASE)
    page.ask("transmit.click()")
    page.wait("document.getElementById('transmit').ariaPressed === 'true'")
    assert radar.patched == [{"transmit": False}, {"transmit": True}]


def test_answers_that_overtake_each_other_leave_the_newest_state_and_errors(radar: FakeRadar, opened: Opened) -> None:
    radar.gives_truth = True
    page = opened(BARE, first=LATE)
    page.wait("held['/radars/0'] && held['/errors']")
    radar.controls |= {"gain": 78}
    radar.tell("controls", gain=78)
    radar.errors = {"gyro": {"bias_deg": 20}}
    radar.tell("errors", gyro={"bias_deg": 20})
    page.wait("document.getElementById('gain-value').value === '78'")
    page.wait("document.getElementById('errors-text').textContent === 'Errors: gyro'")
    page.ask(RELEASE)
    assert (page.text("#gain-value"), page.text("#errors-text")) == ("78", "Errors: gyro")


HELD = """const given = window.fetch;
  window.fetch = async (address, options) => {
    if (options.method === 'PATCH' && options.body.includes('rpm') && !window.held)
      await new Promise((release) => (window.held = release));
    return given(address, options);
  };"""


def test_no_control_waits_for_a_change_of_rpm_and_the_page_says_that_it_is_prepared(
    radar: FakeRadar, opened: Opened
) -> None:
    page = opened(BARE, first=HELD)
    page.ask("rpm.value = 30, rpm.dispatchEvent(new Event('change'))")
    page.wait("window.held")
    assert "Preparing Antenna 30 rev/min …" in page.text("#answers")
    page.press("p")
    page.ask("transmit.click()")
    page.wait("transmit.ariaPressed === 'false' && document.getElementById('pause').ariaPressed === 'true'")
    assert page.ask("rpm.value") == "30"  # what is prepared, not what runs
    assert radar.patched == [{"pace": {"state": "pause"}}, {"transmit": False}]
    page.ask("held(), 1")
    page.wait("!document.getElementById('answers').textContent.includes('Preparing')")
    assert radar.patched[2:] == [{"rpm": 30}] and page.ask("rpm.value") == "30"


def test_no_control_has_the_id_of_another_element() -> None:
    ids = set(re.findall(r'id="([^"]+)"', (WEB / "index.html").read_text()))
    assert len(ids) > 50 and ids & {control.name for control in CONTROLS} == set()
