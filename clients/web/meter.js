// Measures the rate of spokes and their delay.

const WINDOW_S = 2;

export class Meter {
  constructor() {
    this.batches = [];
    this.restart();
  }

  /** Counts spokes that arrived at `now` [s, page clock]; the last has simulated `time` [s]. factor: pace, or null. */
  spokes(count, time, now, factor) {
    this.batches.push([now, count]);
    if (factor !== this.factor) this.restart();
    this.factor = factor;
    if (!factor) return void (this.lag = null);
    const delay = now - time / factor;
    this.minDelay = Math.min(this.minDelay, delay);
    this.lag = delay - this.minDelay;
  }

  /** Takes the simulated time [s] of the service, which was asked at `now` [s, page clock]: spokes of that time have no lag. The
   *  service may have lost time since it was asked last. */
  synchronise(time, now) {
    if (!this.factor) return;
    this.minDelay = now - time / this.factor;
    this.isSynchronised = true;
  }

  /** The lag by the service's time [s]; null until that is known: spokes of a burst come earlier than they are due. */
  get certainLag() {
    return this.isSynchronised ? this.lag : null;
  }

  /** Discards the smallest delay after the pace or the epoch changed. */
  restart() {
    this.minDelay = Infinity;
    this.lag = null;
    this.isSynchronised = false;
  }

  /** Spokes per second over the last two seconds before `now` [s]. */
  rate(now) {
    while (this.batches.length && this.batches[0][0] < now - WINDOW_S) this.batches.shift();
    return this.batches.reduce((sum, [, count]) => sum + count, 0) / WINDOW_S;
  }
}
