// Reads msgpack (the subset that carries data: no extension types). Binary values are views into the message, not copies.

const MAX_DEPTH = 32; // the feed nests four deep; a bound keeps a broken message from exhausting the stack

/** Returns the one value in an ArrayBuffer. Throws if it is truncated, followed by more, or of an unknown type. */
export function decode(buffer) {
  const reader = new Reader(buffer);
  const value = reader.value(0);
  if (reader.at !== buffer.byteLength) throw new Error(`msgpack: ${buffer.byteLength - reader.at} bytes follow the value`);
  return value;
}

class Reader {
  constructor(buffer) {
    this.buffer = buffer;
    this.view = new DataView(buffer);
    this.at = 0;
  }

  value(depth) {
    if (depth > MAX_DEPTH) throw new Error(`msgpack: nested more than ${MAX_DEPTH} deep`);
    const tag = this.number("Uint8", 1);
    if (tag < 0x80) return tag;
    if (tag < 0x90) return this.map(tag & 0x0f, depth);
    if (tag < 0xa0) return this.array(tag & 0x0f, depth);
    if (tag < 0xc0) return this.text(tag & 0x1f);
    if (tag >= 0xe0) return tag - 0x100;
    const read = TAGS[tag];
    if (!read) throw new Error(`msgpack: type 0x${tag.toString(16)} at byte ${this.at - 1} is not one the feed uses`);
    return read(this, depth);
  }

  number(kind, size) {
    const value = this.view[`get${kind}`](this.at); // throws RangeError if the message is truncated
    this.at += size;
    return value;
  }

  bytes(length) {
    if (this.at + length > this.buffer.byteLength) throw new RangeError(`msgpack: ends within ${length} bytes of data`);
    const view = new Uint8Array(this.buffer, this.at, length);
    this.at += length;
    return view;
  }

  text(length) {
    return TEXT.decode(this.bytes(length));
  }

  array(length, depth) {
    const items = [];
    for (let i = 0; i < length; i++) items.push(this.value(depth + 1));
    return items;
  }

  map(length, depth) {
    const entries = Object.create(null); // makes __proto__ an ordinary key
    for (let i = 0; i < length; i++) {
      const key = this.value(depth + 1);
      entries[key] = this.value(depth + 1);
    }
    return entries;
  }
}

const TEXT = new TextDecoder();

const TAGS = {
  0xc0: () => null,
  0xc2: () => false,
  0xc3: () => true,
  0xc4: (r) => r.bytes(r.number("Uint8", 1)),
  0xc5: (r) => r.bytes(r.number("Uint16", 2)),
  0xc6: (r) => r.bytes(r.number("Uint32", 4)),
  0xca: (r) => r.number("Float32", 4),
  0xcb: (r) => r.number("Float64", 8),
  0xcc: (r) => r.number("Uint8", 1),
  0xcd: (r) => r.number("Uint16", 2),
  0xce: (r) => r.number("Uint32", 4),
  0xcf: (r) => Number(r.number("BigUint64", 8)), // exact up to 2^53, a million years of spokes
  0xd0: (r) => r.number("Int8", 1),
  0xd1: (r) => r.number("Int16", 2),
  0xd2: (r) => r.number("Int32", 4),
  0xd3: (r) => Number(r.number("BigInt64", 8)),
  0xd9: (r) => r.text(r.number("Uint8", 1)),
  0xda: (r) => r.text(r.number("Uint16", 2)),
  0xdb: (r) => r.text(r.number("Uint32", 4)),
  0xdc: (r, depth) => r.array(r.number("Uint16", 2), depth),
  0xdd: (r, depth) => r.array(r.number("Uint32", 4), depth),
  0xde: (r, depth) => r.map(r.number("Uint16", 2), depth),
  0xdf: (r, depth) => r.map(r.number("Uint32", 4), depth),
};
