// One radar's feed: connects, reads messages, counts spokes, and reconnects after a break.

import { SequenceTracker } from "./sequence.js";
import { decode } from "./msgpack.js";

/** The compression that the page asks for: zstd is not known to all browsers. */
export const COMPRESSION = typeof DecompressionStream === "undefined" ? "none" : "deflate";

const PROTOCOL = 1;
const MAX_WAIT_S = 10;

/** Wait [s] before the next attempt after `failures` failures. random in [0, 1) spreads the clients of a restarted server. */
export function backOff(failures, random) {
  return Math.min(0.5 * 2 ** failures, MAX_WAIT_S) * (0.75 + 0.5 * random);
}

/** Decompresses the samples of a message, where they are compressed. */
async function inflated(message) {
  if (!message?.compression) return;
  const stream = new Blob([message.data]).stream().pipeThrough(new DecompressionStream(message.compression));
  message.data = new Uint8Array(await new Response(stream).arrayBuffer());
}

export class Feed {
  /** address(since): returns the URL or a promise of it. Handlers: hello(message, isNew, isRestart), spokes(message), truth(message),
   *  gap(message), state(name, detail), gone(). sequence: counts the spokes. */
  constructor(address, handlers, sequence = new SequenceTracker()) {
    this.address = address;
    this.handlers = handlers;
    this.sequence = sequence;
    this.failures = 0;
    this.ended = false;
    this.reason = "";
  }

  open() {
    clearTimeout(this.timer);
    const { epoch, next } = this.sequence;
    const since = epoch !== null && next !== null && !this.sequence.skips ? `${epoch}:${next}` : "";
    this.joining = true;
    this.reason = "";
    this.handlers.state("connecting", "");
    const attempt = (this.attempt = {}); // only the newest attempt may connect
    Promise.resolve(this.address(since)).then(
      (address) => this.attempt === attempt && this.connect(address),
      (fault) => this.attempt === attempt && this.closed(1006, fault.message),
    );
  }

  connect(address) {
    const socket = new WebSocket(address);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => this.socket === socket && this.receive(data);
    socket.onclose = ({ code, reason }) => this.inTurn(null, () => this.socket === socket && this.closed(code, reason));
    this.socket = socket;
    this.reading = null; // what is done after the message that is being decompressed; null: none is
  }

  /** Ends this feed for good. */
  end() {
    this.ended = true;
    this.attempt = null;
    clearTimeout(this.timer);
    this.socket?.close();
  }

  /** Closes the connection and opens a new one at once. reason: what went wrong, or empty; skips: without the spokes until then. */
  reconnect(reason, skips = false) {
    this.sequence.skips ||= skips;
    const old = this.socket;
    this.socket = null;
    old?.close();
    if (this.ended) return;
    if (reason) this.handlers.state("waiting", reason);
    this.open();
  }

  receive(data) {
    if (this.ended) return; // a closing socket still delivers messages
    const { socket } = this;
    const fail = (fault) => {
      console.error(fault);
      this.reason = `unreadable message: ${fault.message}`;
      socket.close();
    };
    try {
      const message = decode(data);
      this.inTurn(message, () => this.socket === socket && this.take(message), fail);
    } catch (fault) {
      fail(fault);
    }
  }

  /** Acts at once, or after the messages before, as soon as the samples of `message` are decompressed. */
  inTurn(message, act, fail) {
    if (!this.reading && !message?.compression) return act();
    const before = this.reading;
    const ready = inflated(message);
    const done = (this.reading = Promise.all([ready, before])
      .then(() => !this.ended && act())
      .catch(fail)
      .then(() => this.reading === done && (this.reading = null)));
  }

  take(message) {
    if (message.type === "hello") return this.hello(message);
    if (message.type === "bye") this.reason = message.reason;
    if (message.epoch !== this.sequence.epoch) return; // no hello has opened its epoch
    if (message.type === "gap") {
      this.sequence.gap(message.first, message.count);
      this.handlers.gap(message);
    } else if (message.type === "truth") {
      this.handlers.truth(message);
    } else if (message.type === "spokes") {
      this.sequence.spokes(message.first, message.count);
      this.handlers.spokes(message);
      this.failures = 0; // only usable spokes count as a good connection
    }
  }

  hello(message) {
    if (message.protocol !== PROTOCOL) {
      this.end();
      return this.handlers.state("refused", `the service speaks protocol ${message.protocol}, this page ${PROTOCOL}: reload it`);
    }
    const isRestart = this.joining && this.sequence.isOther(message.epoch);
    if (isRestart) this.sequence.forget();
    const isNew = this.sequence.hello(message.epoch, this.joining);
    this.joining = false;
    this.handlers.state("live", "");
    this.handlers.hello(message, isNew, isRestart);
  }

  closed(code, reason) {
    if (this.ended) return;
    const wait = backOff(this.failures++, Math.random());
    if (code === 4404) this.handlers.gone?.(); // there is no such radar
    const cause = this.reason || reason || (code === 1006 ? "" : `closed with code ${code}`); // 1006: lost
    this.handlers.state("waiting", `${cause ? `${cause}; ` : ""}trying again in ${Math.ceil(wait)} s`);
    this.timer = setTimeout(() => this.open(), wait * 1000);
  }
}
