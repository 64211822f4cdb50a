// The picture as the antenna sees it: one row per azimuth from north, one column per range cell, and how fresh each row is.

export const MAX_ROWS = 4096; // 0.09 degrees: finer than a pixel at the rim of any screen, and within every GPU's texture limit
const STALE_SCANS = 2.5; // without afterglow a row that missed two scans is no longer shown as if it were fresh

export class Polar {
  /** azimuths: spokes per scan; bins: cells per spoke; more azimuths than MAX_ROWS share rows, the strongest echo wins. */
  constructor(azimuths, bins) {
    this.azimuths = azimuths;
    this.rows = Math.min(azimuths, MAX_ROWS);
    this.bins = bins;
    this.video = new Uint8Array(this.rows * bins);
    this.fade = new Uint8Array(this.rows); // 255 fresh, 0 gone
    this.dirty = new Uint8Array(this.rows).fill(1);
    this.seen = new Float64Array(this.rows).fill(NaN); // time of simulation [s]
    this.scan = new Float64Array(this.rows).fill(-1);
    this.newest = NaN;
  }

  /** Throws where the size of a `spokes` message contradicts itself or the picture's. */
  check({ bins, data, time }) {
    if (bins !== this.bins || data.length !== time.length * bins) {
      throw new Error(`spokes: ${data.length} bytes are not ${time.length} spokes of ${this.bins} bins`);
    }
  }

  /** Writes spokes from <= k < to of a `spokes` message of u8 video. */
  write(message, from = 0, to = message.time.length) {
    const { data, index, scan, time, blind, bins } = message;
    for (let k = from; k < to; k++) {
      const row = this.rowOf(index + k);
      const spoke = data.subarray(k * bins, (k + 1) * bins);
      if (blind?.[k]) this.video.fill(0, row * bins, (row + 1) * bins);
      else this.lay(row, spoke, this.scan[row] === scan);
      this.scan[row] = scan;
      this.seen[row] = this.newest = time[k];
      this.dirty[row] = 1;
    }
  }

  rowOf(index) {
    return Math.floor(((index % this.azimuths) * this.rows) / this.azimuths);
  }

  lay(row, spoke, shared) {
    const start = row * this.bins;
    if (!shared || this.rows === this.azimuths) return this.video.set(spoke, start);
    for (let n = 0; n < this.bins; n++) if (spoke[n] > this.video[start + n]) this.video[start + n] = spoke[n];
  }

  /** Updates `fade` from each row's age. period: of a scan [s]; halfLife: of the afterglow in scans, 0 for none. */
  age(period, halfLife) {
    for (let row = 0; row < this.rows; row++) {
      const scans = (this.newest - this.seen[row]) / period; // NaN where the row was never written
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
