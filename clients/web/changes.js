// The changes of the radars' state, which the service sends as they happen.

import { socketAddress } from "./api.js";
import { backOff } from "./feed.js";

export class Changes {
  /** changed({radar, kind, values, time}): is called with each change; after each connection first with the whole state. */
  constructor(changed) {
    this.changed = changed;
    this.failures = 0;
  }

  async open() {
    const address = await socketAddress("changes").catch(() => null); // the feed reports a lost connection
    if (!address) return this.later();
    const socket = new WebSocket(address.href);
    socket.onmessage = ({ data }) => {
      this.failures = 0;
      const change = JSON.parse(data);
      if (change.kind) this.changed(change);
    };
    socket.onclose = () => this.later();
  }

  later() {
    setTimeout(() => this.open(), backOff(this.failures++, Math.random()) * 1000);
  }
}
