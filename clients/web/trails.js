// Target trails: when each place last held an echo, on a square grid about own ship. In true motion the grid lies on the
// map and own ship moves over it (round the edges: what it leaves behind is wiped for what comes up ahead); in relative
// motion it goes with own ship. North up always; the screen turns it.

export const SIDE = 1024; // cells across the radar's range: a pixel or two of a big screen
export const TILE = 32; // cells across what is sent to the GPU at a time
export const STAMPS = 255; // 1 to 255 and round again; 0: no echo yet
export const LONGEST = 200; // stamps that a trail lasts; the 55 others are the time there is to wipe what is older
const LEVEL = 96; // of 255: strong enough to be a target, not a fleck of noise
const AROUND = 2 * Math.PI;

const onGrid = (cell) => ((cell % SIDE) + SIDE) % SIDE;

export class Trails {
  /** length: of simulated time [s]; isTrue: on the map, not about own ship; range: of the radar [m]; azimuths: of a scan. */
  constructor(length, isTrue, range, azimuths) {
    Object.assign(this, { isTrue, width: AROUND / azimuths });
    this.cell = (2 * range) / SIDE; // m
    this.unit = length / LONGEST; // s between stamps
    this.stamps = new Uint8Array(SIDE * SIDE); // rows from south to north
    this.dirty = new Uint8Array((SIDE / TILE) ** 2).fill(1);
    this.own = [0, 0];
    this.tick = null;
  }

  /** The stamp of what is new now. */
  get stamp() {
    return this.tick === null ? 0 : 1 + (this.tick % STAMPS);
  }

  /** Adds a spoke of u8 video at a bearing [rad]: cell n stands at first + n step [m]; own ship's position [m]; time [s]. */
  spoke(video, bearing, { first, step }, position, time) {
    this.advance(Math.floor(time / this.unit));
    if (this.isTrue) this.moveTo(position);
    for (let n = 0; n < video.length; n++) {
      if (video[n] < LEVEL) continue;
      let to = n + 1;
      while (to < video.length && video[to] >= LEVEL) to++;
      this.mark(bearing, first + (n - 0.5) * step, first + (to - 0.5) * step);
      n = to;
    }
  }

  /** Stamps the ranges from near to far [m] over the width of an azimuth. */
  mark(bearing, near, far) {
    const { cell, stamps, dirty, own, stamp } = this;
    for (let range = Math.max(near, 0) + cell / 2; range < far + cell / 2; range += cell) {
      const reach = Math.min(range, far);
      const across = Math.max(1, Math.ceil((reach * this.width) / cell));
      for (let k = 0; k < across; k++) {
        const angle = bearing + ((k + 0.5) / across - 0.5) * this.width;
        const x = onGrid(Math.floor((own[0] + reach * Math.sin(angle)) / cell));
        const y = onGrid(Math.floor((own[1] + reach * Math.cos(angle)) / cell));
        stamps[y * SIDE + x] = stamp;
        dirty[tileOf(x, y)] = 1;
      }
    }
  }

  /** Lets time pass: some rows at every tick are rid of what has become too old, all of them before stamps come round. */
  advance(tick) {
    if (this.tick === null || tick < this.tick || tick > this.tick + LONGEST) return this.restart(tick);
    const rows = Math.ceil(SIDE / (STAMPS - LONGEST - 1));
    for (; this.tick < tick; this.tick++) {
      for (let k = 0; k < rows; k++) this.wipeOld(onGrid(this.tick * rows + k));
    }
  }

  restart(tick) {
    this.tick = tick;
    this.stamps.fill(0);
    this.dirty.fill(1);
  }

  wipeOld(y) {
    for (let x = 0; x < SIDE; x++) {
      const place = y * SIDE + x;
      if (this.stamps[place] && this.age(this.stamps[place]) > LONGEST) this.put(x, y, 0);
    }
  }

  put(x, y, stamp) {
    this.stamps[y * SIDE + x] = stamp;
    this.dirty[tileOf(x, y)] = 1;
  }

  age(stamp) {
    return (this.stamp - stamp + STAMPS) % STAMPS;
  }

  /** Own ship goes to [east, north] [m]; the columns and rows that come into reach are wiped. */
  moveTo([east, north]) {
    const before = this.own.map((place) => Math.floor(place / this.cell));
    this.own = [east, north];
    const after = this.own.map((place) => Math.floor(place / this.cell));
    for (const axis of [0, 1]) {
      const moved = after[axis] - before[axis];
      for (let k = 0; k < Math.min(Math.abs(moved), SIDE); k++) {
        const line = onGrid((moved > 0 ? before[axis] + k : before[axis] - k - 1) + SIDE / 2);
        for (let other = 0; other < SIDE; other++) this.put(...(axis ? [other, line] : [line, other]), 0);
      }
    }
  }

  /** Own ship's place on the grid [cells], as sampled by the GPU, which has too few digits for places on the map. */
  get origin() {
    return this.own.map((place) => (((place / this.cell) % SIDE) + SIDE) % SIDE);
  }

  /** How fresh the trail is at a bearing [rad] and range [m]: from 1 for now to 0 for none. */
  at(bearing, range) {
    const x = onGrid(Math.floor((this.own[0] + range * Math.sin(bearing)) / this.cell));
    const y = onGrid(Math.floor((this.own[1] + range * Math.cos(bearing)) / this.cell));
    const stamp = this.stamps[y * SIDE + x];
    return stamp ? Math.max(0, 1 - this.age(stamp) / LONGEST) : 0;
  }

  /** The corners [x, y] of the tiles changed since the last call. */
  changes() {
    const corners = [];
    for (let tile = 0; tile < this.dirty.length; tile++) {
      if (!this.dirty[tile]) continue;
      this.dirty[tile] = 0;
      corners.push([(tile % (SIDE / TILE)) * TILE, Math.floor(tile / (SIDE / TILE)) * TILE]);
    }
    return corners;
  }
}

const tileOf = (x, y) => Math.floor(y / TILE) * (SIDE / TILE) + Math.floor(x / TILE);
