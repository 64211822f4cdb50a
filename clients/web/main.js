// Wires the page: which radar, its feed, its controls, the picture, and the viewer's settings.

import { ask, feedAddress, useToken } from "./api.js";
import { Controls } from "./controls.js";
import { Feed } from "./feed.js";
import { Meter } from "./meter.js";
import { bindPointer } from "./pointer.js";
import { Scope } from "./scope.js";
import { keep, loadSettings } from "./settings.js";
import * as status from "./status.js";

const element = (id) => document.getElementById(id);
const address = new URLSearchParams(location.search);
const BINS = Number(address.get("bins")) || 1024; // two cells per pixel of a 1000-pixel scope; peaks are kept
const SILENT_S = 3; // without a spoke the picture is said to stand still
const DEAD_S = 15; // and a line that stays dumb is dialled again: a half-open connection never reports itself
const REFRESH_MS = 5000; // others may turn the same controls

const settings = loadSettings();
document.documentElement.dataset.palette = settings.palette;
const scope = new Scope(settings, address.get("renderer"));
const controls = new Controls((text) => (element("notice").textContent = text), () => settings.unit);
const now = () => performance.now() / 1000;
let meter = new Meter();
let feed = null;
let radar = null; // of the last hello
let connection = ["connecting", ""];
let spokeAt = now();
let tryAgain = () => {}; // ends the wait between two attempts to begin

function watch(id) {
  feed?.end();
  meter = new Meter();
  feed = new Feed((since) => feedAddress(id, BINS, since), { hello, spokes, gap: () => {}, state });
  feed.open();
}

function hello(message, isNew) {
  radar = message.radar;
  if (isNew) scope.adopt(message);
  meter.restart();
  controls.adopt(message);
  spokeAt = now();
  status.showHello(message);
  status.showRange(nominalRange(), settings.unit);
  if (element("scene").value !== message.scene.name) listScenes(message.scene.name);
  if (isNew) status.speak(`Scene ${message.scene.name}`);
}

function spokes(message) {
  const ship = status.shipOf(message);
  const range = scope.grid.range;
  scope.write(message, ship);
  spokeAt = now();
  meter.spokes(message.count, message.time.at(-1), spokeAt, controls.factor);
  if (range !== message.range) status.showRange(nominalRange(), settings.unit);
  latest = [ship, message];
}

/** The range as it was asked for, where the picture ends within a cell of it: 3000 m rather than 3002 m. */
function nominalRange() {
  const { range, step } = scope.grid;
  const asked = controls.state.range_m ?? range;
  return Math.abs(asked - range) <= step ? asked : range;
}
let latest = null; // own ship and message whose figures stand on the page after the next frame

function state(name, detail) {
  connection = [name, detail];
  status.showConnection(name, detail);
  if (name !== "connecting") status.speak(`${name === "live" ? "Connected" : "Disconnected"} ${detail}`);
  tell();
}

function frame() {
  scope.draw();
  if (latest) {
    status.showShip(latest[0], settings, latest[1]);
    showPlaces();
    latest = null;
  }
  requestAnimationFrame(frame);
}

function showPlaces() {
  status.showPlace("cursor", scope.cursor, scope.ship.heading, settings.unit);
  status.showPlace("marker", scope.marker, scope.ship.heading, settings.unit);
}

/** What keeps the picture from being live, in a few words; empty where it is. */
function trouble() {
  const [name, detail] = connection;
  if (name === "refused") return `Refused: ${detail}`;
  if (name === "waiting") return `No connection: picture stands still. ${detail}`;
  if (name === "connecting") return scope.ship.azimuth === null ? "Connecting" : "No connection: picture stands still";
  if (controls.state.transmit === false) return "Standby";
  if (controls.paused) return "Paused";
  const quiet = now() - spokeAt;
  return quiet > Math.max(SILENT_S, 3 * spokePeriod()) ? `No spokes for ${Math.floor(quiet)} s: picture stands still` : "";
}

function spokePeriod() {
  return radar ? 60 / radar.rpm / radar.azimuths / (controls.factor ?? 1) : 0;
}

function tell() {
  status.showBanner(trouble());
  if (feed) status.showFeed(feed.ledger, meter.rate(now()), meter.lag);
}

function everySecond() {
  tell();
  const idle = controls.paused || controls.state.transmit === false;
  if (idle) meter.restart(); // the service sets its clock anew when it goes on
  const dead = now() - spokeAt > Math.max(DEAD_S, 20 * spokePeriod());
  if (connection[0] === "live" && !idle && dead) {
    spokeAt = now();
    feed.redial("nothing was heard");
  }
}

function choose(name, value) {
  keep(settings, name, value);
  if (name === "palette") {
    document.documentElement.dataset.palette = value;
    scope.repaint();
  }
  if (name === "unit") {
    status.showRange(nominalRange(), value);
    controls.showRanges();
  }
  scope.changed = true;
  showSettings();
  showPlaces();
}

function showSettings() {
  for (const name of ["orientation", "afterglow", "unit", "palette"]) element(name).value = settings[name];
  for (const name of ["rings", "headline", "sweep"]) element(name).checked = settings[name] === "on";
  element("mode-text").textContent = element("orientation").selectedOptions[0].textContent;
}

function next(name) {
  const values = [...element(name).options].map((option) => option.value);
  choose(name, values[(values.indexOf(settings[name]) + 1) % values.length]);
}

function bind() {
  for (const name of ["orientation", "afterglow", "unit", "palette"]) {
    element(name).onchange = () => choose(name, element(name).value);
  }
  for (const name of ["rings", "headline", "sweep"]) {
    element(name).onchange = () => choose(name, element(name).checked ? "on" : "off");
  }
  element("clear").onclick = () => {
    scope.marker = null;
    scope.changed = true;
    showPlaces();
  };
  element("radar").onchange = () => watch(element("radar").value);
  element("load-scene").onclick = loadScene;
  element("scene").onchange = showLoadable;
  bindPointer(scope, showPlaces);
  document.addEventListener("keydown", shortcut);
  document.addEventListener("token-wanted", () => (element("access").hidden = false));
  element("access").onsubmit = enter;
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

function shortcut(event) {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.closest("select, input[type=number], input[type=password]")) return;
  const action = {
    "+": () => controls.stepRange(1),
    "=": () => controls.stepRange(1), // the same key without Shift on many keyboards
    "-": () => controls.stepRange(-1),
    h: () => next("orientation"),
    n: () => next("palette"),
    p: () => controls.togglePause(),
  }[event.key.toLowerCase()];
  if (action) action();
}

async function listScenes(running) {
  const scenes = await ask("scenes").catch(() => []); // the feed goes on without the list
  const names = scenes.map((scene) => scene.name);
  const options = names.map((name) => new Option(name, name, false, name === running));
  if (!names.includes(running)) options.unshift(new Option(`${running} (running)`, "", true, true));
  element("scene").replaceChildren(...options);
  showLoadable();
}

function showLoadable() {
  element("load-scene").disabled = !element("scene").value;
}

async function loadScene() {
  const button = element("load-scene");
  button.disabled = true;
  element("notice").textContent = "";
  try {
    await ask(`radars/${encodeURIComponent(radar.id)}/scene`, "PUT", { scene: element("scene").value });
  } catch (refused) {
    element("notice").textContent = refused.message;
  } finally {
    showLoadable();
  }
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
showSettings();
bind();
setInterval(everySecond, 1000);
setInterval(() => document.hidden || controls.refresh(), REFRESH_MS);
addEventListener("online", () => connection[0] === "waiting" && feed?.redial("the network is back"));
requestAnimationFrame(frame);
start();
