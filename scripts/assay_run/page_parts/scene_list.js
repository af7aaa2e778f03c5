/* What the 3D view can show and what is known of it: moments, colors, legends, objects and findings, as text. */
"use strict";
const LEGEND_SHOWN = 12;
const FOUND = "what findings are about";
const AGES = [["#f6d746", 0, "in the same"], ["#7ad151", 1, "1"], ["#22a884", 9, "2 to 9"], ["#2a788e", 99, "10 to 99"],
  ["#414487", Infinity, "100 or more"]];
const INSTANCE_FLAGS = ["TRIANGLE_FACING_CULL_DISABLE", "TRIANGLE_FLIP_FACING", "FORCE_OPAQUE", "FORCE_NO_OPAQUE",
  "FORCE_OPACITY_MICROMAP_2_STATE", "DISABLE_OPACITY_MICROMAPS"];

/* ---- data */

function decodeArray(view, index, Type) {
  if (typeof view.arrays[index] === "string") {
    const text = atob(view.arrays[index]), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    view.arrays[index] = bytes.buffer;
  }
  return new Type(view.arrays[index]);
}

/* Returns the instances of a moment. A structure that is shown alone is an instance of itself. */
function instancesOf(moment) {
  if (moment.items) return moment.items;
  const { view } = moment, contents = new Map();
  for (let i = 0; i < moment.contents.length; i += 2) {
    const write = view.writes[moment.contents[i]];
    contents.set(write.structure, { write, mesh: view.meshes[moment.contents[i + 1]] });
  }
  const [floats, words] = [Float32Array, Uint32Array].map(Type => decodeArray(view, view.rows, Type));
  const ofTop = moment.isTop ? view.writes[moment.content].findings : [];
  moment.items = [];
  for (const row of decodeArray(view, moment.instances, Uint32Array)) {
    const at = 16 * row;
    const [custom, offset, structure, number] = words.subarray(at + 12, at + 16);
    const { write, mesh } = contents.get(structure), own = ofTop.filter(one => one.primitive === number)
      .map(({ finding }) => ({ finding, geometry: null, primitive: null }));
    moment.items.push({ view, moment, structure, number, write, mesh, isRed: own.length > 0,
      findings: [...own, ...view.writes[mesh.write].findings],
      matrix: new THREE.Matrix4().set(...floats.subarray(at, at + 12), 0, 0, 0, 1),
      customIndex: custom & 0xffffff, mask: custom >>> 24, offset: offset & 0xffffff, flags: offset >>> 24 });
  }
  return moment.items;
}

function nameOf(view, structure) {
  const { handle, name } = view.structures[structure];
  return name ? `“${name}”` : handle;
}

/* Findings belong to the writes that they are about. */
function readScene() {
  scene.views = data.scene.views;
  for (const view of scene.views) {
    for (const write of view.writes) write.findings = [];
    for (const moment of view.moments) moment.view = view;
  }
  for (const finding of data.new)
    for (const [view, write, geometry, primitive] of finding.shown ?? [])
      scene.views[view].writes[write].findings.push({ finding, geometry, primitive });
  const keyOf = ({ view, write }) => `${scene.views.indexOf(view)} ${view.writes[write].structure}`;
  scene.entries = [...groupBy(scene.views.flatMap(view => view.moments), moment => [keyOf(moment)]).values()];
  const numberOf = moment => moment.view.writes[moment.write].n;
  for (const list of scene.entries) list.sort((a, b) => numberOf(a) - numberOf(b));
}

function titleOf([moment]) {
  const { view, write, isTop } = moment;
  const process = scene.views.length > 1 ? `, process ${data.processes[view.process]}` : "";
  return `${nameOf(view, view.writes[write].structure)}${isTop ? "" : ", in no top-level structure"}${process}`;
}

/* Such as: update of “rock” in submission 3, frame 12, labels load. */
function describeWrite(view, write) {
  const what = { ...COPIES, build: "build", update: "update" }[write.mode] ?? write.mode;
  const where = write.submission ? ` in submission ${write.submission}` : " by the host";
  const frame = view.writes.some(other => other.frame) ? `, frame ${write.frame}` : "";
  const labels = write.labels ? `, labels ${write.labels.replaceAll("::", " › ")}` : "";
  return `${what}${where}${frame}${labels} (command ${write.n} of the capture)`;
}

/* ---- colors */

/* Far from red, and from each other. */
function hueColor(number) {
  return `#${new THREE.Color().setHSL(0.12 + 0.76 * (number * 0.618034 % 1), 0.5, 0.6).getHexString()}`;
}

/* Returns the structures that are alive at a moment, by memory and place in it. */
function structuresAt({ view, write }) {
  const at = view.writes[write].n;
  return Object.entries(view.structures)
    .map(([key, one]) => ({ ...one, structure: Number(key), end: one.offset + one.size }))
    .filter(one => one.memory !== undefined && one.born <= at && !(one.died <= at))
    .sort((a, b) => a.memory - b.memory || a.offset - b.offset);
}

function sharersOf(moment, structure) {
  const all = structuresAt(moment), one = all.find(other => other.structure === structure);
  return all.filter(other => one && other !== one && other.memory === one.memory && other.offset < one.end &&
    one.offset < other.end).map(other => other.structure);
}

/* Returns all structures that share memory: each with the one that reaches farthest of those before it. */
function findSharers(moment) {
  const found = new Set();
  let farthest = null;
  for (const one of structuresAt(moment)) {
    if (farthest?.memory !== one.memory) farthest = null;
    if (farthest && one.offset < farthest.end) found.add(one.structure).add(farthest.structure);
    if (!farthest || one.end > farthest.end) farthest = one;
  }
  return found;
}

const COLORINGS = {
  structure: item => [nameOf(item.view, item.structure), hueColor(item.structure)],
  flags: item => [describeFlags(item.write.flags), hueColor(Number(item.write.flags))],
  "age since the last build": item => {
    const { writes } = item.view, now = writes[item.moment.write], unit = now.frame ? "frame" : "submission";
    const age = Math.max(0, now[unit] - item.write[unit]);
    const [color, , span] = AGES.find(([, most]) => age <= most);
    return [`written ${span} ${unit}${age > 1 ? "s" : ""}${age ? " before" : ""}`, color];
  },
  "overlap of memory": item => {
    const { view, structure, moment } = item;
    if (view.structures[structure].memory === undefined) return ["memory is not known", "#b0b7bf"];
    moment.sharers ??= findSharers(moment);
    return moment.sharers.has(structure)
      ? ["shares memory with another structure", "#e08a00"] : ["has memory of its own", "#5b83b8"];
  },
};

function colorItems({ items, coloring }) {
  const known = new Map(), legend = new Map();
  const count = (label, color, more) => legend.set(label, { color, count: (legend.get(label)?.count ?? 0) + more });
  for (const item of items) {
    if (!known.has(item.structure)) known.set(item.structure, COLORINGS[coloring](item));
    const [label, color] = known.get(item.structure);
    item.color = item.isRed ? RED : color;
    count(label, color, 1);
    if (item.findings.length) count(FOUND, RED, item.findings.length);
  }
  const rank = ([label, { count }]) => label === FOUND ? Infinity : count;
  const lines = [...legend].sort((a, b) => rank(b) - rank(a)).map(([label, { color, count }]) => {
    const line = element("li"), swatch = element("span", undefined, "swatch");
    swatch.style.background = color;
    line.append(swatch, `${label} (${count.toLocaleString("en")})`);
    return line;
  });
  const rest = lines.splice(LEGEND_SHOWN).length;
  if (rest) lines.push(element("li", `and ${rest.toLocaleString("en")} more`, "muted"));
  get("scene-legend").replaceChildren(...lines);
}

/* ---- text */

function addCounts(total, counts) {
  for (const [what, count] of Object.entries(counts)) if (count) total[what] = (total[what] ?? 0) + count;
}

function showSummary() {
  const { moment, items } = scene, { view } = moment, meshes = new Set(instancesOf(moment).map(item => item.mesh));
  const list = scene.entries.find(one => one.includes(moment)), place = list.indexOf(moment) + 1;
  const primitives = items.flatMap(({ mesh }) => mesh.geometries).reduce((sum, { shown }) => sum + shown, 0);
  const findings = new Set(items.flatMap(item => item.findings.map(one => one.finding))).size;
  const write = view.writes[moment.write];
  get("scene-summary").textContent = `${place} of ${list.length}: ${nameOf(view, write.structure)} after the ` +
    `${describeWrite(view, write)}: ${moment.isTop ? `${plural(items.length, "instance")} of ` +
    `${plural(meshes.size, "structure")}, ` : ""}${plural(primitives, "primitive")}, ${plural(findings, "finding")}.`;
  const leftOut = { "instances of structures in which nothing is active": scene.empty,
    "instances for which the page has no room": moment.noRoom,
    "instances too far away to be drawn beside the others": scene.tooFar,
    "structures whose triangles the page has no room for, so that only boxes are drawn":
      [...meshes].filter(mesh => mesh.geometries.some(geometry => geometry.positions === null)).length };
  addCounts(leftOut, moment.leftOut);
  for (const mesh of meshes) addCounts(leftOut, mesh.leftOut);
  const notes = Object.entries(leftOut).filter(([, count]) => count)
    .map(([what, count]) => `Not shown: ${what}: ${count.toLocaleString("en")}.`);
  if (scene.outside)
    notes.push(`${plural(scene.outside, "instance lies", "instances lie")} far from the others, outside the first view: ` +
      "button Whole scene.");
  get("scene-notes").replaceChildren(...[...notes, ...captureNotes(view)].map(note => element("li", note)));
}

/* What the whole capture lacks. */
function captureNotes(view) {
  const notes = [];
  if (view.leftOut)
    notes.push(`${plural(view.leftOut, "earlier build is", "earlier builds are")} left out: the page has no room.`);
  if (view.missing)
    notes.push(`${plural(view.missing, "structure was", "structures were")} built before the capture began.`);
  if (!view.end) notes.push("The process ended before its capture was complete: the last builds may be missing.");
  else if (!view.end.includes("destroyed"))
    notes.push(`The capture ends early: ${view.end}. What came later is not shown.`);
  return notes;
}

/* Shows all that is known of an object. */
function showObject({ item, geometry, primitive }) {
  get("scene-object").replaceChildren();
  if (!item) return;
  const { view, moment, structure, write, mesh } = item, one = view.structures[structure];
  const list = element("ul");
  const add = (...parts) => list.append(itemElement(...parts));
  if (moment.isTop)
    add(`instance ${item.number} of ${nameOf(view, view.writes[moment.write].structure)}: ` +
      `custom index ${item.customIndex}, mask 0x${item.mask.toString(16)}, offset ${item.offset}, ` +
      (INSTANCE_FLAGS.filter((_, bit) => item.flags >> bit & 1).join(", ") || "no flags"));
  if (geometry !== null) {
    const { each, opaque } = mesh.geometries[geometry], noun = each === 3 ? "triangle" : "AABB";
    add(`geometry ${geometry}${opaque ? ", opaque" : ""}${primitive === null ? "" : `: ${noun} ${primitive}`}`);
  }
  add(objectLink({ type: one.type, handle: one.handle, name: "" }, view.process, scene.structures));
  add(`last written by the ${describeWrite(view, write)}`);
  const record = findStructure(scene.structures, one.handle, view.process);
  if (record) add(`${plural(record.builds, "build")} and ${plural(record.updates, "update")} in the whole run`);
  add(describeFlags(write.flags));
  add(`${plural(mesh.geometries.reduce((sum, each) => sum + each.count, 0), "primitive")} in ` +
    plural(mesh.geometries.length, "geometry", "geometries"));
  add(bytesText(one.size) + (one.memory === undefined ? "" :
    `, from byte ${one.offset.toLocaleString("en")} of memory ${one.memory} of the capture`));
  for (const other of sharersOf(moment, structure))
    add(`shares memory with ${nameOf(view, other)}`);
  get("scene-object").append(element("h3", nameOf(view, structure)), list);
  showFindingsOf(item);
}

function showFindingsOf(item) {
  const found = [...new Set(item.findings.map(one => one.finding))];
  if (!found.length) return;
  const list = element("ul");
  list.append(...found.slice(0, COMMANDS_SHOWN).map(finding => itemElement(linkButton(finding.id, () => {
    finding.article.tabIndex = -1;
    finding.article.focus();
  }))));
  get("scene-object").append(element("h3", plural(found.length, "finding")), list);
}

/* ---- findings */

function holds({ view, contents }, isWanted) {
  return contents.some((one, i) => i % 2 === 0 && isWanted(view.writes[one], view.meshes[contents[i + 1]]));
}

/* Returns where the view shows what a finding is about, the present moment first; null if nowhere. */
function exactTarget(finding, moments) {
  for (const [index, write, geometry, primitive] of finding.shown ?? []) {
    const isOfView = moment => moment.view === scene.views[index];
    const top = moments.find(moment => isOfView(moment) && moment.isTop && moment.content === write);
    if (top) return { moment: top, geometry: null, primitive: null, isAbout: item => item.number === primitive };
    const holder = moments.find(moment => isOfView(moment) && holds(moment, (_, mesh) => mesh.write === write));
    if (holder) return { moment: holder, geometry, primitive, isAbout: item => item.mesh.write === write };
  }
  return null;
}

/* Returns where the view shows a structure that a finding names; null if nowhere. */
function structureTarget(finding, moments) {
  const handles = finding.objects.filter(one => one.type.startsWith("VkAccelerationStructure")).map(one => one.handle);
  const isNamed = (view, { structure }) => handles.includes(view.structures[structure].handle);
  const moment = moments.find(one => [null, one.view.process].includes(finding.reports[0].process) &&
    holds(one, write => isNamed(one.view, write)));
  return moment ? { moment, geometry: null, primitive: null, isAbout: item => isNamed(item.view, item) } : null;
}

/* A control that leads into the picture, or null if it shows nothing of the finding. */
function sceneLink(finding) {
  if (!scene.renderer) return null;
  const moments = [scene.moment, ...scene.entries.flat()];
  const exact = exactTarget(finding, moments), target = exact ?? structureTarget(finding, moments);
  return target && linkButton(exact ? "show in the scene" : "show the structure in the scene", () => showTarget(target));
}

/* ---- controls */

function showMoment(moment) {
  if (scene.moment === moment) return;
  const list = scene.entries.find(one => one.includes(moment)), keepsPlacement = list.includes(scene.moment);
  Object.assign(scene, { moment, selected: null });
  get("scene-structure").value = scene.entries.indexOf(list);
  Object.assign(get("scene-moment"), { max: list.length - 1, value: list.indexOf(moment) });
  get("scene-moments").hidden = list.length === 1;
  showObject({ item: null });
  drawMoment(keepsPlacement, false);
}

function fillSelect(control, names) {
  get(control).append(...names.map((name, i) => {
    const option = element("option", name);
    option.value = i;
    return option;
  }));
}

function listenToControls() {
  const list = () => scene.entries[get("scene-structure").value];
  const last = moments => moments[moments.length - 1];
  get("scene-structure").addEventListener("input", () => { showMoment(last(list())); lookAtWhole(); });
  get("scene-moment").addEventListener("input", () => showMoment(list()[get("scene-moment").value]));
  get("scene-draw").addEventListener("input", () => {
    scene.drawing = DRAWINGS[get("scene-draw").value];
    drawItems();
  });
  get("scene-color").addEventListener("input", () => {
    scene.coloring = Object.keys(COLORINGS)[get("scene-color").value];
    drawItems();
  });
  get("scene-up").addEventListener("input", () => {
    scene.up = UPS[get("scene-up").value];
    drawMoment(false, false);
    lookAtWhole();
  });
  get("scene-whole").addEventListener("click", () => { drawMoment(false, true); lookAtWhole(); });
  const targets = data.new.map(finding => exactTarget(finding, scene.entries.flat())).filter(Boolean);
  let next = 0;
  get("scene-next").hidden = targets.length === 0;
  get("scene-next").addEventListener("click", () => showTarget(targets[next++ % targets.length]));
}

function explainScene(why, isShown) {
  get("scene-why").textContent = why;
  get("scene-why").hidden = !why;
  get("scene-view").hidden = !isShown;
}

/* Whatever goes wrong here, the rest of the page is shown. */
function showScene(structures) {
  const { why, views } = data.scene;
  explainScene(why, views.length > 0);
  if (views.length === 0) return;
  try {
    showPicture(structures);
  } catch (error) {
    explainScene(`There is no picture, because of ${error}.`, false);
    scene.renderer = null;
    console.error(error);
  }
}

function showPicture(structures) {
  if (!makePicture(get("scene-canvas"))) {
    explainScene("There is no picture, because this browser has no WebGL.", false);
    return;
  }
  scene.structures = structures;
  readScene();
  fillSelect("scene-structure", scene.entries.map(titleOf));
  fillSelect("scene-draw", DRAWINGS);
  fillSelect("scene-up", UPS);
  fillSelect("scene-color", Object.keys(COLORINGS));
  const [first] = scene.entries;
  showMoment(first[first.length - 1]);
  lookAtWhole();
  listenToControls();
}
