// Counts the spokes of a feed that were lost: announced, or missing without an announcement.

export class SequenceTracker {
  constructor() {
    this.epoch = null;
    this.next = null; // sequence number expected next; null accepts any
    this.forget();
  }

  /** Counts from zero: the feed that was counted has ended. */
  forget() {
    this.skips = false; // whether the next spokes are not the next ones, because the page did not wait for those between
    this.announced = 0; // lost, and announced by the feed
    this.missing = 0; // lost, and not announced
  }

  /** Counts on from another feed, of which it knows no number yet. */
  startFeed() {
    this.epoch = this.next = null;
  }

  /** Whether an epoch differs from the one that was counted last. */
  isOther(epoch) {
    return this.epoch !== null && epoch !== this.epoch;
  }

  get lost() {
    return this.announced + this.missing;
  }

  /** Adopts the epoch of a hello; returns true if it is new. joining: the hello is the first message of a connection. */
  hello(epoch, joining) {
    if (epoch === this.epoch) return false;
    this.epoch = epoch;
    this.next = joining ? null : 0; // an epoch counts from 0, but a client that connects later starts in its middle
    return true;
  }

  gap(first, count) {
    this.announced += count;
    this.next = Math.max(this.next ?? 0, first + count);
  }

  spokes(first, count) {
    const next = this.next ?? first;
    this[this.skips ? "announced" : "missing"] += Math.max(0, first - next);
    this.skips = false;
    this.next = Math.max(next, first + count);
  }
}
