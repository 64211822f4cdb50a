// Read-outs: everything on the page that only tells.

import { bearingText, rangeText, ringStep } from "./units.js";
import { TURN } from "./view.js";

const KNOT = 1852 / 3600; // m/s
const WIRE_TURN = 65_536; // wire units per revolution
const element = (id) => document.getElementById(id);

function show(id, text) {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text; // an unchanged node costs no layout
}

/** Own ship as the last spoke of a message tells it; angles [rad], position [m], speed [m/s]. */
export function shipOf(message) {
  const radians = (list) => (list.at(-1) * TURN) / WIRE_TURN;
  return {
    heading: radians(message.heading),
    course: radians(message.course),
    azimuth: radians(message.azimuth),
    speed: message.speed.at(-1),
    position: message.position.at(-1),
  };
}

/** Connection state in the panel: connecting, live, waiting, refused; detail says why. */
export function showConnection(state, detail) {
  const words = { connecting: "Connecting", live: "Connected", waiting: "Disconnected", refused: "Refused" };
  element("connection").dataset.state = state;
  element("connection").title = detail;
  show("connection", words[state]);
}

/** A line across the picture that nobody should overlook; empty text removes it. */
export function showBanner(text) {
  show("banner", text);
  element("banner").hidden = !text;
}

export function showHello(hello) {
  const title = hello.radar.name === hello.radar.id ? `Radar ${hello.radar.id}` : hello.radar.name;
  show("radar-name", title);
  document.title = `${title}: ${hello.scene.name}`;
  show("scene-name", hello.scene.name);
  show("fidelity-text", hello.fidelity);
  const warnings = hello.scene.warnings ?? [];
  element("warnings").hidden = warnings.length === 0;
  element("warnings").querySelector("summary").textContent = `${warnings.length} warning${warnings.length === 1 ? "" : "s"}`;
  element("warnings").querySelector("ul").replaceChildren(...warnings.map(listItem));
}

function listItem(text) {
  const item = document.createElement("li");
  item.textContent = text;
  return item;
}

export function showShip(ship, settings, message) {
  const mode = { "north-up": "North up", "head-up": "Head up", "course-up": "Course up" };
  show("mode-text", mode[settings.orientation]);
  show("heading-text", bearingText(ship.heading));
  show("course-text", bearingText(ship.course));
  show("speed-text", `${(ship.speed / KNOT).toFixed(1)} kn`);
  show("position-text", `${ship.position[0].toFixed(0)} m E, ${ship.position[1].toFixed(0)} m N`);
  show("time-text", clock(message.time.at(-1)));
  show("scan-text", String(message.scan));
}

function clock(seconds) {
  const parts = [seconds / 3600, (seconds / 60) % 60, seconds % 60].map(Math.floor);
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

export function showRange(range, unit) {
  show("range-text", rangeText(range, unit));
  show("rings-text", rangeText(ringStep(range, unit), unit));
}

/** `which`: "cursor" or "marker"; place {bearing, range} or null. */
export function showPlace(which, place, heading, unit) {
  show(`${which}-range`, place ? rangeText(place.range, unit) : "–");
  show(`${which}-bearing`, place ? `${bearingText(place.bearing)} T  ${bearingText(place.bearing - heading)} R` : "–");
}

export function showFeed(ledger, rate, lag) {
  const quiet = ledger.missing ? ` (${ledger.missing} unannounced)` : "";
  show("lost-text", `${ledger.lost}${quiet}`);
  show("rate-text", rate.toFixed(0));
  show("lag-text", lag === null ? "–" : `${(lag * 1000).toFixed(0)} ms`);
}

/** Says something to a screen reader, and only there. */
export function speak(text) {
  show("spoken", text);
}
