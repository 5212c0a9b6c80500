// The motion of the joints from its keyframes, and where the tool is then. Lengths in mm, angles in rad.

// Rigid motions are twelve numbers: rows of (rotation | shift).
const AT_REST = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

function after(m, joint, value) {
  const [x, y, z] = joint.direction, out = new Array(12);
  if (!joint.rotary) {
    for (let i = 0; i < 12; i++) out[i] = m[i];
    for (let r = 0; r < 3; r++) out[4 * r + 3] += value * (m[4 * r] * x + m[4 * r + 1] * y + m[4 * r + 2] * z);
    return out;
  }
  const c = Math.cos(value), s = Math.sin(value), v = 1 - c, [px, py, pz] = joint.point;
  const turn = [c + v * x * x, v * x * y - s * z, v * x * z + s * y, v * x * y + s * z, c + v * y * y, v * y * z - s * x,
    v * x * z - s * y, v * y * z + s * x, c + v * z * z];
  const shift = [0, 1, 2].map((r) => joint.point[r] - turn[3 * r] * px - turn[3 * r + 1] * py - turn[3 * r + 2] * pz);
  return product(m, [turn[0], turn[1], turn[2], shift[0], turn[3], turn[4], turn[5], shift[1], turn[6], turn[7], turn[8], shift[2]]);
}

function product(a, b) {
  const out = new Array(12);
  for (let r = 0; r < 3; r++) {
    for (let c = 0; c < 4; c++) {
      out[4 * r + c] = a[4 * r] * b[c] + a[4 * r + 1] * b[4 + c] + a[4 * r + 2] * b[8 + c] + (c === 3 ? a[4 * r + 3] : 0);
    }
  }
  return out;
}

const turned = (m, [x, y, z]) => [0, 4, 8].map((r) => m[r] * x + m[r + 1] * y + m[r + 2] * z);
const placed = (m, p) => turned(m, p).map((v, r) => v + m[4 * r + 3]);
const turnedBack = (m, [x, y, z]) => [0, 1, 2].map((c) => m[c] * x + m[4 + c] * y + m[8 + c] * z);

class Machine {
  constructor(view) {
    Object.assign(this, view);
    const o = view.orientation, p = view.origin;
    // columns are the directions of the workpiece
    this.frame = [o[0], o[3], o[6], p[0], o[1], o[4], o[7], p[1], o[2], o[5], o[8], p[2]];
  }

  // The motion of each joint's body from where it is with all joints at zero, from the bed outwards.
  bodies(joints, q) {
    const out = [];
    let m = AT_REST;
    for (const joint of joints) out.push(m = after(m, joint, q[joint.column]));
    return out;
  }

  tool(q, length) {
    const w = product(this.bodies(this.workpiece, q).at(-1) || AT_REST, this.frame);
    const t = this.bodies(this.tool_chain, q).at(-1) || AT_REST;
    const tip = placed(t, this.nose.map((v, k) => v - length * this.axis[k]));
    return { tip: turnedBack(w, tip.map((v, k) => v - w[4 * k + 3])), axis: turnedBack(w, turned(t, this.axis)) };
  }
}

class Motion {
  constructor(data, arrays) {
    this.duration = data.duration;
    this.rotary = data.rotary;
    const scale = data.rotary.map((r) => (r ? 1 : 1e3));
    this.t = arrays.numbers(data.keyframes.t);
    this.t[this.t.length - 1] = this.duration;
    this.q = data.keyframes.q.map((e, j) => arrays.numbers(e).map((v) => v * scale[j]));
    this.v = data.keyframes.v.map((e, j) => arrays.numbers(e).map((v) => v * scale[j]));
    this.machine = data.machine ? new Machine(data.machine) : null;
    this.tools = { t: data.tools.t, length: data.tools.length };
  }

  // Joint positions at a time.
  at(t) {
    const k = Math.min(lastAt(this.t, t), this.t.length - 2), h = this.t[k + 1] - this.t[k];
    const u = Math.min(Math.max((t - this.t[k]) / h, 0), 1), w = 1 - u;
    return this.q.map((q, j) => w * w * (q[k] * (1 + 2 * u) + this.v[j][k] * h * u)
      + u * u * (q[k + 1] * (1 + 2 * w) - this.v[j][k + 1] * h * w));
  }

  length(t) { return this.tools.length[lastAt(this.tools.t, t)]; }

  tool(t) { return this.machine && this.machine.tool(this.at(t), this.length(t)); }

  // Times at which straight lines between the tips show their way to within `off` mm.
  samples(off, most) {
    const times = [], tips = [];
    const between = (a, b, from, to, depth) => {
      const middle = 0.5 * (a + b), tip = this.tool(middle).tip;
      const far = Math.hypot(...tip.map((v, k) => v - 0.5 * (from[k] + to[k])));
      if (depth < 6 && far > off && times.length < most) {
        between(a, middle, from, tip, depth + 1);
        between(middle, b, tip, to, depth + 1);
      } else { times.push(b); tips.push(to); }
    };
    let before = this.tool(0).tip;
    times.push(0); tips.push(before);
    for (let k = 0; k + 1 < this.t.length; k++) {
      // a middle tells nothing of a whole turn
      const turn = Math.max(0, ...this.q.map((q, j) => (this.rotary[j] ? Math.abs(q[k + 1] - q[k]) : 0)));
      const parts = off < Infinity && times.length < most ? Math.min(Math.ceil(turn), 64) || 1 : 1, h = (this.t[k + 1] - this.t[k]) / parts;
      for (let i = 1; i <= parts; i++) {
        const end = i < parts ? this.t[k] + i * h : this.t[k + 1], now = this.tool(end).tip;
        between(i > 1 ? end - h : this.t[k], end, before, now, 0);
        before = now;
      }
    }
    return { times, tips };
  }
}
