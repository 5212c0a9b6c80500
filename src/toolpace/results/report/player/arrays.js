// The arrays of the page, out of their text: the other half of packed_arrays.py.
class Arrays {
  constructor(bytes) { this.data = bytes; }

  static async of(text) {
    const letters = atob(text), raw = new Uint8Array(letters.length);
    for (let i = 0; i < raw.length; i++) raw[i] = letters.charCodeAt(i);
    const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Arrays(new Uint8Array(await new Response(stream).arrayBuffer()));
  }

  bytes(entry) { return this.data.subarray(entry.at, entry.at + entry.n); }

  // Values of an entry; NaN where there is none.
  numbers(entry) {
    const { n, width, at, unit } = entry, out = new Float64Array(n), data = this.data;
    let whole = 0;
    for (let i = 0; i < n; i++) {
      let small = 0;
      for (let k = width - 1; k >= 0; k--) small = (small << 8) | data[at + k * n + i];
      whole = (whole + ((small >>> 1) ^ -(small & 1))) | 0;
      out[i] = whole === -2147483648 ? NaN : whole * unit;
    }
    return out;
  }

  whole(entry) { return Int32Array.from(this.numbers(entry)); }
}

// Index of the last of ascending values that is not above x; at least 0.
function lastAt(values, x) {
  let low = 0, high = values.length;
  while (low + 1 < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= x) low = middle; else high = middle;
  }
  return low;
}
