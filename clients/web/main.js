// Connects the parts of the page: radar, feed, controls, picture and settings.

import { addressValue, adoptAddress, followScope } from "./address.js";
import { callApi, feedAddress, useToken } from "./api.js";
import { Changes } from "./changes.js";
import { Preferences } from "./preferences.js";
import { Controls } from "./controls.js";
import { COMPRESSION, Feed } from "./feed.js";
import { bindKeys } from "./keys.js";
import { Meter } from "./meter.js";
import { PANELS, Panels } from "./panels.js";
import { Playout } from "./playout.js";
import { bindPointer } from "./pointer.js";
import { isListed, listRadars, renameRadar } from "./radars.js";
import { Scope } from "./scope.js";
import { SequenceTracker } from "./sequence.js";
import { loadSettings } from "./settings.js";
import * as status from "./status.js";
import { Thinning } from "./thinning.js";
import { dismissAll } from "./toast.js";
import { scaleFor } from "./units.js";

const element = (id) => document.getElementById(id);
const BINS = Number(addressValue("bins")) || 1024; // about two cells per pixel of a 1000-pixel scope; the service keeps peaks
const SILENT_S = 3; // without a spoke, after which the banner says that the picture stands still
const DEAD_S = 15; // without a spoke, after which the page reconnects: a half-open connection reports no error
const BEHIND_S = 1; // from which on the page says so
const SYNCHRONISE_S = 5; // between two questions for the service's time, while the picture is not behind
const LIST_MS = 50; // in which all radars of a scene come and go
const IN_FLIGHT_S = 1; // after standby, in which the last spokes still arrive

const settings = loadSettings();
document.documentElement.dataset.palette = settings.palette;
const scope = new Scope(settings, addressValue("renderer"));
const preferences = new Preferences(scope, settingChanged);
const controls = new Controls(() => settings.unit, controlsChanged);
const playout = new Playout(show, () => controls.factor);
const page = { settings, scope, radar: null, origin: null, givesTruth: false, fidelity: "" }; // see panels.js
const panels = new Panels([controls, ...PANELS.map((panel) => panel(page))], element("feed"));
const changes = new Changes(follow);
const thinning = new Thinning();
const sequence = new SequenceTracker(); // counts since the page was opened, over all radars
const now = () => performance.now() / 1000;
let meter = new Meter();
let feed = null;
let shown = null; // id of the radar that the feed is of
let gone = ""; // why it has ended
let listing; // timer
let askedAt = 0; // page clock [s]: when the service was asked for its time
let requestsTruth = false; // in the address of the current connection
let connection = ["connecting", ""];
let isBroken = false; // the connection was lost and is not yet restored
let lastSpokeAt = now();
let latest = null; // own ship, time and scan, which the next frame shows
let retryNow = () => {}; // ends the wait before the next attempt to start
let standbySince = null; // page clock [s]
let isFirst = true; // no hello has arrived yet

function connectTo(id) {
  feed?.end();
  meter = new Meter();
  const feedUrl = (since) => {
    requestsTruth = page.givesTruth && settings.truth === "on";
    const { divisor, spokes } = thinning.view;
    return feedAddress(id, { bins: Math.ceil(BINS / divisor), spokes, compress: COMPRESSION }, since, requestsTruth);
  };
  sequence.startFeed();
  shown = id;
  feed = new Feed(feedUrl, { hello, spokes, truth, gap: () => {}, state, gone: listSoon }, sequence);
  feed.open();
}

/** Tells the panels of a change; a radar that comes or goes changes the list. */
function follow(change) {
  if (change.radar === page.radar?.id) panels.changed(change);
  const hasEnded = change.values.state === "ended";
  if (hasEnded && change.radar === shown) gone = change.values.fault;
  if (hasEnded || !isListed(change.radar)) listSoon();
}

/** Lists the radars, once for all that come and go together; shows the first one where that of this page has gone. */
function listSoon() {
  listing ??= setTimeout(async () => {
    listing = undefined;
    const radars = await callApi("radars").catch(() => []); // the feed reports a lost connection
    if (!radars.length) return;
    const { id } = listRadars(radars, connectTo, shown, gone);
    gone = "";
    if (id !== shown) connectTo(id);
  }, LIST_MS);
}

function hello(message, isNew, isRestart) {
  if (isRestart) {
    dismissAll();
    panels.tell("forget");
  }
  const { radar, fidelity } = message;
  Object.assign(page, { radar, fidelity, origin: message.scene.origin, givesTruth: message.truth });
  scope.stream = message.scene.stream ?? null;
  const isOther = message.encoding.bins !== scope.picture.polar.bins;
  if (isNew || isOther) playout.clear();
  if (isNew) scope.adopt(message);
  else if (isOther) scope.regrid(message);
  if (isNew) meter.restart(); // otherwise the service's clock goes on
  panels.tell("hello", message);
  lastSpokeAt = now();
  status.showHello(message);
  status.showThinned(thinning.level, message.encoding.bins, thinning.view.spokes);
  renameRadar(radar, message.scene);
  if (isFirst) adoptAddress(scope);
  isFirst = false;
  showFraming();
  requestTruth();
  if (isNew) status.announce(`Scene ${message.scene.name}`);
}

/** Reconnects with truth messages if the user selects them and the service gives them. */
function requestTruth() {
  const { givesTruth } = page;
  element("truth").disabled = !givesTruth;
  element("truth-row").title = givesTruth ? "Marks and names of all bodies, seen or not" : "This service does not send the truth; start it with --truth";
  if (givesTruth && settings.truth === "on" && !requestsTruth) feed.reconnect("");
}

function spokes(message) {
  scope.picture.polar.check(message);
  if (standbySince !== null && now() < standbySince + IN_FLIGHT_S) return;
  if (standbySince !== null) controls.refresh(); // another viewer transmits again
  lastSpokeAt = now();
  meter.spokes(message.count, message.time.at(-1), lastSpokeAt, controls.factor);
  playout.push(message, lastSpokeAt);
}

/** Shows spokes from <= k < to of a message, which are due. */
function show(message, from, to) {
  const { range } = scope.picture.grid;
  const ship = status.shipOf(message, to - 1, scope.ship);
  scope.write(message, from, to, ship);
  if (range !== message.range) showFraming();
  latest = { ship, time: message.time[to - 1], scan: message.scan };
}

function truth(message) {
  scope.truth = message;
  scope.changed = true;
}

function showFraming() {
  status.showRange(scope.scale, scope.framing, settings.unit);
  if (page.radar) followScope(scope, scaleFor(page.radar.range_max_m, settings.unit));
}

/** Blanks the picture when the radar goes to standby. */
function controlsChanged() {
  const isStandby = controls.state.transmit === false;
  if (isStandby && standbySince === null) {
    playout.clear();
    scope.blank();
  }
  standbySince = isStandby ? (standbySince ?? now()) : null;
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
  playout.release(time / 1000);
  scope.draw(time);
  status.showUnnamed(scope.layout.unnamed);
  if (latest) {
    if (scope.isTrueMotion) status.showRange(scope.scale, scope.framing, settings.unit);
    status.showShip(latest, page.origin, scope);
    showPositions();
    latest = null;
  }
}

function showPositions() {
  const { ship } = scope;
  const site = { position: ship.position, height: page.radar?.height_m ?? 0, origin: page.origin };
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

/** The warning of a service that is too slow, with its remedies; empty if it keeps its pace. */
function slowReason() {
  const { behind, factor, slower } = controls;
  if (behind === null) return "";
  const remedies = [slower && `set Speed to ${slower}`, page.fidelity !== "fast" && "start the server with --fidelity fast"];
  const text = remedies.filter(Boolean).join(", or ") || "take a smaller scene";
  return `Too slow: ${behind.toFixed(2)}× of ${factor}×. Remedy: ${text}`;
}

function spokePeriod() {
  const { radar } = page;
  return radar ? 60 / radar.rpm / radar.azimuths / (controls.factor ?? 1) : 0;
}

/** How far the picture is behind; empty while that is not worth a word. */
const behindReason = (lag) => (lag >= BEHIND_S ? `Behind by ${Math.round(lag)} s: the line or this computer is too slow` : "");

function showStatus() {
  const reason = stopReason();
  status.showBanner(reason || behindReason(meter.certainLag) || slowReason(), !reason, connection[0] === "waiting");
  if (feed) status.showFeed(feed.sequence, meter.rate(now()), meter.lag);
}

/** Asks the service for its simulated time, which tells how far the picture is behind. */
async function askTime() {
  const asked = (askedAt = now());
  const health = await callApi("health").catch(() => null); // the feed reports a lost connection
  const radar = health?.radars.find(({ id, epoch }) => id === shown && epoch === sequence.epoch);
  if (radar) meter.synchronise(radar.simulated_s, asked);
}

function everySecond() {
  showStatus();
  panels.tell("second");
  const idle = controls.paused || controls.state.transmit === false;
  if (idle) meter.restart(); // the service resets its clock when it continues
  else if (now() > askedAt + (meter.lag > BEHIND_S / 4 ? 1.5 : SYNCHRONISE_S)) askTime();
  if (connection[0] === "live" && thinning.takes(meter.certainLag, now())) feed.reconnect("", true);
  const dead = now() - lastSpokeAt > Math.max(DEAD_S, 20 * spokePeriod());
  if (connection[0] === "live" && !idle && dead) {
    lastSpokeAt = now();
    feed.reconnect("no message arrived");
  }
}

/** Applies a changed setting. */
function settingChanged(name) {
  panels.tell("settingChanged", name);
  if (name === "truth") {
    scope.truth = null;
    requestTruth();
  }
  showFraming();
  status.showMode(settings, scope.isTrueMotion);
  showPositions();
}

/** Connects at once. */
function tryNow() {
  retryNow();
  feed?.reconnect("");
}

/** Stores the token and reconnects: the service may allow more with it. */
function submitToken(event) {
  event.preventDefault();
  useToken(element("token").value);
  element("token").value = "";
  element("access").hidden = true;
  feed?.reconnect("the token has changed");
  retryNow();
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
  const selected = listRadars(radars, connectTo);
  controls.declare(selected.control_definitions);
  connectTo(selected.id);
  changes.open();
}

element("renderer-text").textContent = scope.renderer.name;
element("access").onsubmit = submitToken;
element("retry").onclick = tryNow;
bindKeys(controls, preferences);
bindPointer(scope, () => {
  showFraming();
  showPositions();
});
status.showMode(settings, scope.isTrueMotion);
document.addEventListener("token-required", () => (element("access").hidden = false));
addEventListener("online", () => connection[0] === "waiting" && feed?.reconnect("the network is back"));
setInterval(everySecond, 1000);
requestAnimationFrame(frame);
start();
