// The columns of the last seconds: a ring that never grows, however long the page is open.

export class Ring {
  constructor(size, channels) {
    this.size = size;
    this.channels = channels;
    this.values = new Float32Array(size * channels * 2).fill(NaN);
    this.end = 0;
  }

  add(first, n, values) {
    const wide = 2 * this.channels;
    for (let c = Math.max(this.end, first - this.size); c < first; c++) {
      const at = (c % this.size) * wide;
      this.values.fill(NaN, at, at + wide);
    }
    for (let i = Math.max(0, n - this.size); i < n; i++) {
      this.values.set(values.subarray(i * wide, (i + 1) * wide), ((first + i) % this.size) * wide);
    }
    this.end = first + n;
  }

  low(column, channel) {
    return this.values[((column % this.size) * this.channels + channel) * 2];
  }

  high(column, channel) {
    return this.values[((column % this.size) * this.channels + channel) * 2 + 1];
  }
}
