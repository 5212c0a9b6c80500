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
    const { edge, first, end, leaves, place, shares, strides, vertex } = this, [sx, sy] = strides;
    let alive = 0;
    for (let i = 0; i < edge.length; i++) if (first[i] <= stage && stage < end[i]) alive++;
    const triangles = new Uint32Array(6 * alive), cubes = new Int32Array(4 * alive), number = new Uint8Array(4 * alive), fresh = new Uint8Array(4 * alive);
    const sums = new Float32Array(12 * alive), low = new Float32Array(this.square ? 12 * alive : 0).fill(Infinity), high = new Float32Array(low.length).fill(-Infinity);
    const where = [0, 0, 0], four = [0, 0, 0, 0];
    let count = 0, at = 0;
    for (let i = 0, axis = 0; i < edge.length; i++) {
      while (i >= this.axisEnds[axis]) axis++;
      if (first[i] > stage || end[i] <= stage) continue;
      const u = strides[(axis + 1) % 3], v = strides[(axis + 2) % 3], point = edge[i];
      where[0] = Math.floor(point / sx);
      where[1] = Math.floor((point - where[0] * sx) / sy);
      where[2] = point - where[0] * sx - where[1] * sy;
      where[axis] += place[i] / shares;
      // the four cubes about an edge, counterclockwise about its axis
      for (let c = 0; c < 4; c++) {
        const cube = point - (c === 1 || c === 2 ? u : 0) - (c > 1 ? v : 0);
        let k = vertex[cube];
        if (k < 0) { k = vertex[cube] = count++; cubes[k] = cube; }
        four[c] = k;
        number[k]++;
        if (first[i] > 0) fresh[k]++;
        for (let d = 0; d < 3; d++) sums[3 * k + d] += where[d];
        if (!this.square) continue;
        if (where[axis] < low[3 * k + axis]) low[3 * k + axis] = where[axis];
        if (where[axis] > high[3 * k + axis]) high[3 * k + axis] = where[axis];
      }
      const [a, b, c, d] = leaves[i] ? four : [four[3], four[2], four[1], four[0]];
      triangles[at++] = a; triangles[at++] = b; triangles[at++] = c;
      triangles[at++] = a; triangles[at++] = c; triangles[at++] = d;
    }
    const corners = new Float32Array(3 * count), cut = new Float32Array(count);
    for (let k = 0; k < count; k++) {
      // at an edge of faces along the lattice both are met
      let flat = this.square && !fresh[k];
      for (let d = 0; flat && d < 3; d++) flat = !(high[3 * k + d] - low[3 * k + d] > FLAT / shares);
      for (let d = 0; d < 3; d++) {
        const own = flat && high[3 * k + d] >= low[3 * k + d];
        corners[3 * k + d] = this.origin[d] + this.step[d] * (own ? 0.5 * (low[3 * k + d] + high[3 * k + d]) : sums[3 * k + d] / number[k]);
      }
      cut[k] = fresh[k] / number[k];
      vertex[cubes[k]] = -1;
    }
    return { corners, triangles, cut };
  }
}
