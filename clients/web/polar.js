// The picture in polar form: one row per azimuth from north, one column per range cell, and the age of each row.

export const MAX_ROWS = 4096; // 0.09 degrees: finer than a pixel at the rim of any screen; every GPU has such textures
const STALE_SCANS = 2.5; // without afterglow, older rows are not shown

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

  /** Throws if the sizes in a `spokes` message contradict each other or the picture. */
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
