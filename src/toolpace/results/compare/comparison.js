// Motions on one time, and places at which each of them is compared with the first.
const ALONG = 40000;  // places over the path

class Comparison extends Playback {
  constructor(data, arrays) {
    super(Math.max(...data.plans.map((plan) => plan.duration)));
    this.plans = data.plans.map((plan) => new ComparedPlayer(plan, arrays, this));
    this.plans.forEach((plan, k) => { plan.text = this.plans[data.plans[k].text_of].text; });
    [this.first] = this.plans;
    this.way = arrays.numbers(data.way);
    // that of which the lists and the colours tell, against the first
    this.other = this.plans[1] || null;
    this.first.colouring = this.other && this.other.places ? "faster" : "speed";
    this.matched = this.plans.slice(1).filter((plan) => plan.places);
  }

  seek(t) {
    for (const plan of this.plans) plan.show(Math.min(Math.max(Number(t) || 0, 0), this.duration));
    super.seek(t);
  }

  step(by) { this.first.step(by); }
  lineTime(line) { return this.first.lineTime(line); }

  // When a plan is where the first is at a time t; NaN where that is not known.
  timeOf(plan, t) {
    if (plan === this.first) return t;
    return plan.places ? between(plan.places, (t / this.first.duration) * (plan.places.length - 1)) : NaN;
  }

  // When the first is where a plan is at a time t.
  timeOfFirst(plan, t) {
    if (plan === this.first) return Math.min(t, this.first.duration);
    return plan.places ? (placeIn(plan.places, t) / (plan.places.length - 1)) * this.first.duration : NaN;
  }

  // By how much a plan was earlier than the first at the place where this is at a time t.
  gained(plan, t) { return t - this.timeOf(plan, t); }

  // How much faster the other passes the place of a time t of the first: 1 where twice as fast, -1 where half.
  faster(t) {
    const { places } = this.other, k = Math.min(Math.max(Math.round((t / this.first.duration) * (places.length - 1)), 1), places.length - 2);
    const slope = ((places[k + 1] - places[k - 1]) * (places.length - 1)) / (2 * this.first.duration);
    return -Math.log2(Math.max(slope, 1e-3));
  }

  // Way of the tip of the first at a time, and when it has come so far [mm].
  wayAt(t) { return between(this.way, (t / this.first.duration) * (this.way.length - 1)); }
  timeAt(way) { return (placeIn(this.way, way) / (this.way.length - 1)) * this.first.duration; }

  // Times of all plans at even places of the path of the first.
  get along() {
    if (!this.times) {
      const firsts = Float64Array.from({ length: ALONG }, (_, k) => this.timeAt((k / (ALONG - 1)) * this.way.at(-1)));
      this.times = new Map(this.plans.map((plan) => [plan, plan === this.first ? firsts : firsts.map((t) => this.timeOf(plan, t))]));
    }
    return this.times;
  }

  state() {
    const { t, playing } = this, first = this.first.t;
    const gained = (plan) => { const found = this.gained(plan, first); return Number.isNaN(found) ? null : found; };
    return { t, playing: !!playing, plans: this.plans.map((plan) => ({ name: plan.name, ...plan.state(), gained: gained(plan) })) };
  }
}

// A motion whose time is that of all.
class ComparedPlayer extends Player {
  constructor(data, arrays, comparison) {
    super(data, arrays);
    Object.assign(this, { comparison, name: data.name, colour: data.colour });
    this.places = data.places && arrays.numbers(data.places);
  }

  seek(t) { this.comparison.seek(t); }
  show(t) { this.t = Math.min(t, this.duration); }

  pathColour(t, speed) {
    if (this.colouring !== "faster") return super.pathColour(t, speed);
    const share = Math.min(Math.max(1.5 * this.comparison.faster(t), -1), 1);
    const to = new THREE.Color(share > 0 ? this.comparison.other.colour : this.colour);
    return new THREE.Color(ALIKE).lerp(to, Math.abs(share));
  }
}

const ALIKE = "#8794a8";

// A value between those of an array, at a broken index.
function between(values, at) {
  const k = Math.min(Math.max(Math.floor(at), 0), values.length - 2);
  return values[k] + (at - k) * (values[k + 1] - values[k]);
}

// The broken index at which ascending values reach x: its last where they stay there.
function placeIn(values, x) {
  const k = Math.min(lastAt(values, x), values.length - 2), step = values[k + 1] - values[k];
  return k + (step > 0 ? Math.min(Math.max((x - values[k]) / step, 0), 1) : 0);
}

// The tool of a plan as a shadow of its colour, on the part of the first.
class Ghost {
  constructor(space, plan) {
    Object.assign(this, { space, plan });
    const look = new THREE.MeshLambertMaterial({ color: plan.colour, transparent: true, opacity: 0.45, depthWrite: false });
    this.shapes = [new THREE.CylinderGeometry(1, 1, 1, 32), new THREE.CylinderGeometry(1, 0.55, 1, 40)].map((shape) => new THREE.Mesh(shape, look));
    for (const shape of this.shapes) {
      shape.matrixAutoUpdate = false;
      space.part.add(shape);
    }
    if (!plan.places) this.drawPath();
  }

  // The path, where it is another than that of the first.
  drawPath() {
    const { tips } = this.plan.motion.samples(1e-3 * this.space.size, 50000), points = new Float32Array(6 * (tips.length - 1));
    for (let k = 1; k < tips.length; k++) { points.set(tips[k - 1], 6 * k - 6); points.set(tips[k], 6 * k - 3); }
    const shape = new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3));
    this.path = new THREE.LineSegments(shape, new THREE.LineBasicMaterial({ color: this.plan.colour, transparent: true, opacity: 0.5 }));
    this.path.frustumCulled = false;
    this.space.part.add(this.path);
  }

  pose() {
    const { motion, t } = this.plan, { tip, axis } = motion.tool(t), up = new THREE.Vector3(...axis), length = motion.length(t);
    const edge = Math.min(0.55 * length, 8 * this.space.thick), rest = Math.max(length - edge, 1e-3), at = new THREE.Vector3(...tip);
    this.shapes[0].matrix.copy(along(up, at.clone().addScaledVector(up, 0.5 * edge), this.space.thick / 2, edge));
    this.shapes[1].matrix.copy(along(up, at.clone().addScaledVector(up, edge + 0.5 * rest), 1.6 * this.space.thick, rest));
  }

  show(visible) {
    for (const shape of [...this.shapes, ...(this.path ? [this.path] : [])]) shape.visible = visible;
    this.space.draw();
  }
}
