// Read-outs: everything on the page that only tells.

import { placed, positionText } from "./geo.js";
import { bearingText, rangeText, ringStep } from "./units.js";
import { TURN } from "./view.js";

const KNOT = 1852 / 3600; // m/s
const WIRE_TURN = 65_536; // wire units per revolution
const element = (id) => document.getElementById(id);

function show(id, text) {
  const place = element(id);
  if (place.textContent !== text) place.textContent = text; // an unchanged node costs no layout
}

/** Own ship as spoke k of a message tells it; angles [rad], position [m], speed [m/s]. */
export function shipOf(message, k) {
  const radians = (list) => (list[k] * TURN) / WIRE_TURN;
  return {
    heading: radians(message.heading),
    course: radians(message.course),
    azimuth: radians(message.azimuth),
    speed: message.speed[k],
    position: message.position[k],
  };
}

/** Connection state in the panel: connecting, live, waiting, refused; detail says why. */
export function showConnection(state, detail) {
  const words = { connecting: "Connecting", live: "Connected", waiting: "Disconnected", refused: "Refused" };
  element("connection").dataset.state = state;
  element("connection").title = detail;
  show("connection", words[state]);
}

/** A line across the picture that nobody should overlook; empty text removes it. isMild: the picture lives all the same. */
export function showBanner(text, isMild) {
  show("banner", text);
  element("banner").hidden = !text;
  element("banner").classList.toggle("mild", isMild);
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

export function showMode(orientation) {
  show("mode-text", { "north-up": "North up", "head-up": "Head up", "course-up": "Course up" }[orientation]);
}

/** Own ship at a time of simulation [s]; origin of the scene, or null. */
export function showShip({ ship, time, scan }, origin) {
  const [east, north] = ship.position;
  const onMap = `${east.toFixed(0)} m E, ${north.toFixed(0)} m N`;
  show("heading-text", bearingText(ship.heading));
  show("course-text", bearingText(ship.course));
  show("speed-text", `${(ship.speed / KNOT).toFixed(1)} kn`);
  const here = { bearing: 0, range: 0 };
  show("position-text", origin ? positionText(placed(here, ship.position, 0, origin)) : onMap);
  show("time-text", clock(time));
  show("scan-text", String(scan));
}

function clock(seconds) {
  const parts = [seconds / 3600, (seconds / 60) % 60, seconds % 60].map(Math.floor);
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

/** range: of the radar [m]; framing: what part of it is on the screen. */
export function showRange(range, framing, unit) {
  const span = range / framing.zoom;
  show("range-text", rangeText(span, unit));
  show("rings-text", rangeText(ringStep(span, unit), unit));
  const zoom = `${Number(framing.zoom.toFixed(1))}×`;
  show("zoom-text", zoom);
  show("framing-text", framing.isPlain ? "" : framing.zoom > 1 ? `${zoom} of ${rangeText(range, unit)}` : "Off centre");
}

/** `which`: "cursor" or "marker"; place {bearing, range} or null; site: own ship's position [m], the antenna's height [m]
 *  and the scene's origin, null where it has none. */
export function showPlace(which, place, heading, unit, { position, height, origin }) {
  show(`${which}-range`, place ? rangeText(place.range, unit) : "–");
  show(`${which}-bearing`, place ? `${bearingText(place.bearing)} T  ${bearingText(place.bearing - heading)} R` : "–");
  show(`${which}-position`, place && origin ? positionText(placed(place, position, height, origin)) : "");
}

/** frames: {rate [1/s], work [s]}, or null. */
export function showFeed(ledger, rate, lag, frames) {
  const quiet = ledger.missing ? ` (${ledger.missing} unannounced)` : "";
  show("lost-text", `${ledger.lost}${quiet}`);
  show("rate-text", rate.toFixed(0));
  show("lag-text", lag === null ? "–" : `${(lag * 1000).toFixed(0)} ms`);
  show("frames-text", frames ? `${frames.rate.toFixed(0)}, ${(frames.work * 1000).toFixed(1)} ms of work each` : "–");
}

/** Says something to a screen reader, and only there. */
export function speak(text) {
  show("spoken", text);
}
