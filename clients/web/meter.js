// How fast spokes come in, and how much later than the promptest one.

const WINDOW_S = 2;
const MEMORY_S = 10; // that the promptest is remembered for, twice at most: a service that is too slow falls back for good

export class Meter {
  constructor() {
    this.batches = [];
    this.restart();
  }

  /** count spokes arrived at `now` [s, page clock], the last one of simulated `time` [s]; factor: pace, null if unpaced. */
  spokes(count, time, now, factor) {
    this.batches.push([now, count]);
    if (!factor) return void (this.lag = null);
    if (now > this.turned + MEMORY_S) {
      [this.before, this.promptest] = [this.promptest, Infinity];
      this.turned = now;
    }
    const late = now - time / factor;
    this.promptest = Math.min(this.promptest, late);
    this.lag = late - Math.min(this.promptest, this.before);
  }

  /** Forgets the promptest spoke: the clocks have been set anew (pace, epoch). */
  restart() {
    this.promptest = this.before = Infinity;
    this.turned = -Infinity;
    this.lag = null;
  }

  /** Spokes per second over the last two seconds before `now` [s]. */
  rate(now) {
    while (this.batches.length && this.batches[0][0] < now - WINDOW_S) this.batches.shift();
    return this.batches.reduce((sum, [, count]) => sum + count, 0) / WINDOW_S;
  }
}

/** How many frames a second are drawn, and how long the page works on each. */
export class FrameMeter {
  constructor() {
    this.frames = [];
  }

  /** A frame was begun at `start` and finished at `end` [s]. */
  frame(start, end) {
    this.frames.push([start, end - start]);
    while (this.frames[0][0] < start - WINDOW_S) this.frames.shift();
  }

  /** {rate: frames per second, work: seconds of each} over the two seconds before `now` [s]; null without any. */
  figures(now) {
    const recent = this.frames.filter(([start]) => start > now - WINDOW_S);
    if (recent.length < 2) return null;
    const span = recent.at(-1)[0] - recent[0][0];
    return { rate: (recent.length - 1) / span, work: recent.reduce((sum, [, work]) => sum + work, 0) / recent.length };
  }
}
