// One radar's feed: connects, reads, keeps the books, and comes back by itself when the line drops.

import { Ledger } from "./ledger.js";
import { decode } from "./msgpack.js";

const PROTOCOL = 1;
const LONGEST_WAIT_S = 10;

/** Seconds to wait before the attempt after `failures` failed ones; random in [0, 1) spreads the clients of a restarted server. */
export function backOff(failures, random) {
  return Math.min(0.5 * 2 ** failures, LONGEST_WAIT_S) * (0.75 + 0.5 * random);
}

export class Feed {
  /** address(since) gives the URL, or a promise of it. Handlers: hello(message, isNew), spokes(message), truth(message),
   *  gap(message), state(name, detail). */
  constructor(address, handlers) {
    this.address = address;
    this.handlers = handlers;
    this.ledger = new Ledger();
    this.failures = 0;
    this.ended = false;
    this.reason = "";
  }

  open() {
    clearTimeout(this.timer);
    const { epoch, next } = this.ledger;
    const since = epoch !== null && next !== null ? `${epoch}:${next}` : "";
    this.joining = true;
    this.reason = "";
    this.heard = performance.now();
    this.handlers.state("connecting", "");
    const dial = (this.dial = {}); // of several attempts only the last may come to something
    Promise.resolve(this.address(since)).then(
      (address) => this.dial === dial && this.connect(address),
      (fault) => this.dial === dial && this.closed(1006, fault.message),
    );
  }

  connect(address) {
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => this.socket === socket && this.receive(data);
    socket.onclose = ({ code, reason }) => this.socket === socket && this.closed(code, reason);
    this.socket = socket;
  }

  /** Ends this feed for good. */
  end() {
    this.ended = true;
    this.dial = null;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  /** Drops the line and dials again at once; reason: what went wrong, empty where nothing did. */
  redial(reason) {
    const old = this.socket;
    this.socket = null;
    old?.close();
    if (this.ended) return;
    if (reason) this.handlers.state("waiting", reason);
    this.open();
  }

  /** Seconds since anything was heard. */
  silence() {
    return (performance.now() - this.heard) / 1000;
  }

  receive(data) {
    if (this.ended) return; // a socket that is closing still hands over what it holds
    this.heard = performance.now();
    try {
      this.take(decode(data));
    } catch (fault) {
      console.error(fault);
      this.reason = `unreadable message: ${fault.message}`;
      this.socket.close();
    }
  }

  take(message) {
    if (message.type === "hello") return this.hello(message);
    if (message.type === "bye") this.reason = message.reason;
    if (message.epoch !== this.ledger.epoch) return; // of an epoch that no hello has opened
    if (message.type === "gap") {
      this.ledger.gap(message.first, message.count);
      this.handlers.gap(message);
    } else if (message.type === "truth") {
      this.handlers.truth(message);
    } else if (message.type === "spokes") {
      this.ledger.spokes(message.first, message.count);
      this.handlers.spokes(message);
      this.failures = 0; // only what could be used counts as a good line
    }
  }

  hello(message) {
    if (message.protocol !== PROTOCOL) {
      this.end();
      return this.handlers.state("refused", `the service speaks protocol ${message.protocol}, this page ${PROTOCOL}: reload it`);
    }
    const isNew = this.ledger.hello(message.epoch, this.joining);
    this.joining = false;
    this.handlers.state("live", "");
    this.handlers.hello(message, isNew);
  }

  closed(code, reason) {
    if (this.ended) return;
    const wait = backOff(this.failures++, Math.random());
    const why = this.reason || reason || (code === 1006 ? "" : `closed with code ${code}`); // 1006: the line went dead
    this.handlers.state("waiting", `${why ? `${why}; ` : ""}trying again in ${Math.ceil(wait)} s`);
    this.timer = setTimeout(() => this.open(), wait * 1000);
  }
}
