// Target trails: the time of the last echo in each cell of a square grid around own ship. In true motion the grid is fixed to
// the map and wraps at its edges: cells that fall behind own ship are cleared and reused ahead of it. In relative motion the
// grid moves with own ship. North is up in the grid; the renderer rotates it.

export const SIDE = 1024; // cells across the radar's range: a pixel or two of a big screen
export const TILE = 32; // cells along the side of a tile that is sent to the GPU
export const STAMPS = 255; // from 1 to 255, then again from 1; 0: no echo yet
export const LONGEST = 200; // stamps that a trail lasts; during the other 55, older cells are cleared
const LEVEL = 96; // of 255: weaker echoes, such as noise, leave no trail
const TURN = 2 * Math.PI;

const wrapCell = (cell) => ((cell % SIDE) + SIDE) % SIDE;

export class Trails {
  /** length: in simulated time [s]; isTrue: true motion, else relative; range: of the radar [m]; azimuths: in a scan. */
  constructor(length, isTrue, range, azimuths) {
    Object.assign(this, { isTrue, width: TURN / azimuths });
    this.cell = (2 * range) / SIDE; // m
    this.stampPeriod = length / LONGEST; // s between stamps
    this.stamps = new Uint8Array(SIDE * SIDE); // rows from south to north
    this.dirty = new Uint8Array((SIDE / TILE) ** 2).fill(1);
    this.own = [0, 0]; // of the grid: in relative motion it stays
    this.position = [0, 0]; // own ship's on the map
    this.track = new Float64Array(2 * (STAMPS + 1)); // own ship's position at each stamp
    this.tick = null;
  }

  /** The stamp of new echoes. */
  get stamp() {
    return this.tick === null ? 0 : 1 + (this.tick % STAMPS);
  }

  /** Adds a spoke of u8 video at a bearing [rad] and time [s]. Cell n is at range first + n step [m]; position: own ship's
   *  [m]. */
  spoke(video, bearing, { first, step }, position, time) {
    this.advance(Math.floor(time / this.stampPeriod));
    this.place(position);
    for (let n = 0; n < video.length; n++) {
      if (video[n] < LEVEL) continue;
      let to = n + 1;
      while (to < video.length && video[to] >= LEVEL) to++;
      this.stampRanges(bearing, first + (n - 0.5) * step, first + (to - 0.5) * step);
      n = to;
    }
  }

  /** Stamps the ranges from near to far [m] over the width of an azimuth. */
  stampRanges(bearing, near, far) {
    const { cell, stamps, dirty, own, stamp } = this;
    for (let range = Math.max(near, 0) + cell / 2; range < far + cell / 2; range += cell) {
      const distance = Math.min(range, far);
      const across = Math.max(1, Math.ceil((distance * this.width) / cell));
      for (let k = 0; k < across; k++) {
        const angle = bearing + ((k + 0.5) / across - 0.5) * this.width;
        const x = wrapCell(Math.floor((own[0] + distance * Math.sin(angle)) / cell));
        const y = wrapCell(Math.floor((own[1] + distance * Math.cos(angle)) / cell));
        stamps[y * SIDE + x] = stamp;
        dirty[tileOf(x, y)] = 1;
      }
    }
  }

  /** Notes own ship's position [east, north] [m] at the present stamp. */
  place(position) {
    this.position = position;
    this.track.set(position, 2 * this.stamp);
    if (this.isTrue) this.moveTo(position);
  }

  /** Takes over the echoes of earlier trails of another range, motion or length, each as old as it is there. */
  adopt(earlier) {
    if (earlier.tick === null) return;
    this.advance(Math.floor((earlier.tick * earlier.stampPeriod) / this.stampPeriod));
    this.place(earlier.position);
    const { ages, shifts } = this.convert(earlier);
    const offsets = [0, 1].map((axis) => Array.from({ length: SIDE }, (_, index) => earlier.offset(index, axis)));
    for (let cell = 0; cell < earlier.stamps.length; cell++) {
      const stamp = earlier.stamps[cell];
      if (!stamp || ages[stamp] > LONGEST) continue;
      const east = offsets[0][cell % SIDE] + shifts[2 * stamp];
      const north = offsets[1][Math.floor(cell / SIDE)] + shifts[2 * stamp + 1];
      this.fill(east, north, earlier.cell, ages[stamp]);
    }
  }

  /** For each earlier stamp its age [stamps of these trails], and by how much its echoes move [m, east and north]: by own
   *  ship's motion since, where one motion is true and the other relative. */
  convert(earlier) {
    const sign = Number(earlier.isTrue) - Number(this.isTrue);
    const ages = new Float64Array(STAMPS + 1);
    const shifts = earlier.track.map((then, k) => sign * (earlier.position[k % 2] - then));
    for (let stamp = 1; stamp <= STAMPS; stamp++) {
      const isLive = earlier.age(stamp) <= LONGEST;
      ages[stamp] = isLive ? Math.round((earlier.age(stamp) * earlier.stampPeriod) / this.stampPeriod) : Infinity;
      if (ages[stamp] > LONGEST) continue;
      this.track.set(earlier.track.subarray(2 * stamp, 2 * stamp + 2), 2 * this.stampOf(ages[stamp]));
    }
    return { ages, shifts };
  }

  /** Middle of a column (axis 0) or row (axis 1) of cells, east or north of own ship [m]. */
  offset(index, axis) {
    return (wrapCell(index + 0.5 - this.own[axis] / this.cell + SIDE / 2) - SIDE / 2) * this.cell;
  }

  /** Stamps a square of `side` [m] around a point east and north of own ship [m], where no younger echo is. */
  fill(east, north, side, age) {
    const { cell, own } = this;
    if (!(Math.max(Math.abs(east), Math.abs(north)) < (cell * SIDE) / 2)) return;
    const count = Math.max(1, Math.round(side / cell));
    const left = Math.floor((own[0] + east) / cell - (count - 1) / 2);
    const low = Math.floor((own[1] + north) / cell - (count - 1) / 2);
    const stamp = this.stampOf(age);
    for (let y = low; y < low + count; y++) {
      for (let x = left; x < left + count; x++) this.stampYounger(wrapCell(x), wrapCell(y), stamp, age);
    }
  }

  stampYounger(x, y, stamp, age) {
    const before = this.stamps[y * SIDE + x];
    if (!before || this.age(before) > age) this.setStamp(x, y, stamp);
  }

  /** The stamp of echoes of an age [stamps]. */
  stampOf(age) {
    return 1 + ((((this.tick - age) % STAMPS) + STAMPS) % STAMPS);
  }

  /** Advances the clock. Each tick clears old cells in some rows; all rows are cleared before the stamps repeat. */
  advance(tick) {
    if (this.tick === null || tick < this.tick || tick > this.tick + LONGEST) return this.restart(tick);
    const rows = Math.ceil(SIDE / (STAMPS - LONGEST - 1));
    for (; this.tick < tick; this.tick++) {
      for (let k = 0; k < rows; k++) this.clearOld(wrapCell(this.tick * rows + k));
    }
  }

  restart(tick) {
    this.tick = tick;
    this.stamps.fill(0);
    this.dirty.fill(1);
  }

  clearOld(y) {
    for (let x = 0; x < SIDE; x++) {
      const stamp = this.stamps[y * SIDE + x];
      if (stamp && this.age(stamp) > LONGEST) this.setStamp(x, y, 0);
    }
  }

  setStamp(x, y, stamp) {
    this.stamps[y * SIDE + x] = stamp;
    this.dirty[tileOf(x, y)] = 1;
  }

  age(stamp) {
    return (this.stamp - stamp + STAMPS) % STAMPS;
  }

  /** Moves own ship to [east, north] [m] and clears the columns and rows that the grid reuses ahead. */
  moveTo([east, north]) {
    const before = this.own.map((metres) => Math.floor(metres / this.cell));
    this.own = [east, north];
    const after = this.own.map((metres) => Math.floor(metres / this.cell));
    for (const axis of [0, 1]) {
      const moved = after[axis] - before[axis];
      for (let k = 0; k < Math.min(Math.abs(moved), SIDE); k++) {
        const line = wrapCell((moved > 0 ? before[axis] + k : before[axis] - k - 1) + SIDE / 2);
        for (let other = 0; other < SIDE; other++) this.setStamp(...(axis ? [other, line] : [line, other]), 0);
      }
    }
  }

  /** Own ship's position on the grid [cells]. The GPU's numbers have too few digits for positions on the map. */
  get origin() {
    return this.own.map((metres) => (((metres / this.cell) % SIDE) + SIDE) % SIDE);
  }

  /** Strength of the trail at a bearing [rad] and range [m]: from 1 for new to 0 for none. */
  at(bearing, range) {
    const x = wrapCell(Math.floor((this.own[0] + range * Math.sin(bearing)) / this.cell));
    const y = wrapCell(Math.floor((this.own[1] + range * Math.cos(bearing)) / this.cell));
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
