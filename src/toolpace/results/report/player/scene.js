// The view in space: the path by speed or by what limits, the machine, the tool. Drawn where something has changed only.
const CAMERAS = ["part", "machine", "tool"];
const GROUND = "#1a222e", RAPID = "#8794a8";
const LONGEST_PATH = 250000;
const SHADES = 24;  // of speed, within which samples are one line
const REACH = 12;  // pixels around a click within which the path is found

class Space {
  constructor(player, element) {
    this.player = player;
    this.element = element;
    // a computer without graphics draws thin lines with steps, and keeps up
    this.plain = drawsBySoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.plain });
    this.renderer.setPixelRatio(this.plain ? 1 : Math.min(window.devicePixelRatio || 1, 2));
    element.prepend(this.renderer.domElement);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(32, 1, 1, 1e5);
    this.camera.up.set(0, 0, 1);
    this.root = this.fixed(this.scene);
    this.part = this.fixed(this.root);
    this.light();
    this.samplePath();
    this.makePath();
    this.makeMachine();
    this.workpiece = player.workpiece && new Workpiece(this, player.workpiece, player.arrays);
    this.mode = "part";
    this.frame();
    this.listen();
    this.recolour();
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
    // what was shown is gone by the time that paper is printed
    window.addEventListener("beforeprint", () => this.render());
  }

  fixed(parent) {
    const group = new THREE.Group();
    group.matrixAutoUpdate = false;
    parent.add(group);
    return group;
  }

  light() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a94a6, 2.1));
    const sun = new THREE.DirectionalLight(0xffffff, 1.7);
    sun.position.set(0.6, -1, 1.4);
    this.scene.add(sun);
  }

  // The way of the tip, and the box around what is passed at feed, without the few long ways that leave it.
  samplePath() {
    const { player } = this, { motion } = player;
    const rough = motion.samples(Infinity, LONGEST_PATH).tips;
    const whole = new THREE.Box3().setFromPoints(rough.map((p) => new THREE.Vector3(...p)));
    const size = Math.max(whole.getSize(new THREE.Vector3()).length(), 1);
    const off = Math.max(2e-4 * size, 2e-3), found = motion.samples(off, LONGEST_PATH);
    const kept = straightened(found.times, found.tips, 0.2 * off, (k) => {
      const middle = 0.5 * (found.times[k] + found.times[k - 1]);
      const speed = distance(found.tips[k], found.tips[k - 1]) / Math.max(found.times[k] - found.times[k - 1], 1e-9);
      const loads = player.loads.map((load) => Math.round(SHADES * player.loadShare(load, middle)));
      return `${player.kindAt(middle)} ${player.stripAt(middle)} ${Math.round((SHADES * 60 * speed) / player.usual)} ${loads}`;
    });
    this.times = Float64Array.from(kept, (k) => found.times[k]);
    this.tips = kept.map((k) => found.tips[k]);
    this.kinds = Array.from(this.times, (t, k) => (k ? player.kindAt(0.5 * (t + this.times[k - 1])) : 0));
    const cut = this.tips.filter((_, k) => k && this.kinds[k] === 0);
    this.box = trimmed(cut.length > 1 ? cut : this.tips);
    this.size = Math.max(this.box.getSize(new THREE.Vector3()).length(), 1);
  }

  makePath() {
    const lines = { cutting: [], rapid: [] }, { motion } = this.player;
    for (let k = 1; k < this.times.length; k++) {
      // where the tool is changed the tip is elsewhere, without a way there
      if (motion.length(this.times[k - 1]) !== motion.length(this.times[k])) continue;
      (this.kinds[k] === 1 ? lines.rapid : lines.cutting).push(k);
    }
    this.lines = {};
    for (const [name, ends] of Object.entries(lines)) {
      const points = new Float32Array(6 * ends.length);
      ends.forEach((k, i) => { points.set(this.tips[k - 1], 6 * i); points.set(this.tips[k], 6 * i + 3); });
      const look = { vertexColors: true, ...(name === "rapid" ? { transparent: true, opacity: 0.4 } : {}) };
      const broad = name === "cutting" && !this.plain;
      const line = broad ? new THREE.LineSegments2(new THREE.LineSegmentsGeometry().setPositions(points), new THREE.LineMaterial({ linewidth: 2, ...look }))
        : new THREE.LineSegments(new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(points, 3)), new THREE.LineBasicMaterial(look));
      line.frustumCulled = false;
      line.userData = { ends, broad, colours: new Float32Array(points.length) };
      this.lines[name] = line;
      this.part.add(line);
    }
  }

  // Colours of the path, by speed or by what limits; and of the ground.
  recolour() {
    const { player } = this, ink = new THREE.Color();
    this.scene.background = new THREE.Color(GROUND);
    for (const [name, line] of Object.entries(this.lines)) {
      const { ends, broad, colours } = line.userData;
      ends.forEach((k, i) => {
        const middle = 0.5 * (this.times[k] + this.times[k - 1]);
        const speed = (60 * distance(this.tips[k], this.tips[k - 1])) / Math.max(this.times[k] - this.times[k - 1], 1e-9);
        ink.set(name === "rapid" ? RAPID : player.pathColour(middle, speed));
        colours.set([ink.r, ink.g, ink.b, ink.r, ink.g, ink.b], 6 * i);
      });
      if (broad) line.geometry.setColors(colours);
      else line.geometry.setAttribute("color", new THREE.BufferAttribute(colours.slice(), 3));
    }
    this.draw();
  }

  // Plain bodies on the joints: enough to see what moves, and where to.
  makeMachine() {
    const { machine } = this.player.motion;
    this.bodies = { workpiece: machine.workpiece.map(() => this.fixed(this.root)), tool_chain: machine.tool_chain.map(() => this.fixed(this.root)) };
    this.shapes = [];
    const metal = (colour) => new THREE.MeshLambertMaterial({ color: colour });
    const add = (parent, shape, colour, matrix) => {
      const mesh = new THREE.Mesh(shape, metal(colour));
      mesh.matrixAutoUpdate = false;
      mesh.matrix.copy(matrix);
      parent.add(mesh);
      return mesh;
    };
    this.makeTables(machine, add);
    this.makeSpindle(machine, add);
  }

  makeTables(machine, add) {
    const up = new THREE.Vector3(...machine.axis), corners = this.corners(machine);
    const centre = corners.reduce((sum, p) => sum.addScaledVector(p, 1 / 8), new THREE.Vector3());
    const radius = 0.52 * this.size, thick = 0.1 * this.size;
    let level = Math.min(...corners.map((p) => p.dot(up))) - 0.02 * this.size, held = radius;
    if (!machine.workpiece.length) {
      // the part stands on the bed
      const plate = centre.clone().addScaledVector(up, level - 0.5 * thick - centre.dot(up));
      this.shapes.push(add(this.root, new THREE.BoxGeometry(3 * held, thick, 3 * held), 0x3f4d60, along(up, plate)));
    }
    [...machine.workpiece].reverse().forEach((joint, back) => {
      const body = this.bodies.workpiece[machine.workpiece.length - 1 - back], u = new THREE.Vector3(...joint.direction);
      const colour = [0x4d5d73, 0x3f4d60, 0x343f50][back % 3];
      if (joint.rotary && Math.abs(u.dot(up)) > 0.7) {
        const p = onAxis(joint, centre);
        this.shapes.push(add(body, new THREE.CylinderGeometry(held, held, thick, 64), colour, along(up, p.addScaledVector(up, level - 0.5 * thick - p.dot(up)))));
        level -= thick;
        held *= 1.12;
      } else if (joint.rotary) {
        const p = onAxis(joint, centre), flat = 0.18 * this.size;
        for (const side of [-1, 1]) {
          const at = p.clone().addScaledVector(u, side * 1.2 * held);
          this.shapes.push(add(body, new THREE.CylinderGeometry(0.26 * this.size, 0.26 * this.size, flat, 48), colour, along(u, at)));
        }
        const plate = p.clone().addScaledVector(up, level - 0.5 * thick - p.dot(up));
        this.shapes.push(add(body, new THREE.BoxGeometry(2.4 * held, 1.1 * held, thick), colour, framed(u, up, plate)));
        level -= thick;
      } else {
        const p = centre.clone().addScaledVector(up, level - 0.5 * thick - centre.dot(up));
        const wide = 2.5 * held;
        if (Math.abs(u.dot(up)) < 0.7) this.shapes.push(add(body, new THREE.BoxGeometry(wide * 1.15, wide * 0.9, thick), colour, framed(u, up, p)));
        level -= thick;
      }
    });
  }

  makeSpindle(machine, add) {
    const up = new THREE.Vector3(...machine.axis), nose = new THREE.Vector3(...machine.nose), reach = machine.length;
    const body = this.bodies.tool_chain.at(-1) || this.fixed(this.root);
    const wide = Math.min(0.3 * reach, 0.35 * this.size), tall = Math.max(0.9 * reach, 0.5 * this.size);
    this.toolBody = this.fixed(body);
    this.thick = Math.max(Math.min(0.04 * this.size, 0.12 * reach), 0.4);
    this.toolShape = add(this.toolBody, new THREE.CylinderGeometry(1, 1, 1, 32), 0xd9a441, new THREE.Matrix4());
    this.holder = add(this.toolBody, new THREE.CylinderGeometry(1, 0.55, 1, 40), 0x8f9bad, new THREE.Matrix4());
    this.shapes.push(add(body, new THREE.CylinderGeometry(wide, 0.8 * wide, tall, 48), 0x7e8da3, along(up, nose.clone().addScaledVector(up, 0.5 * tall))));
    [...machine.tool_chain].reverse().forEach((joint, back) => {
      if (!joint.rotary) return;
      const on = this.bodies.tool_chain[machine.tool_chain.length - 1 - back], u = new THREE.Vector3(...joint.direction);
      const p = onAxis(joint, nose.clone().addScaledVector(up, tall));
      this.shapes.push(add(on, new THREE.CylinderGeometry(1.1 * wide, 1.1 * wide, 1.7 * wide, 48), [0x63748c, 0x4d5d73][back % 2], along(u, p)));
    });
  }

  corners(machine) {
    const out = [], { min, max } = this.box;
    for (const x of [min.x, max.x]) for (const y of [min.y, max.y]) for (const z of [min.z, max.z]) out.push(new THREE.Vector3(...placed(machine.frame, [x, y, z])));
    return out;
  }

  // Everything where it is at a time, with joints that are elsewhere where they are given.
  pose(t, q = this.player.motion.at(t)) {
    const { motion } = this.player, { machine } = motion, length = motion.length(t);
    const move = (groups, chain) => machine.bodies(chain, q).forEach((m, k) => set(groups[k], m));
    move(this.bodies.workpiece, machine.workpiece);
    move(this.bodies.tool_chain, machine.tool_chain);
    const w = product(machine.bodies(machine.workpiece, q).at(-1) || AT_REST, machine.frame);
    set(this.part, w);
    this.posed = q;
    this.shapeTool(machine, length);
    const shaped = !!this.workpiece && this.workpiece.pose(t, machine, length);
    this.toolShape.visible = this.holder.visible = !shaped;
    const tip = machine.tool(q, length).tip;
    // the part, the bed, or the tip stands still
    const seen = new THREE.Matrix4();
    if (this.mode !== "machine") seen.copy(this.part.matrix).invert();
    if (this.mode === "tool") seen.premultiply(new THREE.Matrix4().makeTranslation(...tip.map((v) => -v)));
    this.root.matrix.copy(seen);
    this.scene.updateMatrixWorld(true);
    this.draw();
  }

  shapeTool(machine, length) {
    if (length === this.shownLength) return;
    this.shownLength = length;
    const up = new THREE.Vector3(...machine.axis), nose = new THREE.Vector3(...machine.nose);
    const edge = Math.min(0.55 * length, 8 * this.thick), rest = Math.max(length - edge, 1e-3);
    const tip = nose.clone().addScaledVector(up, -length);
    this.toolShape.matrix.copy(along(up, tip.clone().addScaledVector(up, 0.5 * edge), this.thick / 2, edge));
    this.holder.matrix.copy(along(up, tip.clone().addScaledVector(up, edge + 0.5 * rest), 1.6 * this.thick, rest));
  }

  show(layer, visible) {
    if (layer === "machine") for (const shape of this.shapes) shape.visible = visible;
    else if (this.workpiece?.layers[layer]) this.workpiece.layers[layer].visible = visible;
    else this.lines[layer].visible = visible;
    this.draw();
  }

  look(mode) {
    this.mode = mode;
    this.pose(this.player.t, this.posed);
    this.frame();
  }

  // The view that shows what is cut, or the whole machine.
  frame() {
    const target = new THREE.Vector3();
    let size = this.size;
    if (this.mode === "tool") size = Math.max(0.35 * this.size, 8 * this.thick);
    else this.box.getCenter(target);
    if (this.mode === "machine") {
      target.applyMatrix4(this.part.matrix);
      target.z += 0.35 * this.size;
      size *= 2.4;
    }
    this.orbit = { target, far: (0.56 * size) / Math.tan((this.camera.fov * Math.PI) / 360), around: -0.95, above: 0.5 };
    this.aim();
  }

  aim() {
    const { target, far, around, above } = this.orbit, c = Math.cos(above);
    this.camera.position.set(target.x + far * c * Math.cos(around), target.y + far * c * Math.sin(around), target.z + far * Math.sin(above));
    this.camera.near = far / 200;
    this.camera.far = far * 60;
    this.camera.lookAt(target);
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.render(); });
  }

  render() { this.renderer.render(this.scene, this.camera); }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.element;
    if (!w || !h) return;
    this.renderer.setSize(w, h, false);
    this.camera.aspect = w / h;
    this.aim();
  }

  // Where a point of the part is on the screen, in pixels of the view.
  onScreen(point) {
    const p = new THREE.Vector3(...point).applyMatrix4(this.part.matrixWorld).project(this.camera);
    return [0.5 * (p.x + 1) * this.element.clientWidth, 0.5 * (1 - p.y) * this.element.clientHeight, p.z];
  }

  // The time at which the path is passed nearest to a place on the screen; null where it is not near.
  timeAt(x, y) {
    let best = REACH, found = null;
    for (let k = 1; k < this.times.length; k++) {
      if (!this.lines[this.kinds[k] === 1 ? "rapid" : "cutting"].visible) continue;
      const a = this.onScreen(this.tips[k - 1]), b = this.onScreen(this.tips[k]);
      const dx = b[0] - a[0], dy = b[1] - a[1], length = dx * dx + dy * dy;
      const u = length ? Math.min(Math.max(((x - a[0]) * dx + (y - a[1]) * dy) / length, 0), 1) : 0;
      const far = Math.hypot(a[0] + u * dx - x, a[1] + u * dy - y);
      if (far < best && a[2] < 1) { best = far; found = this.times[k - 1] + u * (this.times[k] - this.times[k - 1]); }
    }
    return found;
  }

  listen() {
    const canvas = this.renderer.domElement;
    let drag = null;
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointerdown", (event) => {
      drag = { x: event.clientX, y: event.clientY, moved: false, pan: event.button === 2 || event.shiftKey };
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!drag) return;
      const dx = event.clientX - drag.x, dy = event.clientY - drag.y;
      if (Math.abs(dx) + Math.abs(dy) > 3) drag.moved = true;
      if (!drag.moved) return;
      [drag.x, drag.y] = [event.clientX, event.clientY];
      if (drag.pan) this.pan(dx, dy); else this.turn(-0.007 * dx, 0.007 * dy);
    });
    canvas.addEventListener("pointerup", (event) => {
      if (drag && !drag.moved) {
        const box = canvas.getBoundingClientRect(), t = this.timeAt(event.clientX - box.left, event.clientY - box.top);
        if (t !== null) this.player.seek(t);
      }
      drag = null;
    });
    canvas.addEventListener("pointercancel", () => { drag = null; });
    canvas.addEventListener("dblclick", () => this.frame());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(0.0012 * event.deltaY));
    }, { passive: false });
    this.listenToKeys(canvas);
  }

  // The keys of the view while it has the focus; of all others the page knows.
  listenToKeys(canvas) {
    canvas.tabIndex = 0;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", "Path, tool and machine in space; arrows turn the view, plus and minus zoom");
    const turns = { ArrowLeft: [0.12, 0], ArrowRight: [-0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }, zooms = { "+": 0.85, "=": 0.85, "-": 1.18 };
    canvas.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey || !(turns[event.key] || zooms[event.key])) return;
      if (turns[event.key]) this.turn(...turns[event.key]); else this.zoom(zooms[event.key]);
      event.preventDefault();
      event.stopPropagation();
    });
  }

  turn(around, above) {
    this.orbit.around += around;
    this.orbit.above = Math.min(Math.max(this.orbit.above + above, -1.55), 1.55);
    this.aim();
  }

  zoom(by) {
    this.orbit.far = Math.min(Math.max(this.orbit.far * by, 0.02 * this.size), 60 * this.size);
    this.aim();
  }

  pan(dx, dy) {
    const scale = (2 * this.orbit.far * Math.tan((this.camera.fov * Math.PI) / 360)) / this.element.clientHeight;
    const side = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    this.orbit.target.addScaledVector(side, -scale * dx).addScaledVector(up, scale * dy);
    this.aim();
  }
}

function drawsBySoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  // browsers that do not tell it there have an extension for it, of which the others warn
  let name = gl.getParameter(gl.RENDERER);
  const info = /^webkit/i.test(name) && gl.getExtension("WEBGL_debug_renderer_info");
  if (info) name = gl.getParameter(info.UNMASKED_RENDERER_WEBGL);
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

function set(group, m) {
  group.matrix.set(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], 0, 0, 0, 1);
  group.matrixWorldNeedsUpdate = true;
}

// The point of a rotary joint's axis that is nearest to another.
function onAxis(joint, near) {
  const p = new THREE.Vector3(...joint.point), u = new THREE.Vector3(...joint.direction);
  return p.addScaledVector(u, near.clone().sub(p).dot(u));
}

// Turns the y of a shape to a direction, scales it across and along, and puts it to a point.
function along(direction, point, across = 1, length = 1) {
  const helper = Math.abs(direction.z) < 0.9 ? new THREE.Vector3(0, 0, 1) : new THREE.Vector3(1, 0, 0);
  const x = new THREE.Vector3().crossVectors(direction, helper).normalize(), z = new THREE.Vector3().crossVectors(x, direction);
  return new THREE.Matrix4().makeBasis(x, direction, z).scale(new THREE.Vector3(across, length, across)).setPosition(point);
}

// Turns the x of a shape to a direction and its z to another, as far as that goes.
function framed(x, z, point) {
  const y = new THREE.Vector3().crossVectors(z, x);
  if (y.length() < 1e-6) y.set(0, 1, 0);
  y.normalize();
  return new THREE.Matrix4().makeBasis(x, y, new THREE.Vector3().crossVectors(x, y)).setPosition(point);
}
