// Wires the page: which radar, its feed, its controls, the picture, and the viewer's settings.

import { ask, feedAddress, useToken } from "./api.js";
import { Choices } from "./choices.js";
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
const BINS = Number(address.get("bins")) || 1024; // two cells per pixel of a 1000-pixel scope; peaks are kept
const SILENT_S = 3; // without a spoke the picture is said to stand still
const DEAD_S = 15; // and a line that stays dumb is dialled again: a half-open connection never reports itself
const REFRESH_MS = 5000; // others may turn the same controls

const settings = loadSettings();
document.documentElement.dataset.palette = settings.palette;
const scope = new Scope(settings, address.get("renderer"));
const choices = new Choices(scope, chosen);
const controls = new Controls((text) => (element("notice").textContent = text), () => settings.unit);
const playout = new Playout(show, () => controls.factor);
const frames = new FrameMeter();
const scenes = new Scenes(() => radar.id);
const now = () => performance.now() / 1000;
let meter = new Meter();
let feed = null;
let radar = null; // of the last hello
let origin = null; // of its scene: {latitude_deg, longitude_deg}
let givesTruth = false; // as the last hello said
let asksTruth = false; // as the last dialling did
let connection = ["connecting", ""];
let isLost = false; // the line went, and is not back yet
let spokeAt = now();
let latest = null; // own ship and the time and scan whose figures stand on the page after the next frame
let tryAgain = () => {}; // ends the wait between two attempts to begin

function watch(id) {
  feed?.end();
  meter = new Meter();
  const dial = (since) => {
    asksTruth = givesTruth && settings.truth === "on";
    return feedAddress(id, BINS, since, asksTruth);
  };
  feed = new Feed(dial, { hello, spokes, truth, gap: () => {}, state });
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
  spokeAt = now();
  status.showHello(message);
  showFraming();
  scenes.adopt(message);
  askForTruth();
  if (isNew) status.speak(`Scene ${message.scene.name}`);
}

/** Dials again where the truth is wanted, and to be had, and not asked for yet. */
function askForTruth() {
  element("truth").disabled = !givesTruth;
  element("truth-row").title = givesTruth ? "" : "This service does not give the truth; start it with --truth";
  element("targets").hidden = !(givesTruth && settings.truth === "on");
  if (givesTruth && settings.truth === "on" && !asksTruth) feed.redial("");
}

function spokes(message) {
  scope.polar.check(message);
  spokeAt = now();
  meter.spokes(message.count, message.time.at(-1), spokeAt, controls.factor);
  playout.push(message, spokeAt);
}

/** Spokes from <= k < to of a message are due. */
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

/** The range as it was asked for, where the picture ends within a cell of it: 3000 m rather than 3002 m. */
function nominalRange() {
  const { range, step } = scope.grid;
  const asked = controls.state.range_m ?? range;
  return Math.abs(asked - range) <= step ? asked : range;
}

function showFraming() {
  status.showRange(nominalRange(), scope.framing, settings.unit);
}

function state(name, detail) {
  connection = [name, detail];
  isLost = name === "waiting" || (name === "connecting" && isLost);
  status.showConnection(name, detail);
  if (name !== "connecting") status.speak(`${name === "live" ? "Connected" : "Disconnected"} ${detail}`);
  tell();
}

function frame(time) {
  requestAnimationFrame(frame);
  const began = now();
  playout.release(time / 1000);
  scope.draw(time);
  if (latest) {
    status.showShip(latest, origin);
    showPlaces();
    latest = null;
  }
  frames.frame(began, now());
}

function showPlaces() {
  const { ship } = scope;
  const site = { position: ship.position, height: radar?.height_m ?? 0, origin };
  status.showPlace("cursor", scope.cursor, ship.heading, settings.unit, site);
  status.showPlace("marker", scope.marker, ship.heading, settings.unit, site);
}

/** What keeps the picture from moving, in a few words; empty where it moves. */
function standstill() {
  const [name, detail] = connection;
  if (name === "refused") return `Refused: ${detail}`;
  if (name === "waiting") return `No connection, picture stands still: ${detail}`;
  if (name === "connecting" && scope.ship.azimuth === null) return "Connecting";
  if (isLost) return "No connection, picture stands still: connecting";
  if (controls.state.transmit === false) return "Standby";
  if (controls.paused) return "Paused";
  const quiet = now() - spokeAt;
  return quiet > Math.max(SILENT_S, 3 * spokePeriod()) ? `No spokes for ${Math.floor(quiet)} s: picture stands still` : "";
}

/** What slows it down; empty where it keeps its pace. */
function slowness() {
  const { behind, factor } = controls;
  return behind === null ? "" : `Too slow: ${behind.toFixed(2)}× reached of ${factor}× asked for`;
}

function spokePeriod() {
  return radar ? 60 / radar.rpm / radar.azimuths / (controls.factor ?? 1) : 0;
}

function tell() {
  const still = standstill();
  status.showBanner(still || slowness(), !still);
  const lag = controls.behind === null ? meter.lag : null; // a service behind its pace is later at every spoke
  if (feed) status.showFeed(feed.ledger, meter.rate(now()), lag, frames.figures(now()));
}

function everySecond() {
  tell();
  const targets = element("targets");
  if (scope.truth && targets.open) listTruth(targets.querySelector("tbody"), scope.truth, settings.unit);
  const idle = controls.paused || controls.state.transmit === false;
  if (idle) meter.restart(); // the service sets its clock anew when it goes on
  const dead = now() - spokeAt > Math.max(DEAD_S, 20 * spokePeriod());
  if (connection[0] === "live" && !idle && dead) {
    spokeAt = now();
    feed.redial("nothing was heard");
  }
}

/** A setting of the viewer was changed. */
function chosen(name) {
  if (name === "unit") controls.showRanges();
  if (name === "truth") {
    scope.truth = null;
    askForTruth();
  }
  showFraming();
  status.showMode(settings.orientation);
  showPlaces();
}

/** Takes the token, and dials again: what was refused without it may be allowed now. */
function enter(event) {
  event.preventDefault();
  useToken(element("token").value);
  element("token").value = "";
  element("access").hidden = true;
  element("notice").textContent = "";
  feed?.redial("a token was given");
  tryAgain();
}

const KEYS = {
  "+": () => controls.stepRange(1),
  "=": () => controls.stepRange(1), // the same key without Shift on many keyboards
  "-": () => controls.stepRange(-1),
  z: () => choices.zoom(2),
  x: () => choices.zoom(1 / 2),
  o: () => choices.lookAhead(),
  c: () => element("centre").click(),
  h: () => choices.next("orientation"),
  n: () => choices.next("palette"),
  t: () => choices.next("trails"),
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
    radars = await ask("radars").catch((fault) => {
      state("waiting", fault.message);
      return new Promise((resolve) => {
        tryAgain = resolve;
        setTimeout(resolve, Math.min(500 * 2 ** failures, 10_000));
      });
    });
  }
  const wanted = radars.find((one) => one.id === address.get("radar")) ?? radars[0];
  element("radar").replaceChildren(...radars.map((one) => new Option(one.name ?? one.id, one.id, false, one === wanted)));
  element("radar-row").hidden = radars.length < 2;
  watch(wanted.id);
}

element("renderer-text").textContent = scope.renderer.name;
element("radar").onchange = () => watch(element("radar").value);
element("access").onsubmit = enter;
bindPointer(scope, () => {
  showFraming();
  showPlaces();
});
status.showMode(settings.orientation);
document.addEventListener("keydown", shortcut);
document.addEventListener("token-wanted", () => (element("access").hidden = false));
addEventListener("online", () => connection[0] === "waiting" && feed?.redial("the network is back"));
setInterval(everySecond, 1000);
setInterval(() => document.hidden || controls.refresh(), REFRESH_MS);
requestAnimationFrame(frame);
start();
