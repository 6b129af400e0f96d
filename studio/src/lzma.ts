// The decoder of LZMA, as the format's specification describes it (LZMA specification, Igor Pavlov, public domain): the library
// is a quarter smaller than by the browser's own gzip.

const MODEL = 2048;

/** The bytes behind a `.lzma` file whose header tells their count. */
export function decompress(packed: Uint8Array): Uint8Array {
  const view = new DataView(packed.buffer, packed.byteOffset, packed.byteLength);
  const properties = packed[0];
  const lc = properties % 9;
  const lp = Math.floor(properties / 9) % 5;
  const pb = Math.floor(properties / 45);
  const size = view.getUint32(5, true);
  const out = new Uint8Array(size);
  const fresh = (count: number) => new Uint16Array(count).fill(MODEL / 2);
  const literals = fresh(0x300 << (lc + lp));
  const [isMatch, isRep0Long] = [fresh(192), fresh(192)];
  const [isRep, isRep0, isRep1, isRep2] = [fresh(12), fresh(12), fresh(12), fresh(12)];
  const slots = [fresh(64), fresh(64), fresh(64), fresh(64)];
  const [near, align] = [fresh(116), fresh(16)];
  const lengths = () => ({ choice: fresh(2), low: fresh(128), middle: fresh(128), high: fresh(256) });
  const [matchLength, repLength] = [lengths(), lengths()];

  let at = 18;
  let range = 0xffffffff;
  let code = view.getUint32(14) >>> 0;

  function bit(model: Uint16Array, index: number): number {
    const p = model[index];
    const bound = (range >>> 11) * p;
    let value = 0;
    if (code < bound) {
      range = bound;
      model[index] = p + ((MODEL - p) >> 5);
    } else {
      range -= bound;
      code -= bound;
      model[index] = p - (p >> 5);
      value = 1;
    }
    if (range < 0x1000000) {
      range = (range << 8) >>> 0;
      code = ((code << 8) | packed[at++]) >>> 0;
    }
    return value;
  }

  function direct(bits: number): number {
    let value = 0;
    while (bits-- > 0) {
      range >>>= 1;
      const one = code >= range ? 1 : 0;
      if (one) code -= range;
      value = (value << 1) | one;
      if (range < 0x1000000) {
        range = (range << 8) >>> 0;
        code = ((code << 8) | packed[at++]) >>> 0;
      }
    }
    return value;
  }

  function tree(model: Uint16Array, offset: number, bits: number): number {
    let node = 1;
    for (let i = 0; i < bits; i++) node = (node << 1) | bit(model, offset + node);
    return node - (1 << bits);
  }

  function reverse(model: Uint16Array, offset: number, bits: number): number {
    let [node, value] = [1, 0];
    for (let i = 0; i < bits; i++) {
      const one = bit(model, offset + node);
      node = (node << 1) | one;
      value |= one << i;
    }
    return value;
  }

  function length(of: ReturnType<typeof lengths>, place: number): number {
    if (!bit(of.choice, 0)) return 2 + tree(of.low, place << 3, 3);
    if (!bit(of.choice, 1)) return 10 + tree(of.middle, place << 3, 3);
    return 18 + tree(of.high, 0, 8);
  }

  function distance(len: number): number {
    const slot = tree(slots[Math.min(len - 2, 3)], 0, 6);
    if (slot < 4) return slot;
    const bits = (slot >> 1) - 1;
    const base = (2 | (slot & 1)) << bits;
    if (slot < 14) return base + reverse(near, base - slot, bits);
    return base + direct(bits - 4) * 16 + reverse(align, 0, 4);
  }

  let [state, rep0, rep1, rep2, rep3, done] = [0, 0, 0, 0, 0, 0];
  while (done < size) {
    const place = done & ((1 << pb) - 1);
    if (!bit(isMatch, (state << 4) + place)) {
      const before = done > 0 ? out[done - 1] : 0;
      const offset = 0x300 * (((done & ((1 << lp) - 1)) << lc) + (before >> (8 - lc)));
      let symbol = 1;
      if (state >= 7) {
        let match = out[done - rep0 - 1];
        while (symbol < 0x100) {
          const high = (match >> 7) & 1;
          match <<= 1;
          const one = bit(literals, offset + ((1 + high) << 8) + symbol);
          symbol = (symbol << 1) | one;
          if (high !== one) break;
        }
      }
      while (symbol < 0x100) symbol = (symbol << 1) | bit(literals, offset + symbol);
      out[done++] = symbol;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let len: number;
    if (bit(isRep, state)) {
      if (!bit(isRep0, state)) {
        if (!bit(isRep0Long, (state << 4) + place)) {
          state = state < 7 ? 9 : 11;
          out[done] = out[done - rep0 - 1];
          done += 1;
          continue;
        }
      } else {
        let chosen: number;
        if (!bit(isRep1, state)) chosen = rep1;
        else {
          if (!bit(isRep2, state)) chosen = rep2;
          else {
            chosen = rep3;
            rep3 = rep2;
          }
          rep2 = rep1;
        }
        rep1 = rep0;
        rep0 = chosen;
      }
      len = length(repLength, place);
      state = state < 7 ? 8 : 11;
    } else {
      [rep3, rep2, rep1] = [rep2, rep1, rep0];
      len = length(matchLength, place);
      state = state < 7 ? 7 : 10;
      rep0 = distance(len);
    }
    const from = done - rep0 - 1;
    if (from < 0) throw new Error("the library in this page is damaged");
    for (let i = 0; i < len && done < size; i++) out[done++] = out[from + i];
  }
  return out;
}
