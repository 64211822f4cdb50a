// The radar picture on the page: three stacked canvases (echoes, furniture, marks), redrawn when something changed.

import { CanvasRenderer } from "./canvas.js";
import { begin, drawFurniture, drawMarks, furnitureColours } from "./overlay.js";
import { echoColours } from "./palette.js";
import { Polar } from "./polar.js";
import { View, upOf } from "./view.js";
import { WebGLRenderer } from "./webgl.js";

const element = (id) => document.getElementById(id);

export class Scope {
  /** settings: as loaded; wanted: "canvas" to do without WebGL2. */
  constructor(settings, wanted) {
    this.settings = settings;
    this.place = element("scope");
    this.renderer = chooseRenderer(wanted, () => (this.changed = true));
    this.ship = { heading: 0, course: 0, azimuth: null };
    this.blindSectors = [];
    this.cursor = this.marker = null;
    this.grid = { first: 0.5, step: 1, range: 1000 };
    this.polar = new Polar(4, 1);
    this.period = 1;
    this.written = "";
    this.repaint();
    new ResizeObserver(() => this.fit()).observe(this.place);
    this.fit();
  }

  /** Starts a blank picture of a hello's shape. */
  adopt(hello) {
    const { radar, encoding } = hello;
    this.polar = new Polar(radar.azimuths, encoding.bins);
    this.grid = { first: encoding.range_first_m, step: encoding.range_step_m, range: encoding.range_m };
    this.period = 60 / radar.rpm;
    this.blindSectors = radar.blind_sectors_deg ?? [];
    this.ship.azimuth = null;
    this.written = `${hello.epoch}:`;
    this.changed = true;
  }

  /** Adds a `spokes` message; ship: own ship at its last spoke. */
  write(message, ship) {
    this.polar.write(message);
    this.grid = { first: message.range_first_m, step: message.range_step_m, range: message.range };
    this.ship = ship;
    this.written = `${message.epoch}:${message.first + message.count}`;
    this.changed = true;
  }

  get view() {
    const { side, settings, ship, grid } = this;
    const margin = side > 500 ? 33 : 28; // bearing scale and its figures
    const up = upOf(settings.orientation, ship.heading, ship.course);
    return new View({ x: side / 2, y: side / 2, radius: Math.max(side / 2 - margin, 20), range: grid.range, up });
  }

  fit() {
    this.scale = window.devicePixelRatio || 1;
    this.side = this.place.clientWidth;
    const pixels = Math.round(this.side * this.scale);
    for (const layer of ["echoes", "furniture", "marks"]) element(layer).width = element(layer).height = pixels;
    this.furnished = "";
    this.changed = true;
  }

  /** Takes the colours anew from the style sheet. */
  repaint() {
    this.colours = furnitureColours();
    this.renderer.setColours(echoColours());
    this.furnished = "";
    this.changed = true;
  }

  /** Draws what changed since the last call. */
  draw() {
    if (!this.changed) return;
    const { view, settings, scale, polar } = this;
    polar.age(this.period, Number(settings.afterglow));
    this.changed = Boolean(this.renderer.draw(polar, this.grid, view, scale));
    this.furnish(view);
    const sweep = settings.sweep === "on" ? this.ship.azimuth : null;
    drawMarks(begin(element("marks"), scale), view, { sweep, marker: this.marker, cursor: this.cursor }, this.colours);
    if (!this.changed) this.place.dataset.drawn = this.written; // the epoch and the next number after what is on the screen
  }

  furnish(view) {
    const { settings, ship, scale, blindSectors } = this;
    const options = {
      unit: settings.unit,
      rings: settings.rings === "on",
      headline: settings.headline === "on",
      relative: settings.orientation === "head-up",
      blindSectors,
    };
    const key = JSON.stringify([view, ship.heading, options]);
    if (key === this.furnished) return;
    this.furnished = key;
    drawFurniture(begin(element("furniture"), scale), view, ship, this.colours, options);
  }
}

function chooseRenderer(wanted, restored) {
  if (wanted === "canvas") return new CanvasRenderer(element("echoes"));
  try {
    return new WebGLRenderer(element("echoes"), restored);
  } catch (fault) {
    console.warn(`WebGL2 does not serve (${fault.message}); drawing on a 2D canvas`);
    return new CanvasRenderer(freshCanvas());
  }
}

/** A canvas that once gave a WebGL context gives no other kind: put a new one in its place. */
function freshCanvas() {
  const old = element("echoes");
  const fresh = old.cloneNode();
  old.replaceWith(fresh);
  return fresh;
}
