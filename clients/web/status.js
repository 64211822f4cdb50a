// The read-outs of the page.

import { radarName } from "./radars.js";
import { geographicPosition, positionText } from "./geo.js";
import { throughWater } from "./stabilisation.js";
import { bearingText, rangeText, ringStep } from "./units.js";
import { TURN } from "./view.js";

const KNOT = 1852 / 3600; // m/s
const WIRE_TURN = 65_536; // wire units per revolution
const element = (id) => document.getElementById(id);

function show(id, text) {
  const node = element(id);
  if (node.textContent !== text) node.textContent = text; // an unchanged node costs no layout
}

/** Own ship at spoke k of a message; angles [rad], position [m], speed [m/s]. A radar that has lost the heading sends none:
 *  heading and course stay those of `before`. */
export function shipOf(message, k, before) {
  const radians = (list) => (list[k] * TURN) / WIRE_TURN;
  const isLost = message.heading[k] === null;
  return {
    isLost,
    heading: isLost ? before.heading : radians(message.heading),
    course: isLost ? before.course : radians(message.course),
    azimuth: radians(message.azimuth),
    speed: message.speed[k],
    position: message.position[k],
  };
}

/** Shows the connection state in the panel: connecting, live, waiting or refused. detail: the reason. */
export function showConnection(state, detail) {
  const words = { connecting: "Connecting", live: "Connected", waiting: "Disconnected", refused: "Refused" };
  element("connection").dataset.state = state;
  element("connection").title = detail;
  show("connection", words[state]);
}

/** Shows a warning across the picture; empty text removes it. isMild: the picture is still updated; offersRetry: with a
 *  button that connects at once. */
export function showBanner(text, isMild, offersRetry) {
  show("banner", text);
  element("banner").hidden = !text;
  element("warning").classList.toggle("mild", isMild);
  element("retry").hidden = !offersRetry;
}

export function showHello(hello) {
  const title = radarName(hello.radar);
  show("radar-name", title);
  document.title = `${title}: ${hello.scene.name}`;
  show("scene-name", hello.scene.name);
  show("fidelity-text", hello.fidelity);
  showTransmitter(hello.radar);
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

/** Shows orientation and motion as radars do: N-UP, H-UP or C-UP; RM for relative or TM for true motion, and in brackets
 *  whether trails are relative or true. Course and speed of own ship, and the picture, are over ground or through the water. */
export function showMode({ orientation, trails, trailmotion, stabilisation }, isTrueMotion) {
  const up = { "north-up": "N-UP", "head-up": "H-UP", "course-up": "C-UP" }[orientation];
  const kind = trails === "0" ? "" : trailmotion === "true" ? "(T)" : "(R)";
  show("mode-text", `${up} ${isTrueMotion ? "TM" : "RM"}${kind}`);
  const [against, water] = stabilisation === "sea" ? ["through the water", true] : ["over ground", false];
  show("stabilisation-text", water ? "SEA STAB" : "GND STAB");
  element("stabilisation-text").title = `Course, speed and motion are ${against}`;
  for (const [id, letter, name] of [["course-label", "C", "Course"], ["speed-label", "S", "Speed"]]) {
    show(id, `${letter}${water ? "TW" : "OG"}`);
    element(id).title = `${name} ${against}`;
  }
}

/** Shows pulse, PRF and power of a radar. */
function showTransmitter({ modulation, pulse_s, bandwidth_hz, prf_hz, power_w }) {
  const pulse = pulse_s < 1e-6 ? `${rounded(pulse_s * 1e9)} ns` : `${rounded(pulse_s * 1e6)} µs`;
  const kind = modulation === "none" ? `Pulse ${pulse}` : `Chirp ${pulse}, ${rounded(bandwidth_hz / 1e6)} MHz`;
  const power = power_w < 1000 ? `${rounded(power_w)} W` : `${rounded(power_w / 1000)} kW`;
  show("pulse-text", kind);
  show("power-text", prf_hz ? `${power}, PRF ${rounded(prf_hz)} Hz` : power);
}

const rounded = (value) => String(Number(value.toPrecision(3)));

/** Shows own ship at a simulated time [s]. origin: of the scene, or null; stream: at own ship, or null; drift: the stream that
 *  course and speed are measured against, or null: the ground. */
export function showShip({ ship, time, scan }, origin, { stream, drift }) {
  const { course, speed } = throughWater(ship, drift);
  const [east, north] = ship.position;
  const onMap = `${east.toFixed(0)} m E, ${north.toFixed(0)} m N`;
  show("heading-text", ship.isLost ? "Lost" : bearingText(ship.heading));
  show("course-text", ship.isLost ? "Lost" : bearingText(course));
  show("speed-text", `${(speed / KNOT).toFixed(1)} kn`);
  element("stream").hidden = !stream;
  if (stream) show("stream-text", `${bearingText(Math.atan2(...stream), 0)}  ${(Math.hypot(...stream) / KNOT).toFixed(1)} kn`);
  const here = { bearing: 0, range: 0 };
  show("position-text", origin ? positionText(geographicPosition(here, ship.position, 0, origin)) : onMap);
  show("time-text", clock(time));
  show("scan-text", String(scan));
}

function clock(seconds) {
  const parts = [seconds / 3600, (seconds / 60) % 60, seconds % 60].map(Math.floor);
  return parts.map((part) => String(part).padStart(2, "0")).join(":");
}

/** Shows range, rings and zoom. range: at the rim at zoom 1 [m]; framing: the part of it that is on the screen. */
export function showRange(range, framing, unit) {
  const span = range / framing.zoom;
  show("range-text", rangeText(span, unit));
  show("rings-text", rangeText(ringStep(span, unit), unit));
  const zoom = `${Number(framing.zoom.toFixed(1))}×`;
  show("zoom-text", zoom);
  show("framing-text", framing.isPlain ? "" : framing.zoom > 1 ? `${zoom} of ${rangeText(range, unit)}` : "Off centre");
}

/** Shows a position. which: "cursor" or "marker"; target: {bearing, range} or null; site: own ship's position [m], the
 *  antenna's height [m] and the scene's origin or null. */
export function showPosition(which, target, heading, unit, { position, height, origin }) {
  show(`${which}-range`, target ? rangeText(target.range, unit) : "–");
  show(`${which}-bearing`, target ? `${bearingText(target.bearing)} T  ${bearingText(target.bearing - heading)} R` : "–");
  show(`${which}-position`, target && origin ? positionText(geographicPosition(target, position, height, origin)) : "");
}

/** Shows the counts and the rate of the feed. */
export function showFeed(sequence, rate, lag) {
  const unannounced = sequence.missing ? ` (${sequence.missing} unannounced)` : "";
  show("lost-text", `${sequence.lost}${unannounced}`);
  show("rate-text", rate.toFixed(0));
  show("lag-text", lag === null ? "–" : `${(lag * 1000).toFixed(0)} ms`);
}

/** Shows how the feed is thinned. level: 0 where it is not; spokes: as many are merged. */
export function showThinned(level, bins, spokes) {
  show("thinned-text", level ? `Thinned: ${bins} bins${spokes > 1 ? `, ${spokes} spokes merged` : ""}` : "");
  element("thinned-text").hidden = !level;
}

/** Shows how many names of true targets have no room on the picture. */
export function showUnnamed(count) {
  show("unnamed-text", count ? `${count} ${count === 1 ? "name" : "names"} not drawn` : "");
  element("unnamed-text").hidden = count === 0;
}

/** Announces a text to screen readers only. */
export function announce(text) {
  show("spoken", text);
}
