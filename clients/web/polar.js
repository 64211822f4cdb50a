// The picture in polar form: one row per azimuth from north, one column per range cell, and the age of each row.

export const MAX_ROWS = 4096; // 0.09 degrees: finer than a pixel at the rim of any screen; every GPU has such textures
const STALE_SCANS = 2.5; // without afterglow, older rows are not shown
const ROUNDING = 1e-6; // cells: an edge that falls on an edge covers nothing of the next cell

export class Polar {
  /** azimuths: spokes per scan; bins: cells per spoke. With more azimuths than MAX_ROWS, several share a row, which keeps
   *  the strongest echo. */
  constructor(azimuths, bins) {
    this.azimuths = azimuths;
    this.rows = Math.min(azimuths, MAX_ROWS);
    this.bins = bins;
    this.video = new Uint8Array(this.rows * bins);
    this.fade = new Uint8Array(this.rows); // 255: new, 0: invisible
    this.dirty = new Uint8Array(this.rows).fill(1);
    this.writtenAt = new Float64Array(this.rows).fill(NaN); // time of simulation [s]
    this.scan = new Float64Array(this.rows).fill(-1);
    this.newest = NaN;
  }

  /** Blanks all rows. */
  clear() {
    this.video.fill(0);
    this.dirty.fill(1);
    this.writtenAt.fill(NaN);
    this.scan.fill(-1);
    this.newest = NaN;
  }

  /** Takes over the cells of an earlier picture of as many azimuths, where that one has cells. own, others: {first, step} of
   *  the cells of this picture and of the earlier one [m]; oldest: earlier rows are left out [s]. */
  adopt(earlier, own, others, oldest = -Infinity) {
    if (earlier.azimuths !== this.azimuths) return;
    const edges = spans(this.bins, own, earlier.bins, others);
    for (let row = 0; row < this.rows; row++) {
      if (!(earlier.writtenAt[row] >= oldest)) continue; // NaN: never written
      const [from, to] = [row * earlier.bins, row * this.bins];
      for (let n = 0; 2 * n < edges.length; n++) {
        let level = 0;
        for (let k = edges[2 * n]; k < edges[2 * n + 1]; k++) level = Math.max(level, earlier.video[from + k]);
        this.video[to + n] = level;
      }
      this.writtenAt[row] = Math.max(earlier.writtenAt[row], this.writtenAt[row] || -Infinity);
      this.dirty[row] = 1;
    }
    this.newest = Math.max(earlier.newest, this.newest || -Infinity);
  }

  /** Sets the clock to `time` [s], where the simulation has started again: rows keep their age. */
  setClock(time) {
    const shift = time - this.newest;
    if (!(shift < 0)) return;
    this.writtenAt = this.writtenAt.map((then) => then + shift);
    this.newest = time;
  }

  /** Throws if the sizes in a `spokes` message contradict each other or the picture. */
  check({ bins, data, time }) {
    if (bins !== this.bins || data.length !== time.length * bins) {
      throw new Error(`spokes: ${data.length} bytes are not ${time.length} spokes of ${this.bins} bins`);
    }
  }

  /** Writes spokes from <= k < to of a `spokes` message of u8 video. */
  write(message, from = 0, to = message.time.length) {
    const { data, index, scan, time, blind, bins } = message;
    for (const [k, n] of spokesOf(message, from, to)) {
      const row = this.rowOf(index + n);
      const spoke = data.subarray(k * bins, (k + 1) * bins);
      if (blind?.[k]) this.video.fill(0, row * bins, (row + 1) * bins);
      else this.writeRow(row, spoke, this.scan[row] === scan);
      this.scan[row] = scan;
      this.writtenAt[row] = this.newest = time[k];
      this.dirty[row] = 1;
    }
  }

  rowOf(index) {
    return Math.floor(((index % this.azimuths) * this.rows) / this.azimuths);
  }

  writeRow(row, spoke, shared) {
    const start = row * this.bins;
    if (!shared || this.rows === this.azimuths) return this.video.set(spoke, start);
    for (let n = 0; n < this.bins; n++) if (spoke[n] > this.video[start + n]) this.video[start + n] = spoke[n];
  }

  /** Updates `fade` from the age of each row. period: of a scan [s]; halfLife: of the afterglow in scans, 0 for none. */
  age(period, halfLife) {
    for (let row = 0; row < this.rows; row++) {
      const scans = (this.newest - this.writtenAt[row]) / period; // NaN if the row was never written
      const fresh = halfLife ? 2 ** (-scans / halfLife) : Number(scans < STALE_SCANS);
      this.fade[row] = scans >= 0 ? Math.round(255 * fresh) : 0;
    }
  }

  /** The runs [start, stop) of rows written since the last call. */
  changes() {
    const runs = [];
    for (let row = 0; row < this.rows; row++) {
      if (!this.dirty[row]) continue;
      const start = row;
      while (row < this.rows && this.dirty[row]) this.dirty[row++] = 0;
      runs.push([start, row]);
    }
    return runs;
  }
}

/** Pairs of a row from <= k < to of a `spokes` message and the offset of each spoke that it stands for: of several where the
 *  feed merges them. */
export function* spokesOf({ row_first: first, row_count: count }, from, to) {
  for (let k = from; k < to; k++) {
    const begin = first ? first[k] : k;
    for (let n = 0; n < (count ? count[k] : 1); n++) yield [k, begin + n];
  }
}

/** Of each of `bins` cells the earlier cells from `start` to `stop` that it covers, in turn, as far as there are earlier
 *  ones. */
function spans(bins, { first, step }, earlierBins, earlier) {
  const edge = (range) => (range - earlier.first) / earlier.step + 0.5; // in cells: whole numbers are the edges of cells
  const edges = [];
  for (let n = 0; n < bins; n++) {
    const start = Math.max(Math.floor(edge(first + (n - 0.5) * step) + ROUNDING), 0);
    if (start >= earlierBins) break;
    const stop = Math.max(Math.ceil(edge(first + (n + 0.5) * step) - ROUNDING), start + 1);
    edges.push(start, Math.min(stop, earlierBins));
  }
  return Int32Array.from(edges);
}
