// Chooses the resolution of the echoes: that of the screen, or a lower one if frames take too long.

const SHARES = [1, 0.7, 0.5]; // of the screen's pixels, along each side
const LATE_MS = 20; // mean time between frames; a screen of 60 Hz has 16.7
const SAMPLE_MS = 1500; // time of drawn frames in a measurement
const PAUSE_MS = 250; // a longer time between frames means that the page was hidden or busy
const RETRY_MS = 60_000; // until full resolution is tried again; doubles each time
const MAX_TIME_RATIO = 0.9; // of the mean time before; if a lower resolution saves less, the cause is elsewhere

export class Detail {
  constructor() {
    this.restart();
  }

  /** Share of the screen's pixels that is drawn, along each side. */
  get share() {
    return SHARES[this.level];
  }

  /** Returns to full resolution and measures anew. */
  restart() {
    this.level = 0;
    this.last = null;
    this.patience = RETRY_MS;
    this.startSample(null);
  }

  /** Counts a frame at `time` [ms]; drawn: whether it needed drawing. Returns true if the share has changed. */
  frame(time, drawn) {
    const gap = this.last === null ? Infinity : time - this.last;
    this.last = time;
    if (!drawn || gap > PAUSE_MS) return this.discardSample();
    this.elapsed += gap;
    this.frames += 1;
    if (this.until !== null) return time > this.until && this.retry();
    return this.elapsed >= SAMPLE_MS && this.judge(time, this.elapsed / this.frames);
  }

  /** Lowers the resolution, keeps it or restores it. mean: time between frames [ms]. */
  judge(time, mean) {
    const { before } = this;
    this.startSample(null);
    if (before !== null && mean > MAX_TIME_RATIO * before) return this.hold(time, this.level - 1);
    if (mean <= LATE_MS) return this.level ? this.hold(time, this.level) : false;
    if (this.level === SHARES.length - 1) return this.hold(time, this.level);
    this.level += 1;
    this.startSample(mean);
    return true;
  }

  /** Keeps a level until the next retry. */
  hold(time, level) {
    const changed = level !== this.level;
    this.level = level;
    this.until = time + this.patience;
    this.patience *= 2;
    return changed;
  }

  retry() {
    const changed = this.level > 0;
    this.level = 0;
    this.startSample(null);
    return changed;
  }

  /** Starts a measurement. before: mean time between frames at the level above [ms], or null. */
  startSample(before) {
    this.before = before;
    this.until = null;
    this.discardSample();
  }

  discardSample() {
    this.elapsed = this.frames = 0;
    return false;
  }
}
