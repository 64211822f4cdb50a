// How fine the echoes are drawn: as fine as the screen, or coarser where their frames would come too late.

const SHARES = [1, 0.7, 0.5]; // of the screen's pixels, along each side
const LATE_MS = 20; // between frames, on average; a screen of 60 Hz leaves 16.7
const WATCHED_MS = 1500; // of frames that draw, before anything is changed
const PAUSE_MS = 250; // since the last frame: the page was hidden, or has had something else to do
const AGAIN_MS = 60_000; // after which a coarse picture is tried finer; twice as long each time
const WORTH = 0.9; // of the time before: what a coarser picture must save, or something else is slow

export class Detail {
  constructor() {
    this.restart();
  }

  /** Of the screen's pixels, along each side. */
  get share() {
    return SHARES[this.level];
  }

  /** As fine as the screen again, and watched anew. */
  restart() {
    this.level = 0;
    this.last = null;
    this.patience = AGAIN_MS;
    this.watch(null);
  }

  /** A frame at `time` [ms] was drawn, or needed no drawing; true where the share has changed. */
  frame(time, drawn) {
    const gap = this.last === null ? Infinity : time - this.last;
    this.last = time;
    if (!drawn || gap > PAUSE_MS) return this.forget();
    this.spent += gap;
    this.frames += 1;
    if (this.until !== null) return time > this.until && this.tryAgain();
    return this.spent >= WATCHED_MS && this.judge(time, this.spent / this.frames);
  }

  /** mean: between frames [ms]. */
  judge(time, mean) {
    const { before } = this;
    this.watch(null);
    if (before !== null && mean > WORTH * before) return this.rest(time, this.level - 1);
    if (mean <= LATE_MS) return this.level ? this.rest(time, this.level) : false;
    if (this.level === SHARES.length - 1) return this.rest(time, this.level);
    this.level += 1;
    this.watch(mean);
    return true;
  }

  /** Stays at a level for a while. */
  rest(time, level) {
    const changed = level !== this.level;
    this.level = level;
    this.until = time + this.patience;
    this.patience *= 2;
    return changed;
  }

  tryAgain() {
    const changed = this.level > 0;
    this.level = 0;
    this.watch(null);
    return changed;
  }

  /** before: mean time between frames at the level above [ms], null where there was none. */
  watch(before) {
    this.before = before;
    this.until = null;
    this.forget();
  }

  forget() {
    this.spent = this.frames = 0;
    return false;
  }
}
