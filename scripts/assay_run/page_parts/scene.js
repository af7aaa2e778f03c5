/* The 3D view: draws one structure after one of the commands that wrote it, by three.js. */
"use strict";
const RED = "#d32f2f";
const FAR = 50;           // times the usual distance from the middle: what lies farther is no part of the first view
const MOST_EXTENT = 1e12; // in units of the view, in which floats are drawn
const MOST_MARKERS = 1000;
const CORNERS_MEASURED = 20000;
const DRAWINGS = ["surfaces", "wireframe", "boxes"];
const UPS = ["y", "z"];
const scene = { items: [], drawing: DRAWINGS[0], coloring: "structure", up: UPS[0], selected: null };

/* ---- what is drawn of a mesh */

/* Returns which primitives of a geometry findings are about. */
function redPrimitives(view, mesh, index) {
  const found = view.writes[mesh.write].findings.filter(one => one.geometry === null || one.geometry === index);
  return { isWhole: found.some(one => one.primitive === null), numbers: new Set(found.map(one => one.primitive)) };
}

/* Returns the triangles of a geometry, those of findings last, with the primitive of each; null if the page
   lacks them. */
function trianglesOf(view, mesh, index) {
  const geometry = mesh.geometries[index];
  if (geometry.positions === null || geometry.shown === 0) return null;
  if (geometry.triangles) return geometry.triangles;
  const { each, shown } = geometry;
  const numbers = geometry.primitives === null ? null : decodeArray(view, geometry.primitives, Uint32Array);
  const red = redPrimitives(view, mesh, index);
  const order = [[], []];
  for (let i = 0; i < shown; i++) order[red.isWhole || red.numbers.has(numbers ? numbers[i] : i) ? 1 : 0].push(i);
  const from = decodeArray(view, geometry.indices, Uint32Array), indices = new Uint32Array(from.length);
  order.flat().forEach((one, i) => indices.set(from.subarray(one * each, (one + 1) * each), i * each));
  const made = new THREE.BufferGeometry();
  made.setAttribute("position", new THREE.BufferAttribute(decodeArray(view, geometry.positions, Float32Array), 3));
  made.setIndex(new THREE.BufferAttribute(indices, 1));
  made.addGroup(0, order[0].length * each, 0);
  made.addGroup(order[0].length * each, order[1].length * each, 1);
  const primitives = order.flat().map(one => numbers ? numbers[one] : one);
  geometry.triangles = { made, each, primitives, at: face => primitives[Math.floor(face * 3 / each)] };
  return geometry.triangles;
}

/* Returns the box of a primitive in the coordinates of its mesh, or that of the mesh. */
function boxOfPrimitive(item, geometry, primitive) {
  const triangles = geometry === null ? null : trianglesOf(item.view, item.mesh, geometry);
  const place = triangles && primitive !== null ? triangles.primitives.indexOf(primitive) : -1;
  if (place < 0) return boxOfMesh(item.mesh);
  const box = new THREE.Box3(), corner = new THREE.Vector3();
  const { index, attributes } = triangles.made;
  for (let i = place * triangles.each; i < (place + 1) * triangles.each; i++)
    box.expandByPoint(corner.fromBufferAttribute(attributes.position, index.getX(i)));
  return box;
}

/* ---- placing */

function boxOfMesh(mesh) {
  const [x, y, z, ...most] = mesh.box;
  return new THREE.Box3(new THREE.Vector3(x, y, z), new THREE.Vector3(...most));
}

function unionOf(boxes) {
  return boxes.reduce((all, box) => all.union(box), new THREE.Box3());
}

/* Returns the box of all, or of those that are not far away from the others. */
function boxOfScene(items, hasAll) {
  const boxes = items.map(item => boxOfMesh(item.mesh).applyMatrix4(item.matrix));
  if (hasAll || boxes.length === 0) return unionOf(boxes);
  const medianOf = numbers => numbers.sort((a, b) => a - b)[numbers.length >> 1];
  const centers = boxes.map(box => box.getCenter(new THREE.Vector3()));
  const [x, y, z] = ["x", "y", "z"].map(axis => medianOf(centers.map(center => center[axis])));
  const middle = new THREE.Vector3(x, y, z);
  const extents = boxes.map((box, i) => centers[i].distanceTo(middle) + box.getSize(new THREE.Vector3()).length() / 2);
  const most = FAR * medianOf([...extents]);
  return unionOf(boxes.filter((_, i) => extents[i] <= most));
}

/* The scene is moved and scaled so that floats suffice to draw it, wherever it lies. */
function placementOf(box) {
  const center = box.getCenter(new THREE.Vector3()), size = box.getSize(new THREE.Vector3()).length() || 1;
  const turned = scene.up === "z" ? new THREE.Matrix4().makeRotationX(-Math.PI / 2) : new THREE.Matrix4();
  return turned.scale(new THREE.Vector3(2, 2, 2).divideScalar(size)).multiply(
    new THREE.Matrix4().makeTranslation(-center.x, -center.y, -center.z));
}

/* What the first view shows lies in it. */
function viewBox() {
  return new THREE.Box3(new THREE.Vector3(-1.1, -1.1, -1.1), new THREE.Vector3(1.1, 1.1, 1.1));
}

function placeInstances(keepsPlacement, hasAll) {
  const known = instancesOf(scene.moment), drawn = known.filter(item => item.mesh.box);
  if (!keepsPlacement) scene.placement = placementOf(boxOfScene(drawn, hasAll));
  for (const item of drawn) {
    item.placed = new THREE.Matrix4().multiplyMatrices(scene.placement, item.matrix);
    item.box = boxOfMesh(item.mesh).applyMatrix4(item.placed);
  }
  const isNear = ({ box, placed }) => [...box.min.toArray(), ...box.max.toArray(), ...placed.elements]
    .every(number => Math.abs(number) < MOST_EXTENT);
  scene.items = drawn.filter(isNear);
  scene.empty = known.length - drawn.length;
  scene.tooFar = drawn.length - scene.items.length;
  scene.outside = scene.items.filter(item => !viewBox().intersectsBox(item.box)).length;
}

/* ---- drawing */

function materialOf(color) {
  return new THREE.MeshPhongMaterial({ color, flatShading: true, side: THREE.DoubleSide, shininess: 5,
    wireframe: scene.drawing === "wireframe" });
}

/* No ray can be traced through what has no inverse transform. */
function isFlat(item) {
  return item.placed.determinant() === 0;
}

/* Draws items that have one mesh and one color. */
function addMeshes(group, items, color, red) {
  const [{ view, mesh }] = items;
  mesh.geometries.forEach((_, index) => {
    const triangles = trianglesOf(view, mesh, index);
    if (!triangles) return;
    /* Each mesh has a geometry of its own, whose arrays are shared: three.js r111 keeps one array of instances a geometry. */
    const { index: indices, attributes, groups } = triangles.made;
    const own = Object.assign(new THREE.BufferGeometry(), { index: indices, attributes, groups });
    const drawn = new THREE.InstancedMesh(own, [materialOf(color), red], items.length);
    items.forEach((item, i) => item.placed.toArray(drawn.instanceMatrix.array, 16 * i));
    drawn.frustumCulled = false;
    drawn.userData = { items, index, triangles };
    group.add(drawn);
  });
}

function addBoxes(group, items) {
  if (items.length === 0) return;
  const positions = [], colors = [];
  for (const { box, color } of items) {
    const corners = cornersOf(box).map(corner => corner.toArray()), { r, g, b } = new THREE.Color(color);
    for (let from = 0; from < 8; from++)
      for (const to of [from | 1, from | 2, from | 4].filter(other => other !== from)) {
        positions.push(...corners[from], ...corners[to]);
        colors.push(r, g, b, r, g, b);
      }
  }
  const made = new THREE.BufferGeometry();
  made.setAttribute("position", new THREE.Float32BufferAttribute(positions, 3));
  made.setAttribute("color", new THREE.Float32BufferAttribute(colors, 3));
  const lines = new THREE.LineSegments(made, new THREE.LineBasicMaterial({ vertexColors: THREE.VertexColors }));
  lines.frustumCulled = false;
  group.add(lines);
}

/* Dots of one size show where findings are, however small the triangles. */
function addMarkers(group) {
  const centers = [];
  for (const item of scene.items)
    for (const { geometry, primitive } of item.findings)
      if (centers.length < MOST_MARKERS)
        centers.push(boxOfPrimitive(item, geometry, primitive).applyMatrix4(item.placed)
          .getCenter(new THREE.Vector3()));
  if (centers.length === 0) return;
  const made = new THREE.BufferGeometry().setFromPoints(centers);
  const points = new THREE.Points(made, new THREE.PointsMaterial({ color: RED, size: 9, sizeAttenuation: false,
    depthTest: false, transparent: true }));
  points.frustumCulled = false;
  group.add(points);
}

function drawItems() {
  const group = new THREE.Group(), red = materialOf(RED);
  colorItems(scene);
  const groups = groupBy(scene.items, item => [`${item.structure} ${item.isRed} ${isFlat(item)}`]);
  if (scene.drawing !== "boxes")
    for (const items of groups.values()) addMeshes(group, items, items[0].color, red);
  addBoxes(group, scene.items.filter(item => scene.drawing === "boxes" ||
    item.mesh.geometries.some(geometry => geometry.positions === null)));
  addMarkers(group);
  if (scene.group) scene.root.remove(scene.group);
  scene.group = group;
  scene.root.add(group);
  outlineSelected();
}

/* Shows the moment: from one build of a structure to the next, nothing moves that the application did not move. */
function drawMoment(keepsPlacement, hasAll) {
  placeInstances(keepsPlacement, hasAll);
  drawItems();
  showSummary();
}

function outlineSelected() {
  if (scene.outline) scene.root.remove(scene.outline);
  scene.outline = new THREE.Group();
  if (scene.selected) addBoxes(scene.outline, [{ ...scene.selected, color: "#0b57d0" }]);
  scene.root.add(scene.outline);
  requestDraw();
}

function draw() {
  const { camera, controls, renderer } = scene, distance = camera.position.distanceTo(controls.target);
  const { clientWidth, clientHeight } = renderer.domElement, size = renderer.getSize(new THREE.Vector2());
  scene.isRequested = false;
  if (size.x !== clientWidth || size.y !== clientHeight) renderer.setSize(clientWidth, clientHeight, false);
  Object.assign(camera, { aspect: clientWidth / clientHeight, near: distance / 100, far: distance * 1000 });
  camera.updateProjectionMatrix();
  renderer.render(scene.root, camera);
}

function requestDraw() {
  if (!scene.isRequested) requestAnimationFrame(draw);
  scene.isRequested = true;
}

/* ---- camera and mouse */

function cornersOf({ min, max }) {
  return [0, 1, 2, 3, 4, 5, 6, 7].map(i => new THREE.Vector3(i & 1 ? max.x : min.x, i & 2 ? max.y : min.y,
    i & 4 ? max.z : min.z));
}

/* Moves the camera so that it just sees all of the boxes, in the middle of the picture. */
function lookAt(boxes) {
  const { camera, controls } = scene, half = Math.tan(camera.fov * Math.PI / 360);
  const { clientWidth, clientHeight } = scene.renderer.domElement;
  camera.position.set(0.5, 0.45, 1).normalize();
  camera.lookAt(0, 0, 0);
  const turned = camera.quaternion.clone().inverse();
  const corners = boxes.flatMap(cornersOf).map(corner => corner.applyQuaternion(turned));
  const target = new THREE.Box3().setFromPoints(corners).getCenter(new THREE.Vector3());
  let distance;
  for (let pass = 0; pass < 4; pass++) {
    const seen = corners.map(corner => corner.clone().sub(target));
    distance = seen.reduce((most, { x, y, z }) => Math.max(most, z + 1.05 * Math.max(Math.abs(y),
      Math.abs(x) * clientHeight / clientWidth) / half), 1e-9);
    const { x, y } = new THREE.Box2().setFromPoints(seen.map(corner => new THREE.Vector2(corner.x, corner.y)
      .divideScalar(distance - corner.z))).getCenter(new THREE.Vector2());
    if (pass < 3) target.add(new THREE.Vector3(x * distance, y * distance, 0));
  }
  controls.target.copy(target).applyQuaternion(camera.quaternion);
  camera.position.multiplyScalar(distance).add(controls.target);
  controls.update();
  requestDraw();
}

/* Returns the box of what is drawn of an item: closer than the corners of its mesh, turned. Of a large mesh,
   some corners suffice. */
function closeBox(item) {
  const box = new THREE.Box3(), corner = new THREE.Vector3();
  item.mesh.geometries.forEach((_, index) => {
    const positions = trianglesOf(item.view, item.mesh, index)?.made.attributes.position;
    const step = positions && Math.ceil(positions.count * scene.items.length / CORNERS_MEASURED);
    for (let i = 0; i < positions?.count; i += step)
      box.expandByPoint(corner.fromBufferAttribute(positions, i).applyMatrix4(item.placed));
  });
  return box.isEmpty() ? item.box : box;
}

function lookAtWhole() {
  const near = scene.items.filter(item => viewBox().intersectsBox(item.box));
  lookAt((near.length ? near : scene.items).map(closeBox));
}

/* Returns the item under the mouse, and its geometry and primitive, if triangles are drawn. */
function pick(event) {
  const { left, top, width, height } = scene.renderer.domElement.getBoundingClientRect();
  const ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2(2 * (event.clientX - left) / width - 1, 1 - 2 * (event.clientY - top) / height),
    scene.camera);
  const [hit] = ray.intersectObjects(scene.group.children.filter(child => child.isInstancedMesh &&
    !isFlat(child.userData.items[0])));
  if (hit) {
    const { items, index, triangles } = hit.object.userData;
    return { item: items[hit.instanceId], geometry: index, primitive: triangles.at(hit.faceIndex) };
  }
  const point = new THREE.Vector3();
  const distance = item => ray.ray.intersectBox(item.box, point) ? point.distanceTo(ray.ray.origin) : Infinity;
  const boxes = scene.items.filter(item => scene.drawing === "boxes" || isFlat(item) ||
    item.mesh.geometries.some(geometry => geometry.positions === null));
  const [item] = boxes.filter(one => distance(one) < Infinity).sort((a, b) => distance(a) - distance(b));
  return { item: item ?? null, geometry: null, primitive: null };
}

function select(picked) {
  scene.selected = picked.item;
  showObject(picked);
  outlineSelected();
}

/* Shows what a finding is about: the camera goes there. */
function showTarget({ moment, geometry, primitive, isAbout }) {
  showMoment(moment);
  let item = scene.items.find(isAbout);
  if (!item && scene.tooFar) {
    drawMoment(false, true);
    item = scene.items.find(isAbout);
  }
  if (item) {
    select({ item, geometry, primitive });
    lookAt([boxOfPrimitive(item, geometry, primitive).applyMatrix4(item.placed)]);
  } else {
    showObject({ item: instancesOf(moment).find(isAbout), geometry, primitive });
    get("scene-object").prepend(element("p", "What the finding is about cannot be drawn; the list below says what is not shown."));
  }
  get("scene-canvas").scrollIntoView({ block: "center" });
  get("scene-canvas").focus({ preventScroll: true });
}

function makePicture(canvas) {
  const context = canvas.getContext("webgl", { antialias: false }); // a CPU that draws takes twice as long with it
  if (!context) return false;
  scene.renderer = new THREE.WebGLRenderer({ canvas, context, alpha: true });
  scene.renderer.setPixelRatio(window.devicePixelRatio);
  scene.root = new THREE.Scene();
  scene.camera = new THREE.PerspectiveCamera(40);
  scene.controls = new THREE.OrbitControls(scene.camera, canvas);
  scene.controls.screenSpacePanning = true;
  scene.controls.enableZoom = false;
  const light = new THREE.DirectionalLight("#ffffff", 0.6);
  light.position.set(1, 2, 3);
  scene.root.add(scene.camera.add(light), new THREE.AmbientLight("#ffffff", 0.5));
  scene.controls.addEventListener("change", requestDraw);
  new ResizeObserver(requestDraw).observe(canvas);
  /* The wheel scrolls the page until the canvas is in use. */
  for (const kind of ["focus", "blur"])
    canvas.addEventListener(kind, () => { scene.controls.enableZoom = kind === "focus"; });
  let down = null;
  canvas.addEventListener("mousedown", event => { down = event; });
  canvas.addEventListener("click", event => {
    if (down && Math.hypot(event.clientX - down.clientX, event.clientY - down.clientY) < 4) select(pick(event));
  });
  canvas.addEventListener("keydown", event => {
    const factor = { "+": 0.8, "=": 0.8, "-": 1.25 }[event.key];
    if (!factor) return;
    scene.camera.position.sub(scene.controls.target).multiplyScalar(factor).add(scene.controls.target);
    requestDraw();
  });
  return true;
}
