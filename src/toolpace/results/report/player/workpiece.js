// What is machined, in the view: the stock as it is cut, the finished part, fixtures, and the tools as they are.
const RAW = [0.42, 0.47, 0.54], MACHINED = [0.78, 0.82, 0.87];
const PART_COLOUR = 0x36c08a, FIXTURE_COLOUR = 0x8a6a4f, COLLISION_COLOUR = 0xe5484d, TOOL_COLOURS = [0xe0ab45, 0xb9c2cf, 0x77849a];
const AROUND = 40;  // facets of a tool
const REST = 4;  // times as long as it took to shape the stock, until it is shaped again while the motion is played

class Workpiece {
  constructor(space, data, arrays) {
    this.space = space;
    this.stock = data.stock ? new Stock(data.stock, arrays) : null;
    this.layers = {};
    if (this.stock) this.layers.stock = this.add(new THREE.BufferGeometry(), { vertexColors: true });
    if (data.part) this.layers.part = this.add(mesh(arrays.numbers(data.part)), { color: PART_COLOUR, transparent: true, opacity: 0.45, depthWrite: false });
    if (data.part) this.layers.part.visible = false;
    if (data.fixtures.length) {
      this.layers.fixtures = space.fixed(space.part);
      for (const each of data.fixtures) this.layers.fixtures.add(this.body(mesh(arrays.numbers(each)), { color: FIXTURE_COLOUR }));
    }
    if (space.player.findings.length) this.layers.collisions = this.markers(space.player.findings);
    this.tools = data.tools.map((solids) => (solids ? this.tool(solids) : null));
  }

  body(geometry, look) {
    // lines on a face are in front of it
    const shown = new THREE.Mesh(geometry, new THREE.MeshLambertMaterial({ flatShading: true, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2, ...look }));
    shown.frustumCulled = false;
    return shown;
  }

  add(geometry, look) {
    const shown = this.body(geometry, look);
    this.space.part.add(shown);
    return shown;
  }

  // Pins whose points are where the tool meets what it must not.
  markers(findings) {
    const group = this.space.fixed(this.space.part), size = 0.03 * this.space.size;
    for (const { place } of findings) {
      const pin = new THREE.Mesh(new THREE.CylinderGeometry(0.3 * size, 0, size, 16), new THREE.MeshLambertMaterial({ color: COLLISION_COLOUR }));
      pin.matrixAutoUpdate = false;
      pin.matrix.copy(along(new THREE.Vector3(0, 0, 1), new THREE.Vector3(place[0], place[1], place[2] + 0.5 * size)));
      group.add(pin);
    }
    return group;
  }

  tool(solids) {
    const group = this.space.fixed(this.space.toolBody);
    for (const { part, outline } of solids) group.add(this.body(revolved(outline), { color: TOOL_COLOURS[part], flatShading: false }));
    const [top, radius] = solids.at(-1).outline.at(-1), held = solids.some(({ part }) => part === 2);
    // what holds the tool, where the sheet does not tell it
    const rest = this.body(new THREE.CylinderGeometry(1, 1, 1, AROUND), { color: TOOL_COLOURS[2], flatShading: false });
    rest.matrixAutoUpdate = false;
    group.add(rest);
    group.visible = false;
    group.userData = { rest, top, radius: radius * (held ? 1 : 1.6) };
    return group;
  }

  // The stock as it is at a time, and the tool of the operation; whether there is one.
  pose(t, machine, length) {
    const { player } = this.space, stage = this.stock ? this.stock.stageAt(t, player.duration) : -1;
    // a computer without graphics gets a quarter of the triangles while it plays
    const coarse = this.space.plain && !!player.playing;
    if (stage >= 0 && (stage !== this.stage || coarse !== this.coarse) && !(player.playing && performance.now() < this.rested)) this.shape(stage, coarse);
    const now = this.tools[player.operationAt(t)] || null;
    for (const each of this.tools) if (each) each.visible = each === now;
    if (now) {
      const up = new THREE.Vector3(...machine.axis);
      now.matrix.copy(along(up, new THREE.Vector3(...machine.nose).addScaledVector(up, -length)));
      const { rest, top, radius } = now.userData, long = Math.max(length - top, 1e-3);
      rest.visible = length > top;
      rest.matrix.copy(along(new THREE.Vector3(0, 1, 0), new THREE.Vector3(0, top + 0.5 * long, 0), radius, long));
    }
    return !!now;
  }

  shape(stage, coarse) {
    const begin = performance.now(), { corners, triangles, cut } = this.stock.surface(stage, coarse), colours = new Float32Array(corners.length);
    cut.forEach((share, k) => { for (let d = 0; d < 3; d++) colours[3 * k + d] = RAW[d] + share * (MACHINED[d] - RAW[d]); });
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(corners, 3));
    geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
    geometry.setIndex(new THREE.BufferAttribute(triangles, 1));
    this.layers.stock.geometry.dispose();
    this.layers.stock.geometry = geometry;
    [this.stage, this.coarse] = [stage, coarse];
    this.rested = performance.now() + REST * (performance.now() - begin);
  }
}

function mesh(values) {
  return new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(Float32Array.from(values), 3));
}

// A solid about the y axis from the heights and radii of its outline, with normals that are smooth around.
function revolved(outline) {
  const points = [], normals = [], faces = [];
  const ends = [[outline[0][0], 0], ...outline, [outline.at(-1)[0], 0]];
  for (let i = 0; i + 1 < ends.length; i++) {
    const [[za, ra], [zb, rb]] = [ends[i], ends[i + 1]], size = Math.hypot(zb - za, rb - ra);
    if (size < 1e-9) continue;
    const first = points.length / 3, across = (zb - za) / size, up = (ra - rb) / size;
    for (let k = 0; k <= AROUND; k++) {
      const c = Math.cos((2 * Math.PI * k) / AROUND), s = Math.sin((2 * Math.PI * k) / AROUND);
      points.push(ra * c, za, ra * s, rb * c, zb, rb * s);
      normals.push(across * c, up, across * s, across * c, up, across * s);
      const a = first + 2 * k;
      if (k < AROUND) faces.push(a, a + 1, a + 3, a, a + 3, a + 2);
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(Float32Array.from(points), 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(Float32Array.from(normals), 3));
  geometry.setIndex(new THREE.BufferAttribute(Uint32Array.from(faces), 1));
  return geometry;
}
