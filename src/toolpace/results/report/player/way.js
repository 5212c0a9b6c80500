// The way of the tip as lines: few where it is straight and alike, the box around it, the colours of speeds.
const LONGEST_LINE = 64;  // samples that one straight line stands for at most

const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

// Which samples are kept: of those that are alike and lie along a straight line, the ends.
function straightened(times, tips, off, likeness) {
  const kept = [0];
  let begin = 0, kind = "";
  for (let k = 1; k < times.length; k++) {
    const now = likeness(k);
    if (k > begin + 1 && (now !== kind || k - begin > LONGEST_LINE || strays(tips, begin, k, off))) {
      kept.push(k - 1);
      begin = k - 1;
    }
    kind = now;
  }
  kept.push(times.length - 1);
  return kept;
}

// Whether any sample between two leaves the straight line between them.
function strays(tips, a, b, off) {
  const [x, y, z] = tips[a], way = [tips[b][0] - x, tips[b][1] - y, tips[b][2] - z], square = way[0] ** 2 + way[1] ** 2 + way[2] ** 2;
  for (let k = a + 1; k < b; k++) {
    const p = [tips[k][0] - x, tips[k][1] - y, tips[k][2] - z];
    const u = square > 0 ? Math.min(Math.max((p[0] * way[0] + p[1] * way[1] + p[2] * way[2]) / square, 0), 1) : 0;
    if (Math.hypot(p[0] - u * way[0], p[1] - u * way[1], p[2] - u * way[2]) > off) return true;
  }
  return false;
}

// The box around points, but for the hundredth that lies farthest out on each side where the box is much smaller so.
function trimmed(points) {
  const box = new THREE.Box3();
  for (const k of [0, 1, 2]) {
    const v = Float64Array.from(points, (p) => p[k]).sort(), n = v.length;
    const low = v[Math.floor(0.01 * (n - 1))], high = v[Math.ceil(0.99 * (n - 1))];
    const name = "xyz"[k], wide = v[n - 1] - v[0] > 3 * Math.max(high - low, 1e-9);
    box.min[name] = wide ? low : v[0];
    box.max[name] = wide ? high : v[n - 1];
  }
  return box;
}

// Blue to yellow, of a lightness that rises evenly on the dark ground: also for those who see no red or green.
const RAMP = [[72, 112, 214], [58, 138, 206], [72, 164, 186], [124, 188, 148], [196, 210, 96], [255, 232, 72]];
function speedColour(share) {
  const x = share * (RAMP.length - 1), k = Math.min(Math.floor(x), RAMP.length - 2), u = x - k;
  return `rgb(${RAMP[k].map((v, c) => Math.round(v + u * (RAMP[k + 1][c] - v))).join(",")})`;
}
