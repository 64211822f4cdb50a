// The radar picture on the page: three stacked canvases (echoes, overlay, marks), redrawn after a change.

import { CanvasRenderer } from "./canvas.js";
import { Detail } from "./detail.js";
import { Framing } from "./framing.js";
import { begin, drawOverlay, drawMarks, overlayColours } from "./overlay.js";
import { echoColours, trailTint } from "./palette.js";
import { Polar } from "./polar.js";
import { Trails } from "./trails.js";
import { drawTruth } from "./truth.js";
import { TURN, View, upOf } from "./view.js";
import { WebGLRenderer } from "./webgl.js";

const WIRE_TURN = 65_536; // wire units per revolution
const element = (id) => document.getElementById(id);

export class Scope {
  /** settings: see settings.js; rendererName: "canvas" forbids WebGL2. */
  constructor(settings, rendererName) {
    this.settings = settings;
    this.container = element("scope");
    this.renderer = chooseRenderer(rendererName, () => (this.changed = true));
    this.framing = new Framing();
    this.detail = new Detail();
    this.ship = { heading: 0, course: 0, azimuth: null, position: [0, 0] };
    this.blindSectors = [];
    this.cursor = this.marker = this.truth = this.trails = null;
    this.grid = { first: 0.5, step: 1, range: 1000 };
    this.polar = new Polar(4, 1);
    this.period = 1;
    this.written = "";
    this.repaint();
    new ResizeObserver(() => this.fit()).observe(this.container);
    this.fit();
  }

  /** Starts an empty picture with the size of a hello. */
  adopt(hello) {
    const { radar, encoding } = hello;
    this.polar = new Polar(radar.azimuths, encoding.bins);
    this.grid = { first: encoding.range_first_m, step: encoding.range_step_m, range: encoding.range_m };
    this.period = 60 / radar.rpm;
    this.blindSectors = radar.blind_sectors_deg ?? [];
    this.ship.azimuth = this.truth = null;
    this.framing.moveTo(this.framing.centre, encoding.range_m);
    this.written = `${hello.epoch}:`;
    this.startTrails();
  }

  /** Starts new trails with the length and motion of the settings. */
  startTrails() {
    const length = Number(this.settings.trails); // s, 0 for none
    const isTrue = this.settings.trailmotion === "true";
    this.trails = length ? new Trails(length, isTrue, this.grid.range, this.polar.azimuths) : null;
    this.changed = true;
  }

  /** Adds spokes from <= k < to of a `spokes` message; ship: own ship at the last of them. */
  write(message, from, to, ship) {
    this.polar.write(message, from, to);
    this.grid = { first: message.range_first_m, step: message.range_step_m, range: message.range };
    if (this.trails) this.trail(message, from, to);
    this.ship = ship;
    this.written = `${message.epoch}:${message.first + to}`;
    this.changed = true;
  }

  trail({ data, bins, azimuth, position, time, blind }, from, to) {
    for (let k = from; k < to; k++) {
      if (blind?.[k]) continue;
      const video = data.subarray(k * bins, (k + 1) * bins);
      this.trails.spoke(video, (azimuth[k] * TURN) / WIRE_TURN, this.grid, position[k], time[k]);
    }
  }

  get view() {
    const { width, height, settings, ship, grid, framing } = this;
    const margin = width > 500 ? 33 : 30; // for the bearing scale and its numbers
    const up = upOf(settings.orientation, ship.heading, ship.course);
    const rim = { x: width / 2, y: height / 2, radius: Math.max(Math.min(width, height) / 2 - margin, 20) };
    return new View({ rim, range: grid.range, up, zoom: framing.zoom, centre: framing.centre });
  }

  fit() {
    this.scale = window.devicePixelRatio || 1;
    this.width = this.container.clientWidth;
    this.height = this.container.clientHeight;
    this.detail.restart();
    for (const layer of ["echoes", "overlay", "marks"]) this.size(element(layer), this.scale);
    this.overlayKey = "";
    this.changed = true;
  }

  size(canvas, scale) {
    canvas.width = Math.round(this.width * scale);
    canvas.height = Math.round(this.height * scale);
  }

  /** Reads the colours of the palette and draws everything again. */
  repaint() {
    this.colours = overlayColours();
    this.renderer.setColours(echoColours(), trailTint());
    this.overlayKey = "";
    this.changed = true;
  }

  /** Draws the changes since the last call. time: of the frame [ms]. */
  draw(time) {
    if (this.adaptsDetail && this.detail.frame(time, this.changed)) {
      this.size(element("echoes"), this.scale * this.detail.share);
    }
    if (!this.changed) return;
    const { view, settings, scale, polar } = this;
    polar.age(this.period, Number(settings.afterglow));
    this.changed = Boolean(this.renderer.draw(polar, this.grid, view, this.trails, scale * this.detail.share));
    this.updateOverlay(view);
    this.updateMarks(view);
    if (!this.changed) this.container.dataset.drawn = this.written; // epoch and number of the next spoke
  }

  /** Whether the resolution of the echoes follows the frame rate. */
  get adaptsDetail() {
    return this.settings.detail === "auto" && this.renderer.name === "WebGL2";
  }

  updateMarks(view) {
    const { settings, truth, colours } = this;
    const context = begin(element("marks"), this.scale);
    const sweep = settings.sweep === "on" ? this.ship.azimuth : null;
    drawMarks(context, view, { sweep, marker: this.marker, cursor: this.cursor }, colours);
    if (truth && settings.truth === "on") drawTruth(context, view, truth, colours, this.labels);
  }

  updateOverlay(view) {
    const { settings, ship, scale, blindSectors } = this;
    const options = {
      unit: settings.unit,
      rings: settings.rings === "on",
      headline: settings.headline === "on",
      relative: settings.orientation === "head-up",
      blindSectors,
    };
    const key = JSON.stringify([view, ship.heading, options]);
    if (key === this.overlayKey) return;
    this.overlayKey = key;
    this.labels = drawOverlay(begin(element("overlay"), scale), view, ship, this.colours, options);
  }
}

function chooseRenderer(name, restored) {
  if (name === "canvas") return new CanvasRenderer(element("echoes"));
  try {
    return new WebGLRenderer(element("echoes"), restored);
  } catch (fault) {
    console.warn(`WebGL2 is not available (${fault.message}); drawing on a 2D canvas`);
    return new CanvasRenderer(freshCanvas());
  }
}

/** Replaces the canvas: once it had a WebGL context, it gives no 2D context. */
function freshCanvas() {
  const old = element("echoes");
  const fresh = old.cloneNode();
  old.replaceWith(fresh);
  return fresh;
}
