// Decides how much of the feed the page asks for: as much as arrives, and as the page can draw.

/** Views of the feed: the part of the bins, the spokes that are merged, and the bytes as a share of the first view's, which
 *  were measured of spokes of 2502 bins. What messages have beside their samples is the rest of the last one. */
export const VIEWS = [[1, 1, 1], [2, 1, 0.7], [4, 1, 0.6], [4, 2, 0.47], [4, 4, 0.36], [8, 8, 0.33]].map(
  ([divisor, spokes, share]) => ({ divisor, spokes, share }),
);
const LATE_S = 0.5; // behind, from which on a feed that falls further behind is thinned
const FALLS = 0.1; // s per s by which it does so
const STANDING_S = 1; // behind, which does not last longer than
const STANDS_S = 10; // without a thinner view
const HOPELESS_S = 5; // behind, from which on the thinnest view is begun anew without what waits
const ROOM = 0.9; // of what arrives: the rest lets the feed catch up
const SETTLE_S = 4; // for a connection to begin; browsers read the one before for 2 s more
const CALM_S = 20; // without delay, after which a finer view is tried
const CALM_LAG_S = 0.2;
const TRIAL_S = 15; // within which a finer view that is too much shows
const MAX_CALM_S = 640;

export class Thinning {
  constructor() {
    this.level = 0; // of VIEWS
    this.patience = CALM_S;
    this.triedAt = this.changedAt = -Infinity; // page clock [s]
    this.forget();
  }

  get view() {
    return VIEWS[this.level];
  }

  /** Forgets the delays so far: those to come are not compared with them. */
  forget() {
    this.before = this.calmSince = this.lateSince = null;
  }

  /** Takes how far the picture is behind [s] at `now` [s], once a second; null: not known. Returns whether to connect anew, with
   *  `view` and without what waits. */
  takes(lag, now) {
    const { before, level } = this;
    if (lag === null) this.forget();
    else this.before = { lag, now };
    if (lag === null || !before || now < this.changedAt + SETTLE_S) return false;
    const falls = (lag - before.lag) / (now - before.now); // s behind per s
    this.calmSince = lag > CALM_LAG_S ? null : (this.calmSince ?? now);
    this.lateSince = lag > STANDING_S ? (this.lateSince ?? now) : null;
    const stands = this.lateSince !== null && now >= this.lateSince + STANDS_S;
    if (level === VIEWS.length - 1 ? lag > HOPELESS_S && stands : stands || (lag > LATE_S && falls > FALLS)) {
      if (now < this.triedAt + TRIAL_S) this.patience = Math.min(2 * this.patience, MAX_CALM_S);
      return this.change(this.thinner(1 - falls), now);
    }
    if (!level || this.calmSince === null || now < this.calmSince + this.patience) return false;
    this.triedAt = now;
    return this.change(level - 1, now);
  }

  /** The next level that fits into a share of the present view, which has arrived. */
  thinner(arrived) {
    const room = this.view.share * Math.min(Math.max(arrived, 0), 1) * ROOM;
    const fits = VIEWS.findIndex(({ share }, level) => level > this.level && share <= room);
    return fits < 0 ? VIEWS.length - 1 : fits;
  }

  change(level, now) {
    this.level = level;
    this.changedAt = now;
    this.forget();
    return true;
  }
}
