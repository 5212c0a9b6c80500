// The surface of the stock at a stage, by surface nets of the crossings that are there then: see workpiece/stock_stages.py.
const FLAT = 1.5;  // shares of a cell by which crossings of one face may differ

class Stock {
  constructor(data, arrays) {
    Object.assign(this, { origin: data.origin, step: data.step, points: data.points, shares: data.shares, stages: data.stages, square: data.square });
    const [, ny, nz] = data.points, places = arrays.whole(data.place);
    this.edge = arrays.whole(data.edge);
    this.first = arrays.whole(data.first);
    this.end = arrays.whole(data.end);
    this.place = places.map((v) => v % (data.shares + 1));
    this.leaves = Uint8Array.from(places, (v) => (v > data.shares ? 1 : 0));
    this.axisEnds = [data.counts[0], data.counts[0] + data.counts[1], data.counts[0] + data.counts[1] + data.counts[2]];
    this.strides = [ny * nz, nz, 1];
    this.vertex = new Int32Array(data.points[0] * ny * nz).fill(-1);
  }

  stageAt(t, duration) { return Math.min(Math.max(Math.floor((t / duration) * this.stages + 1e-9), 0), this.stages); }

  // Corners (mm), triangles of them, and of each corner how much of what is about it was cut.
  surface(stage) {
    const { edge, first, end, leaves, strides, vertex } = this, quads = [], cubes = [], number = [], sums = [], low = [], high = [], cut = [];
    for (let i = 0, axis = 0; i < edge.length; i++) {
      while (i >= this.axisEnds[axis]) axis++;
      if (first[i] > stage || end[i] <= stage) continue;
      const u = strides[(axis + 1) % 3], v = strides[(axis + 2) % 3], at = edge[i];
      // the four cubes about an edge, counterclockwise about its axis
      const four = [at, at - u, at - u - v, at - v];
      const where = this.point(at);
      where[axis] += this.place[i] / this.shares;
      for (const cube of four) {
        let k = vertex[cube];
        if (k < 0) {
          k = vertex[cube] = cubes.length;
          cubes.push(cube); number.push(0); cut.push(0); sums.push(0, 0, 0);
          low.push(Infinity, Infinity, Infinity); high.push(-Infinity, -Infinity, -Infinity);
        }
        number[k]++;
        if (first[i] > 0) cut[k]++;
        for (let d = 0; d < 3; d++) sums[3 * k + d] += where[d];
        low[3 * k + axis] = Math.min(low[3 * k + axis], where[axis]);
        high[3 * k + axis] = Math.max(high[3 * k + axis], where[axis]);
      }
      const [a, b, c, d] = four.map((cube) => vertex[cube]);
      if (leaves[i]) quads.push(a, b, c, a, c, d); else quads.push(d, c, b, d, b, a);
    }
    const corners = new Float32Array(3 * cubes.length);
    for (let k = 0; k < cubes.length; k++) {
      let flat = this.square && !cut[k];
      for (let d = 0; d < 3; d++) if (high[3 * k + d] - low[3 * k + d] > FLAT / this.shares) flat = false;
      for (let d = 0; d < 3; d++) {
        const own = flat && high[3 * k + d] >= low[3 * k + d];
        const value = own ? 0.5 * (low[3 * k + d] + high[3 * k + d]) : sums[3 * k + d] / number[k];
        corners[3 * k + d] = this.origin[d] + this.step[d] * value;
      }
      vertex[cubes[k]] = -1;
    }
    return { corners, triangles: Uint32Array.from(quads), cut: Float32Array.from(cut, (v, k) => v / number[k]) };
  }

  point(at) {
    const [sx, sy] = this.strides, x = Math.floor(at / sx), y = Math.floor((at - x * sx) / sy);
    return [x, y, at - x * sx - y * sy];
  }
}
