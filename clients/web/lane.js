// A lane of requests: changes are sent one at a time; changes in different lanes do not wait for each other.

export class Lane {
  /** send(change): sends a change; returns whether the radar has taken it. */
  constructor(send) {
    this.sendOne = send;
    this.waiting = null; // changes that no request has yet
    this.sending = null; // those of the present request
  }

  /** Values that were requested and not answered, by the name of their control. */
  get requested() {
    return { ...this.sending, ...this.waiting };
  }

  get busy() {
    return this.sending !== null || this.waiting !== null;
  }

  /** Sends a change. Changes during a request are collected; the newest value of each control is sent next. Returns whether
   *  the last one was taken; undefined where a request runs, which then sends this change, too. */
  async send(change) {
    this.waiting = { ...this.waiting, ...change };
    if (this.sending) return undefined;
    let isTaken = true;
    while (this.waiting) {
      [this.sending, this.waiting] = [this.waiting, null];
      isTaken = await this.sendOne(this.sending);
      this.sending = null;
    }
    return isTaken;
  }
}
