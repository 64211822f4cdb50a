// Playout buffer: releases spokes evenly. Spokes arrive in bunches, so that the sweep would stutter if every spoke were shown
// on arrival. The buffer delays them a little and releases them by a steady clock.

const DELAY = 0.04; // s: two and a half frames, longer than the time between batches of 15 ms on an idle network
const RESET_DELAY = 0.25; // s above the smallest delay: the service has paused or fallen behind, and the clock is reset
const DRIFT_RATE = 1e-3; // s per s by which the smallest delay rises; the rates of two clocks differ by less

export class Playout {
  /** show(message, from, to): called when spokes from <= k < to of a message are due. factor(): simulated seconds per
   *  second, or null if the service runs as fast as possible. */
  constructor(show, factor) {
    this.show = show;
    this.factor = factor;
    this.clear();
  }

  /** Drops the waiting spokes, whose epoch has ended. */
  clear() {
    this.queue = [];
    this.minDelay = Infinity; // smallest arrival time minus simulated time / factor [s]
    this.lastArrival = -Infinity;
  }

  /** Adds a `spokes` message that arrived at `now` [s]. */
  push(message, now) {
    const factor = this.factor();
    const delay = factor ? now - message.time.at(-1) / factor : -Infinity; // spokes without a pace are due on arrival
    const expected = this.minDelay + DRIFT_RATE * Math.max(now - this.lastArrival, 0);
    this.minDelay = delay > expected + RESET_DELAY ? delay : Math.min(delay, expected);
    this.lastArrival = now;
    this.queue.push([message, 0]);
    this.release(now); // a hidden page draws no frames
  }

  /** Shows the spokes that are due at `now` [s]. */
  release(now) {
    const head = (now - this.minDelay - DELAY) * (this.factor() ?? 1); // simulated time that is due
    while (this.queue.length) {
      const [message, from] = this.queue[0];
      let to = from;
      while (to < message.time.length && message.time[to] <= head) to++;
      const isDone = to === message.time.length;
      if (isDone) this.queue.shift();
      else this.queue[0][1] = to; // before `show`, so that spokes on which it throws are not tried again
      if (to > from) this.show(message, from, to);
      if (!isDone) return;
    }
  }
}
