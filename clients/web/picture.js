// What is known of the echoes: cells and trails. They survive a change of range, and of the trails' motion and length.

import { Polar, spokesOf } from "./polar.js";
import { Trails } from "./trails.js";
import { TURN } from "./view.js";

const WIRE_TURN = 65_536; // wire units per revolution
const KEPT_SCANS = 4; // for which echoes beyond a shorter range are kept: own ship and targets move

/** Cells and trails out to one range. */
class Layer {
  /** grid {first, step, range}: of the cells [m]. */
  constructor(azimuths, bins, grid) {
    this.polar = new Polar(azimuths, bins);
    this.grid = grid;
    this.trails = null;
  }

  /** Starts trails of `length` [s], 0 for none, and takes the earlier ones over, or none. */
  startTrails(length, isTrue, earlier) {
    this.trails = length ? new Trails(length, isTrue, this.grid.range, this.polar.azimuths) : null;
    if (earlier) this.trails?.adopt(earlier);
  }

  /** Takes over what another layer knows. oldest: its earlier rows are left out [s]. */
  adopt(other, oldest) {
    this.polar.adopt(other.polar, this.grid, other.grid, oldest);
    if (other.trails) this.trails?.adopt(other.trails);
  }
}

export class Picture {
  /** settings: see settings.js. */
  constructor(settings) {
    this.settings = settings;
    this.layer = new Layer(4, 1, { first: 0.5, step: 1, range: 1000 });
    this.wide = null; // the layer with the longest range of this scene, while a shorter one is shown
    this.scene = "";
    this.period = 1; // of a scan [s]
    this.isBlank = true;
  }

  get polar() {
    return this.layer.polar;
  }

  get grid() {
    return this.layer.grid;
  }

  get trails() {
    return this.isBlank ? null : this.layer.trails;
  }

  /** Starts the picture of a new epoch: with what is known, if it is of the same radar in the same scene. */
  adopt({ radar, encoding, scene, seed, clocks }) {
    const title = JSON.stringify([radar.id, scene.name, radar.azimuths, seed]);
    const grid = { first: encoding.range_first_m, step: encoding.range_step_m, range: encoding.range_m };
    const known = title === this.scene ? [this.wide, this.layer].filter(Boolean) : [];
    this.scene = title;
    this.period = 60 / radar.rpm;
    this.layer = new Layer(radar.azimuths, encoding.bins, grid);
    this.startTrailsOf(this.layer, null);
    for (const { polar } of known) polar.setClock(clocks.simulated_s);
    const newest = Math.max(...known.map(({ polar }) => polar.newest || -Infinity));
    for (const layer of known) this.layer.adopt(layer, newest - KEPT_SCANS * this.period);
    this.wide = this.widest(known);
  }

  /** The known layer that reaches beyond the present one, with all that is known; null if none does. */
  widest([wide = null, narrow = null]) {
    const longest = narrow && narrow.grid.range < wide.grid.range ? wide : (narrow ?? wide);
    if (!longest || longest.grid.range <= this.grid.range) return null;
    if (longest === wide && narrow) wide.adopt(narrow, -Infinity);
    return longest;
  }

  /** Starts trails with the length and motion of the settings; keeps: with the echoes of the present ones. */
  startTrails(keeps = false) {
    for (const layer of [this.layer, this.wide]) if (layer) this.startTrailsOf(layer, keeps ? layer.trails : null);
  }

  startTrailsOf(layer, earlier) {
    const length = Number(this.settings.trails); // s, 0 for none
    layer.startTrails(length, this.settings.trailmotion === "true", earlier);
  }

  /** Blanks the echoes: the radar has stopped to transmit. Trails return with the next spokes. */
  blank() {
    this.polar.clear();
    this.wide = null;
    this.isBlank = true;
  }

  /** Adds spokes from <= k < to of a `spokes` message. */
  write(message, from, to) {
    this.polar.write(message, from, to);
    this.layer.grid = { first: message.range_first_m, step: message.range_step_m, range: message.range };
    this.isBlank = false;
    if (this.layer.trails) this.trail(message, from, to);
  }

  trail(message, from, to) {
    const { data, bins, azimuth, position, time, blind, row_first: first, row_count: count } = message;
    for (const [k, n] of spokesOf(message, from, to)) {
      if (blind?.[k]) continue;
      const video = data.subarray(k * bins, (k + 1) * bins);
      const off = first ? n - first[k] - (count[k] - 1) / 2 : 0; // spokes from the middle of those that are merged
      this.trails.spoke(video, (azimuth[k] / WIRE_TURN + off / this.polar.azimuths) * TURN, this.grid, position[k], time[k]);
    }
  }
}
