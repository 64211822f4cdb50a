// How fast spokes come in, and how much later than the promptest one.

const WINDOW_S = 2;

export class Meter {
  constructor() {
    this.batches = [];
    this.promptest = Infinity;
    this.lag = null;
  }

  /** count spokes arrived at `now` [s, page clock], the last one of simulated `time` [s]; factor: pace, null if unpaced. */
  spokes(count, time, now, factor) {
    this.batches.push([now, count]);
    if (!factor) return void (this.lag = null);
    const late = now - time / factor;
    this.promptest = Math.min(this.promptest, late);
    this.lag = late - this.promptest;
  }

  /** Forgets the promptest spoke: the clocks have been set anew (pace, epoch). */
  restart() {
    this.promptest = Infinity;
    this.lag = null;
  }

  /** Spokes per second over the last two seconds before `now` [s]. */
  rate(now) {
    while (this.batches.length && this.batches[0][0] < now - WINDOW_S) this.batches.shift();
    return this.batches.reduce((sum, [, count]) => sum + count, 0) / WINDOW_S;
  }
}
