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
    this.vertex = new Int32Array(data.points[0] * ny * nz).fill(-1);
  }

  stageAt(t, duration) { return Math.min(Math.max(Math.floor((t / duration) * this.stages + 1e-9), 0), this.stages); }

  // The crossings that are there at a stage: along which axis, from which point, how far to the next, ...
  crossings(stage) {
    const { edge, first, end, leaves, place, shares } = this, [nx, ny, nz] = this.points;
    let n = 0;
    for (let i = 0; i < edge.length; i++) if (first[i] <= stage && stage < end[i]) n++;
    const found = { n: 0, dims: [nx, ny, nz], scale: 1, axis: new Uint8Array(n), point: new Int32Array(n), share: new Float32Array(n), leaves: new Uint8Array(n), fresh: new Uint8Array(n) };
    for (let i = 0, axis = 0; i < edge.length; i++) {
      while (i >= this.axisEnds[axis]) axis++;
      if (first[i] > stage || end[i] <= stage) continue;
      const k = found.n++;
      found.axis[k] = axis;
      found.point[k] = edge[i];
      found.share[k] = place[i] / shares;
      found.leaves[k] = leaves[i];
      found.fresh[k] = first[i] > 0 ? 1 : 0;
    }
    return found;
  }

  // The same on every second point along each axis: of two crossings between two of them nothing is left.
  halved(fine) {
    const [, ny, nz] = fine.dims, dims = fine.dims.map((n) => (n >> 1) + 1), strides = [dims[1] * dims[2], dims[2], 1];
    const { n } = fine, out = { ...fine, n: 0, dims, scale: 2, axis: new Uint8Array(n), point: new Int32Array(n), share: new Float32Array(n), leaves: new Uint8Array(n), fresh: new Uint8Array(n) };
    const where = [0, 0, 0], met = [0, 1, 2].map(() => new Map());
    for (let i = 0; i < n; i++) {
      const axis = fine.axis[i], point = fine.point[i];
      where[0] = Math.floor(point / (ny * nz));
      where[1] = Math.floor((point - where[0] * ny * nz) / nz);
      where[2] = point - (where[0] * ny + where[1]) * nz;
      if (where[(axis + 1) % 3] & 1 || where[(axis + 2) % 3] & 1) continue;
      const half = (where[0] >> 1) * strides[0] + (where[1] >> 1) * strides[1] + (where[2] >> 1);
      if (met[axis].has(half)) { met[axis].delete(half); continue; }
      met[axis].set(half, { share: 0.5 * ((where[axis] & 1) + fine.share[i]), leaves: fine.leaves[i], fresh: fine.fresh[i] });
    }
    met.forEach((edges, axis) => {
      for (const [point, { share, leaves, fresh }] of edges) {
        const k = out.n++;
        [out.axis[k], out.point[k], out.share[k], out.leaves[k], out.fresh[k]] = [axis, point, share, leaves, fresh];
      }
    });
    return out;
  }

  // Corners (mm), triangles of them, and of each corner how much of what is about it was cut; `coarse` has a quarter as many.
  surface(stage, coarse = false) {
    const found = coarse ? this.halved(this.crossings(stage)) : this.crossings(stage), { n, dims, scale, axis: along, point: lower, share, leaves, fresh: cutHere } = found;
    const { shares, vertex } = this, strides = [dims[1] * dims[2], dims[2], 1], [sx, sy] = strides;
    const triangles = new Uint32Array(6 * n), cubes = new Int32Array(4 * n), number = new Uint8Array(4 * n), fresh = new Uint8Array(4 * n);
    const sums = new Float32Array(12 * n), low = new Float32Array(this.square ? 12 * n : 0).fill(Infinity), high = new Float32Array(low.length).fill(-Infinity);
    const where = [0, 0, 0], four = [0, 0, 0, 0];
    let count = 0, at = 0;
    for (let i = 0; i < n; i++) {
      const axis = along[i], u = strides[(axis + 1) % 3], v = strides[(axis + 2) % 3], point = lower[i];
      where[0] = Math.floor(point / sx);
      where[1] = Math.floor((point - where[0] * sx) / sy);
      where[2] = point - where[0] * sx - where[1] * sy;
      where[axis] += share[i];
      // the four cubes about an edge, counterclockwise about its axis
      for (let c = 0; c < 4; c++) {
        const cube = point - (c === 1 || c === 2 ? u : 0) - (c > 1 ? v : 0);
        let k = vertex[cube];
        if (k < 0) { k = vertex[cube] = count++; cubes[k] = cube; }
        four[c] = k;
        number[k]++;
        fresh[k] += cutHere[i];
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
        corners[3 * k + d] = this.origin[d] + scale * this.step[d] * (own ? 0.5 * (low[3 * k + d] + high[3 * k + d]) : sums[3 * k + d] / number[k]);
      }
      cut[k] = fresh[k] / number[k];
      vertex[cubes[k]] = -1;
    }
    return { corners, triangles, cut };
  }
}
