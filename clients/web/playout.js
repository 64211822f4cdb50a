// Hands spokes on evenly. They come in bunches, some frames with none and some with two; shown as they come the sweep
// would stutter. Held back a little and let go by a steady clock, every frame gets as many as have passed.

const DELAY = 0.04; // s: two frames and a half, more than batches of 15 ms are ever apart on an idle line
const ADRIFT = 0.25; // s later than the promptest: the service has paused or slipped, and its clock is taken anew
const CREEP = 1e-3; // s per s that the promptest is forgotten by: clocks differ by less, and lines get longer

export class Playout {
  /** show(message, from, to): spokes from <= k < to of a message are due; factor(): simulated seconds per second, or null
   *  where spokes come as fast as they can. */
  constructor(show, factor) {
    this.show = show;
    this.factor = factor;
    this.clear();
  }

  /** Drops what waits: its epoch is over. */
  clear() {
    this.queue = [];
    this.prompt = Infinity; // the least of arrival less simulated time / factor [s]
    this.at = -Infinity;
  }

  /** Takes a `spokes` message that came at `now` [s]. */
  push(message, now) {
    const factor = this.factor();
    const late = factor ? now - message.time.at(-1) / factor : -Infinity; // unpaced ones are due when they come
    const creeping = this.prompt + CREEP * Math.max(now - this.at, 0);
    this.prompt = late > creeping + ADRIFT ? late : Math.min(late, creeping);
    this.at = now;
    this.queue.push([message, 0]);
    this.release(now); // also where no frames are drawn because the page is hidden
  }

  /** Shows what is due at `now` [s]. */
  release(now) {
    const head = (now - this.prompt - DELAY) * (this.factor() ?? 1); // simulated time that is due
    while (this.queue.length) {
      const [message, from] = this.queue[0];
      let to = from;
      while (to < message.time.length && message.time[to] <= head) to++;
      const isDone = to === message.time.length;
      if (isDone) this.queue.shift();
      else this.queue[0][1] = to; // beforehand, so that what cannot be shown is not tried for ever
      if (to > from) this.show(message, from, to);
      if (!isDone) return;
    }
  }
}
