// The radar picture on the page: three stacked canvases (echoes, overlay, marks), redrawn after a change.

import { CanvasRenderer } from "./canvas.js";
import { Detail } from "./detail.js";
import { Framing } from "./framing.js";
import { begin, drawOverlay, drawMarks, overlayColours } from "./overlay.js";
import { echoColours, trailTint } from "./palette.js";
import { Picture } from "./picture.js";
import { stabilised } from "./stabilisation.js";
import { drawTruth, layTruth } from "./truth.js";
import { scaleFor } from "./units.js";
import { View, upOf } from "./view.js";
import { WebGLRenderer } from "./webgl.js";

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
    this.cursor = this.marker = this.truth = null;
    this.picture = new Picture(settings);
    this.written = "";
    this.layout = { marks: [], unnamed: 0 }; // of the truth
    this.sailed = false; // whether own ship's position is known
    this.stream = null; // of the water [east, north] [m/s], where the scene has one
    this.repaint();
    new ResizeObserver(() => this.fit()).observe(this.container);
    this.fit();
  }

  /** Starts the picture of a hello's epoch. */
  adopt(hello) {
    this.picture.adopt(hello);
    this.blindSectors = hello.radar.blind_sectors_deg ?? [];
    this.ship.azimuth = this.truth = null;
    this.sailed = false;
    this.framing.moveTo(this.framing.centre, this.view.reach);
    this.written = `${hello.epoch}:`;
    this.changed = true;
  }

  /** Goes on with cells of other sizes, as a hello says. */
  regrid(hello) {
    this.picture.adopt(hello);
    this.changed = true;
  }

  /** Starts new trails with the length and motion of the settings; keeps: with the echoes of the present ones. */
  startTrails(keeps) {
    this.picture.startTrails(keeps);
    this.changed = true;
  }

  /** Starts trails and true motion anew, over ground or through the water. */
  restartMotion() {
    this.startTrails(false);
    this.sailed = false;
  }

  /** The stream with which the picture drifts: null while it is stabilised by the ground. */
  get drift() {
    return this.settings.stabilisation === "sea" ? this.stream : null;
  }

  /** Blanks the picture: the radar is in standby. */
  blank() {
    this.picture.blank();
    this.ship.azimuth = null;
    this.changed = true;
  }

  /** Adds spokes from <= k < to of a `spokes` message; ship: own ship at the last of them. */
  write(message, from, to, ship) {
    const position = message.position.map((each, k) => stabilised(each, message.time[k], this.drift));
    this.picture.write({ ...message, position }, from, to);
    if (this.isTrueMotion && this.sailed) {
      const moved = position[to - 1].map((metres, axis) => metres - this.place[axis]);
      this.framing.follow(moved, ship.course, this.view);
    }
    this.sailed = true;
    this.place = position[to - 1];
    this.ship = ship;
    const { row_first: first, row_count: count } = message;
    this.written = `${message.epoch}:${message.first + (first ? first[to - 1] + count[to - 1] : to)}`;
    this.changed = true;
  }

  /** Whether the map stands still and own ship moves: only where north stays up. */
  get isTrueMotion() {
    return this.settings.motion === "true" && this.settings.orientation === "north-up";
  }

  /** The range [m] at the rim at zoom 1. */
  get scale() {
    return scaleFor(this.picture.grid.range, this.settings.unit);
  }

  get view() {
    const { width, height, settings, ship, picture, framing, scale } = this;
    const margin = width > 500 ? 33 : 30; // for the bearing scale and its numbers
    const up = upOf(settings.orientation, ship.heading, ship.course);
    const rim = { x: width / 2, y: height / 2, radius: Math.max(Math.min(width, height) / 2 - margin, 20) };
    return new View({ rim, range: picture.grid.range, scale, up, zoom: framing.zoom, centre: framing.centre });
  }

  fit() {
    this.pixels = window.devicePixelRatio || 1; // of the device, per CSS pixel
    this.width = this.container.clientWidth;
    this.height = this.container.clientHeight;
    this.detail.restart();
    for (const layer of ["echoes", "overlay", "marks"]) this.size(element(layer), this.pixels);
    this.overlayKey = "";
    this.changed = true;
    this.draw(performance.now()); // a canvas of another size is empty until then
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
      this.size(element("echoes"), this.pixels * this.detail.share);
    }
    if (!this.changed) return;
    const { view, settings, pixels, picture } = this;
    const { polar, grid, trails } = picture;
    polar.age(picture.period, Number(settings.afterglow));
    this.changed = Boolean(this.renderer.draw(polar, grid, view, trails, pixels * this.detail.share));
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
    const context = begin(element("marks"), this.pixels);
    const sweep = settings.sweep === "on" ? this.ship.azimuth : null;
    drawMarks(context, view, { sweep, marker: this.marker, cursor: this.cursor }, colours);
    this.layOut(context, view, settings.truth === "on" ? truth : null, this.drift);
    drawTruth(context, view, this.layout, colours);
  }

  /** Lays out marks and names of a truth message anew where it, the view or the labels of the rings have changed. */
  layOut(context, view, truth, drift) {
    const key = truth && JSON.stringify([view, this.labels, drift]);
    if (truth === this.laidTruth && key === this.layoutKey) return;
    [this.laidTruth, this.layoutKey] = [truth, key];
    this.layout = truth ? layTruth(context, view, truth, this.labels, drift ?? undefined) : { marks: [], unnamed: 0 };
  }

  updateOverlay(view) {
    const { settings, ship, pixels, blindSectors } = this;
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
    this.labels = drawOverlay(begin(element("overlay"), pixels), view, ship, this.colours, options);
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
