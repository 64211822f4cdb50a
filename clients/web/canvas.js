// Scan conversion on the CPU, for browsers without WebGL2: the same picture as webgl.js, coarser and fewer times a second.

import { TURN, wrap } from "./view.js";

const MAX_SIDE = 640; // pixels; 0.4 million lookups take some 10 ms in a browser
const PERIOD_MS = 80; // twelve pictures a second leave the page time to answer

export class CanvasRenderer {
  name = "2D canvas";

  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.small = document.createElement("canvas");
    this.drawn = -Infinity;
    this.shape = "";
  }

  /** table: 256 RGBA colours by level. */
  setColours(table) {
    this.colours = table;
    this.drawn = -Infinity;
  }

  /** Draws `polar` as `view` sees it; grid {first, step}: where the samples stand [m]; scale: device pixels per CSS pixel.
   * True where nothing was drawn yet because the last picture is too recent. */
  draw(polar, grid, view, scale) {
    const now = performance.now();
    if (now - this.drawn < PERIOD_MS) return true;
    this.drawn = now;
    const side = Math.min(Math.round(2 * view.radius * scale), MAX_SIDE);
    this.prepare(side);
    this.fill(polar, grid, view, side);
    const small = this.small.getContext("2d");
    small.putImageData(this.image, 0, 0);
    this.paste(view, scale);
    return false;
  }

  paste(view, scale) {
    const { context, canvas } = this;
    const [x, y, r] = [view.x * scale, view.y * scale, view.radius * scale];
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.save();
    context.beginPath();
    context.arc(x, y, r, 0, TURN);
    context.clip();
    context.drawImage(this.small, x - r, y - r, 2 * r, 2 * r);
    context.restore();
  }

  prepare(side) {
    if (this.shape === side) return;
    this.shape = side;
    this.small.width = this.small.height = side;
    this.image = new ImageData(side, side);
    this.turn = new Float32Array(side * side); // clockwise from the top, in turns
    this.far = new Float32Array(side * side); // from the centre, 1 at the rim
    for (let i = 0; i < side * side; i++) {
      const x = (2 * ((i % side) + 0.5)) / side - 1;
      const y = 1 - (2 * (Math.floor(i / side) + 0.5)) / side;
      this.turn[i] = wrap(Math.atan2(x, y)) / TURN;
      this.far[i] = Math.hypot(x, y);
    }
  }

  fill(polar, grid, view, side) {
    const { colours, turn, far, image } = this;
    const width = (2 * view.range) / side / grid.step; // bins under a pixel
    const up = wrap(view.up) / TURN + 0.5 / polar.azimuths;
    for (let i = 0, out = 0; i < turn.length; i++, out += 4) {
      if (far[i] > 1.01) continue; // beyond the clip; a margin for the pixels that it cuts
      const v = (turn[i] + up) * polar.rows - 0.5;
      const u = (far[i] * view.range - grid.first) / grid.step;
      blend(polar, colours, image.data, out, v, u, width);
    }
  }
}

/** Writes the colour at row v and column u (both fractional; row centres are whole) of the polar picture. */
function blend(polar, colours, pixels, out, v, u, width) {
  const below = Math.floor(v);
  const share = v - below;
  const a = (below + polar.rows) % polar.rows;
  const b = (a + 1) % polar.rows;
  const level = Math.round((1 - share) * levelAt(polar, a, u, width) + share * levelAt(polar, b, u, width));
  const fade = ((1 - share) * polar.fade[a] + share * polar.fade[b]) / 255;
  for (let c = 0; c < 3; c++) pixels[out + c] = colours[c] + fade * (colours[4 * level + c] - colours[c]);
  pixels[out + 3] = 255;
}

/** The level of a row at column u: interpolated, or the strongest where several columns fall under one pixel. */
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
