// Scan conversion on the CPU, for browsers without WebGL2: the picture of webgl.js, with fewer pixels and frames.

import { TURN, wrap } from "./view.js";

const MAX_SIDE = 640; // pixels; 0.4 million lookups take some 10 ms in a browser
const PERIOD_MS = 80; // twelve pictures a second leave time for input

export class CanvasRenderer {
  name = "2D canvas";

  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.small = document.createElement("canvas");
    this.drawn = -Infinity;
    this.framingKey = "";
  }

  /** table: 256 RGBA colours by level; tint: of new trails, three shares. */
  setColours(table, tint) {
    this.colours = table;
    this.tint = tint.map((share) => 255 * share);
    this.drawn = -Infinity;
  }

  /** Draws `polar` in `view`. grid {first, step}: ranges of the samples [m]; trails: or null; scale: device pixels per CSS
   *  pixel. Returns true if it did not draw because the last picture is too recent. */
  draw(polar, grid, view, trails, scale) {
    const now = performance.now();
    const size = `${this.canvas.width} ${this.canvas.height}`;
    if (now - this.drawn < PERIOD_MS && size === this.size) return true; // a canvas of another size is empty
    this.size = size;
    this.drawn = now;
    const side = Math.min(Math.round(2 * view.rim.radius * scale), MAX_SIDE);
    this.prepare(side, view);
    this.fill(polar, grid, view, trails);
    this.small.getContext("2d").putImageData(this.image, 0, 0);
    this.paste(view, scale);
    return false;
  }

  paste(view, scale) {
    const { context, canvas } = this;
    const [x, y, r] = [view.rim.x * scale, view.rim.y * scale, view.rim.radius * scale];
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.save();
    context.beginPath();
    context.arc(x, y, r, 0, TURN);
    context.clip();
    context.drawImage(this.small, x - r, y - r, 2 * r, 2 * r);
    context.restore();
  }

  /** Computes bearing and range of each pixel of the small picture, once per framing. */
  prepare(side, view) {
    const framingKey = [side, view.metre, view.x - view.rim.x, view.y - view.rim.y].join();
    if (this.framingKey === framingKey) return;
    this.framingKey = framingKey;
    this.small.width = this.small.height = side;
    this.image = new ImageData(side, side);
    this.turn = new Float32Array(side * side); // clockwise from the top, in turns
    this.range = new Float32Array(side * side); // from own ship, m
    const pixel = (2 * view.rim.radius) / side; // CSS pixels
    for (let i = 0; i < side * side; i++) {
      const x = ((i % side) + 0.5 - side / 2) * pixel - (view.x - view.rim.x);
      const y = (side / 2 - Math.floor(i / side) - 0.5) * pixel + (view.y - view.rim.y);
      this.turn[i] = wrap(Math.atan2(x, y)) / TURN;
      this.range[i] = Math.hypot(x, y) / view.metre;
    }
    this.pixel = pixel / view.metre; // m
  }

  fill(polar, grid, view, trails) {
    const { colours, turn, range } = this;
    const { data } = this.image;
    const width = this.pixel / grid.step; // bins under a pixel
    for (let i = 0, out = 0; i < turn.length; i++, out += 4) {
      for (let c = 0; c < 4; c++) data[out + c] = colours[c];
      if (range[i] > view.range) continue;
      const bearing = wrap(turn[i] * TURN + view.up);
      if (trails) addTrail(data, out, this.tint, trails.at(bearing, range[i]));
      const v = (bearing / TURN) * polar.rows + (0.5 * polar.rows) / polar.azimuths - 0.5;
      addEcho(polar, colours, data, out, v, (range[i] - grid.first) / grid.step, width);
    }
  }
}

/** Mixes the colour of a trail into a pixel. trail: from 1 for new to 0 for none. */
function addTrail(pixels, out, tint, trail) {
  if (!trail) return;
  for (let c = 0; c < 3; c++) pixels[out + c] += (0.25 + 0.75 * trail) * (tint[c] - pixels[out + c]);
}

/** Mixes the echo at row v and column u of the polar picture into a pixel. v and u are fractional; row centres are whole. */
function addEcho(polar, colours, pixels, out, v, u, width) {
  const lower = Math.floor(v);
  const share = v - lower;
  const a = (lower + polar.rows) % polar.rows;
  const b = (a + 1) % polar.rows;
  const level = Math.round((1 - share) * levelAt(polar, a, u, width) + share * levelAt(polar, b, u, width));
  const fade = ((1 - share) * polar.fade[a] + share * polar.fade[b]) / 255;
  if (!level) return;
  for (let c = 0; c < 3; c++) pixels[out + c] += fade * (colours[4 * level + c] - pixels[out + c]);
}

/** The level of a row at column u: interpolated, or the strongest if one pixel covers several columns. */
function levelAt(polar, row, u, width) {
  const last = polar.bins - 1;
  const start = row * polar.bins;
  if (width <= 1) {
    const low = Math.min(Math.max(Math.floor(u), 0), last);
    const share = Math.min(Math.max(u - low, 0), 1);
    return (1 - share) * polar.video[start + low] + share * polar.video[start + Math.min(low + 1, last)];
  }
  const stop = Math.min(Math.round(u + width / 2), last);
  let level = 0;
  for (let n = Math.max(Math.round(u - width / 2), 0); n <= stop; n++) level = Math.max(level, polar.video[start + n]);
  return level;
}
