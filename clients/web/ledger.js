// Keeps the books of a feed: which spokes came, which were announced as lost, and which are simply missing.

export class Ledger {
  constructor() {
    this.epoch = null;
    this.next = null; // sequence number expected next; null where any will do
    this.received = 0;
    this.announced = 0; // lost, and the feed said so
    this.missing = 0; // lost, and nobody said so
    this.repeated = 0;
  }

  get lost() {
    return this.announced + this.missing;
  }

  /** A hello: true where it opens a new epoch. `joining`: it is the first message of a connection. */
  hello(epoch, joining) {
    if (epoch === this.epoch) return false;
    this.epoch = epoch;
    this.next = joining ? null : 0; // a new epoch counts from 0, but who joins late enters in the middle
    return true;
  }

  gap(first, count) {
    this.announced += count;
    this.next = Math.max(this.next ?? 0, first + count);
  }

  spokes(first, count) {
    const next = this.next ?? first;
    this.missing += Math.max(0, first - next);
    this.repeated += Math.min(count, Math.max(0, next - first));
    this.received += count;
    this.next = Math.max(next, first + count);
  }
}
