// Connects the parts of the page: radar, feed, controls, picture and settings.

import { callApi, feedAddress, useToken } from "./api.js";
import { Preferences } from "./preferences.js";
import { Controls } from "./controls.js";
import { Feed } from "./feed.js";
import { FrameMeter, Meter } from "./meter.js";
import { Playout } from "./playout.js";
import { bindPointer } from "./pointer.js";
import { Scenes } from "./scenes.js";
import { Scope } from "./scope.js";
import { loadSettings } from "./settings.js";
import * as status from "./status.js";
import { listTruth } from "./truth.js";

const element = (id) => document.getElementById(id);
const address = new URLSearchParams(location.search);
const BINS = Number(address.get("bins")) || 1024; // about two cells per pixel of a 1000-pixel scope; the service keeps peaks
const SILENT_S = 3; // without a spoke, after which the banner says that the picture stands still
const DEAD_S = 15; // without a spoke, after which the page reconnects: a half-open connection reports no error
const REFRESH_MS = 5000; // other clients may change the same controls

const settings = loadSettings();
document.documentElement.dataset.palette = settings.palette;
const scope = new Scope(settings, address.get("renderer"));
const preferences = new Preferences(scope, settingChanged);
const controls = new Controls((text) => (element("notice").textContent = text), () => settings.unit);
const playout = new Playout(show, () => controls.factor);
const frames = new FrameMeter();
const scenes = new Scenes(() => radar.id);
const now = () => performance.now() / 1000;
let meter = new Meter();
let feed = null;
let radar = null; // of the last hello
let origin = null; // of its scene: {latitude_deg, longitude_deg}
let givesTruth = false; // by the last hello
let requestsTruth = false; // in the address of the current connection
let connection = ["connecting", ""];
let isBroken = false; // the connection was lost and is not yet restored
let lastSpokeAt = now();
let latest = null; // own ship, time and scan, which the next frame shows
let retryNow = () => {}; // ends the wait before the next attempt to start

function connectTo(id) {
  feed?.end();
  meter = new Meter();
  const feedUrl = (since) => {
    requestsTruth = givesTruth && settings.truth === "on";
    return feedAddress(id, BINS, since, requestsTruth);
  };
  feed = new Feed(feedUrl, { hello, spokes, truth, gap: () => {}, state });
  feed.open();
}

function hello(message, isNew) {
  radar = message.radar;
  origin = message.scene.origin;
  givesTruth = message.truth;
  if (isNew) {
    playout.clear();
    scope.adopt(message);
  }
  meter.restart();
  controls.adopt(message);
  lastSpokeAt = now();
  status.showHello(message);
  showFraming();
  scenes.adopt(message);
  requestTruth();
  if (isNew) status.announce(`Scene ${message.scene.name}`);
}

/** Reconnects with truth messages if the user selects them and the service gives them. */
function requestTruth() {
  element("truth").disabled = !givesTruth;
  element("truth-row").title = givesTruth ? "" : "This service does not send the truth; start it with --truth";
  element("targets").hidden = !(givesTruth && settings.truth === "on");
  if (givesTruth && settings.truth === "on" && !requestsTruth) feed.reconnect("");
}

function spokes(message) {
  scope.polar.check(message);
  lastSpokeAt = now();
  meter.spokes(message.count, message.time.at(-1), lastSpokeAt, controls.factor);
  playout.push(message, lastSpokeAt);
}

/** Shows spokes from <= k < to of a message, which are due. */
function show(message, from, to) {
  const { range } = scope.grid;
  const ship = status.shipOf(message, to - 1);
  scope.write(message, from, to, ship);
  if (range !== message.range) showFraming();
  latest = { ship, time: message.time[to - 1], scan: message.scan };
}

function truth(message) {
  scope.truth = message;
  scope.changed = true;
}

/** The requested range if the picture ends within a cell of it: 3000 m rather than 3002 m. */
function nominalRange() {
  const { range, step } = scope.grid;
  const requested = controls.state.range_m ?? range;
  return Math.abs(requested - range) <= step ? requested : range;
}

function showFraming() {
  status.showRange(nominalRange(), scope.framing, settings.unit);
}

function state(name, detail) {
  connection = [name, detail];
  isBroken = name === "waiting" || (name === "connecting" && isBroken);
  status.showConnection(name, detail);
  if (name !== "connecting") status.announce(`${name === "live" ? "Connected" : "Disconnected"} ${detail}`);
  showStatus();
}

function frame(time) {
  requestAnimationFrame(frame);
  const began = now();
  playout.release(time / 1000);
  scope.draw(time);
  if (latest) {
    status.showShip(latest, origin);
    showPositions();
    latest = null;
  }
  frames.frame(began, now());
}

function showPositions() {
  const { ship } = scope;
  const site = { position: ship.position, height: radar?.height_m ?? 0, origin };
  status.showPosition("cursor", scope.cursor, ship.heading, settings.unit, site);
  status.showPosition("marker", scope.marker, ship.heading, settings.unit, site);
}

/** Why the picture stands still; empty while it moves. */
function stopReason() {
  const [name, detail] = connection;
  if (name === "refused") return `Refused: ${detail}`;
  if (name === "waiting") return `No connection, picture stands still: ${detail}`;
  if (name === "connecting" && scope.ship.azimuth === null) return "Connecting";
  if (isBroken) return "No connection, picture stands still: connecting";
  if (controls.state.transmit === false) return "Standby";
  if (controls.paused) return "Paused";
  const silence = now() - lastSpokeAt;
  return silence > Math.max(SILENT_S, 3 * spokePeriod()) ? `No spokes for ${Math.floor(silence)} s: picture stands still` : "";
}

/** The warning of a service that is too slow; empty if it keeps its pace. */
function slowReason() {
  const { behind, factor } = controls;
  return behind === null ? "" : `Too slow: ${behind.toFixed(2)}× reached of ${factor}× requested`;
}

function spokePeriod() {
  return radar ? 60 / radar.rpm / radar.azimuths / (controls.factor ?? 1) : 0;
}

function showStatus() {
  const reason = stopReason();
  status.showBanner(reason || slowReason(), !reason);
  const lag = controls.behind === null ? meter.lag : null; // the lag of a service that is too slow only grows
  if (feed) status.showFeed(feed.sequence, meter.rate(now()), lag, frames.rates(now()));
}

function everySecond() {
  showStatus();
  const targets = element("targets");
  if (scope.truth && targets.open) listTruth(targets.querySelector("tbody"), scope.truth, settings.unit);
  const idle = controls.paused || controls.state.transmit === false;
  if (idle) meter.restart(); // the service resets its clock when it continues
  const dead = now() - lastSpokeAt > Math.max(DEAD_S, 20 * spokePeriod());
  if (connection[0] === "live" && !idle && dead) {
    lastSpokeAt = now();
    feed.reconnect("no message arrived");
  }
}

/** Applies a changed setting. */
function settingChanged(name) {
  if (name === "unit") controls.showRanges();
  if (name === "truth") {
    scope.truth = null;
    requestTruth();
  }
  showFraming();
  status.showMode(settings.orientation);
  showPositions();
}

/** Stores the token and reconnects: the service may allow more with it. */
function submitToken(event) {
  event.preventDefault();
  useToken(element("token").value);
  element("token").value = "";
  element("access").hidden = true;
  element("notice").textContent = "";
  feed?.reconnect("the token has changed");
  retryNow();
}

const KEYS = {
  "+": () => controls.stepRange(1),
  "=": () => controls.stepRange(1), // the same key without Shift on many keyboards
  "-": () => controls.stepRange(-1),
  z: () => preferences.zoom(2),
  x: () => preferences.zoom(1 / 2),
  o: () => preferences.lookAhead(),
  c: () => element("centre").click(),
  h: () => preferences.next("orientation"),
  n: () => preferences.next("palette"),
  t: () => preferences.next("trails"),
  p: () => controls.togglePause(),
  s: () => controls.paused && element("step").click(),
};

function shortcut(event) {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.target.closest("select, input[type=number], input[type=password]")) return;
  KEYS[event.key.toLowerCase()]?.();
}

async function start() {
  let radars = null;
  for (let failures = 0; !radars; failures++) {
    radars = await callApi("radars").catch((fault) => {
      state("waiting", fault.message);
      return new Promise((resolve) => {
        retryNow = resolve;
        setTimeout(resolve, Math.min(500 * 2 ** failures, 10_000));
      });
    });
  }
  const selected = radars.find((one) => one.id === address.get("radar")) ?? radars[0];
  element("radar").replaceChildren(...radars.map((one) => new Option(one.name ?? one.id, one.id, false, one === selected)));
  element("radar-row").hidden = radars.length < 2;
  controls.declare(selected.control_definitions);
  connectTo(selected.id);
}

element("renderer-text").textContent = scope.renderer.name;
element("radar").onchange = () => connectTo(element("radar").value);
element("access").onsubmit = submitToken;
bindPointer(scope, () => {
  showFraming();
  showPositions();
});
status.showMode(settings.orientation);
document.addEventListener("keydown", shortcut);
document.addEventListener("token-required", () => (element("access").hidden = false));
addEventListener("online", () => connection[0] === "waiting" && feed?.reconnect("the network is back"));
setInterval(everySecond, 1000);
setInterval(() => document.hidden || controls.refresh(), REFRESH_MS);
requestAnimationFrame(frame);
start();
