/* Acceleration structures: what became of each, and the memory of those that are alive. */
"use strict";
const ROWS_AT_ONCE = 100;
const CHAIN_SHOWN = 5;
const CURVE_POINTS = 400;
const CURVE_WIDTH = 1000;
const CURVE_HEIGHT = 150;
const FLAGS = ["ALLOW_UPDATE", "ALLOW_COMPACTION", "PREFER_FAST_TRACE", "PREFER_FAST_BUILD", "LOW_MEMORY",
  "MOTION", "ALLOW_OPACITY_MICROMAP_UPDATE", "ALLOW_DISABLE_OPACITY_MICROMAPS",
  "ALLOW_OPACITY_MICROMAP_DATA_UPDATE", "ALLOW_DISPLACEMENT_MICROMAP_UPDATE", "", "ALLOW_DATA_ACCESS"];
const ORDERS = {
  "first built": () => 0,
  size: (a, b) => (b.size || 0) - (a.size || 0),
  scratch: (a, b) => (b.build_scratch || 0) - (a.build_scratch || 0),
  updates: (a, b) => b.updates - a.updates,
  findings: (a, b) => b.findings + b.advice - a.findings - a.advice,
};

/* A handle may be used again: a structure never changes its size, nor its memory. */
function isSame(one, line) {
  return ["size", "memory", "memory_offset"].every(
    member => one[member] === undefined || line[member] === undefined || one[member] === line[member]);
}

function describeFlags(flags) {
  const value = Number(flags);
  const words = FLAGS.filter((name, bit) => name && value >> bit & 1);
  const rest = FLAGS.reduce((left, name, bit) => name ? left & ~(1 << bit) : left, value);
  return [...words, ...rest ? [`0x${rest.toString(16)}`] : []].join(", ") || "no flags";
}

function describeOrigin(line, names) {
  if (line.Type === "Copy")
    return line.src ? `${COPIES[line.mode]} of ${named(line.src, names.get(line.src))}` : COPIES[line.mode];
  const where = line.command_buffer
    ? `command buffer ${named(line.command_buffer, line.command_buffer_name)}` : "the host";
  const position = line.build === undefined ? "" : `, build ${line.build}`;
  const submission = line.submission === undefined ? "" : `, submission ${line.submission}`;
  return `${where}${position}${submission}`;
}

function addLine(one, line, names) {
  if (line.dst_name) one.name = line.dst_name;
  if (line.type) one.type = line.type;
  if (line.mode === "update") {
    one.updates++;
    one.by = one.by || `update, ${describeOrigin(line, names)}`;
    const source = line.src && line.src !== line.dst ? named(line.src, names.get(line.src)) : "";
    if (source && !one.chain.includes(source)) one.chain.push(source);
  } else if (line.mode) {
    Object.assign(one, { by: describeOrigin(line, names), updates: 0, chain: [],
      builds: one.builds + (line.Type === "Build" ? 1 : 0), compacted_size: undefined,
      build_scratch: undefined, update_scratch: undefined });
  }
  if (line.scratch_size !== undefined)
    one[line.mode === "update" ? "update_scratch" : "build_scratch"] = line.scratch_size;
  for (const member of ["primitives", "size", "compacted_size", "memory", "memory_offset", "flags",
    "references", "referring"])
    if (line[member] !== undefined) one[member] = line[member];
}

/* The structures that were written, and how many bytes those that were alive had after each line. The
   counts of processes are apart: their memory may be of several hosts. */
function structuresOf(builds, names) {
  const structures = [], current = new Map(), curves = new Map();
  const note = (line, change) => {
    if (!curves.has(line.process)) curves.set(line.process, { bytes: 0, submissions: 0, place: { submission: 0 }, points: [] });
    const curve = curves.get(line.process);
    curve.bytes += change;
    if (line.Type === "Submission") curve.place = { ...line, submission: ++curve.submissions };
    curve.points.push({ ...curve.place, bytes: curve.bytes, ms: line.ms });
    return curve;
  };
  for (const line of builds) {
    const key = `${line.process} ${line.device} ${line.dst}`;
    let one = line.dst && current.get(key);
    if (line.Type === "Destroyed") {
      current.delete(key);
      if (one) one.destroyed = note(line, -(one.size || 0)).submissions;
      continue;
    }
    if (!line.dst) {
      note(line, 0);
      continue;
    }
    if (line.Type === "Instances" && !one) continue; // destroyed before they were read
    if (!one || !isSame(one, line)) {
      if (one) note(line, -(one.size || 0));
      one = { handle: line.dst, process: line.process, name: "", type: "", by: "", chain: [], updates: 0,
        builds: 0, findings: 0, advice: 0 };
      current.set(key, one);
      structures.push(one);
      note(line, line.size || 0);
    }
    addLine(one, line, names);
  }
  return { structures, curves };
}

/* ---- memory */

function bytesText(bytes) {
  const units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  for (; bytes >= 1024 && unit < units.length - 1; unit++) bytes /= 1024;
  return `${bytes.toLocaleString("en", { maximumFractionDigits: unit ? 1 : 0 })} ${units[unit]}`;
}

/* Each step of the curve is the largest value of so many points. */
function stepsOf(points) {
  const each = Math.ceil(points.length / CURVE_POINTS);
  const steps = [];
  for (let i = 0; i < points.length; i += each)
    steps.push(points.slice(i, i + each).reduce((most, point) => point.bytes > most.bytes ? point : most));
  return steps;
}

function drawing(name, attributes, title) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (title) made.append(drawing("title", {}));
  if (title) made.firstChild.textContent = title;
  return made;
}

function describePoint(point) {
  return `${describePlace(point, point)}${point.ms === undefined ? "" : `, ${seconds(point.ms)}`}: ` +
    bytesText(point.bytes);
}

function curveElement(points, peak) {
  const steps = stepsOf(points), width = CURVE_WIDTH / steps.length;
  const height = point => CURVE_HEIGHT * point.bytes / Math.max(1, peak.bytes);
  const image = drawing("svg", { viewBox: `0 0 ${CURVE_WIDTH} ${CURVE_HEIGHT}`, preserveAspectRatio: "none",
    role: "img", "aria-label": `Memory of structures that are alive. Peak: ${describePoint(peak)}` });
  const line = steps.map((point, i) => {
    const y = CURVE_HEIGHT - height(point);
    return `${i ? "L" : "M"}${i * width} ${y}H${(i + 1) * width}`;
  }).join("");
  image.append(drawing("path", { class: "area", d: `${line}V${CURVE_HEIGHT}H0Z` }),
    drawing("path", { class: "line", d: line, "vector-effect": "non-scaling-stroke" }));
  steps.forEach((point, i) => image.append(drawing("rect", { x: i * width, y: 0, width,
    height: CURVE_HEIGHT, class: "point" }, describePoint(point))));
  return image;
}

function showMemory(curves) {
  const shown = [...curves].filter(([, curve]) => curve.points.some(point => point.bytes));
  get("memory-section").hidden = shown.length === 0;
  for (const [process, { points }] of shown) {
    const peak = points.reduce((most, point) => point.bytes > most.bytes ? point : most);
    const last = points[points.length - 1];
    const figure = element("figure");
    const of = data.processes.length > 1 ? `Process ${data.processes[process]}. ` : "";
    figure.append(element("figcaption", `${of}Peak: ${describePoint(peak)}. ` +
      `At the end: ${bytesText(last.bytes)}.`), curveElement(points, peak), axisElement(points[0], last));
    get("memory").append(figure);
  }
}

/* ---- the table */

function cell(title, lines, isNumber) {
  const made = element("td", undefined, isNumber ? "number" : "");
  made.dataset.title = title;
  const [first, ...others] = lines.filter(line => line !== "" && line !== undefined);
  const text = element("div", first);
  text.append(...others.map(line => typeof line === "string" ? element("div", line, "muted") : line));
  made.append(text);
  return made;
}

function stateOf(one) {
  if (one.destroyed === undefined) return "alive";
  return one.destroyed ? `destroyed after submission ${one.destroyed}` : "destroyed";
}

/* Instances with reference 0 are inactive, and other references may lead nowhere. */
function describeReferences(one) {
  if (!one.references) return "";
  const others = one.referring === undefined ? 0 : one.primitives - one.referring;
  return `instances: ${one.references}${others > 0 ? `, ${others.toLocaleString("en")} × no live structure` : ""}`;
}

function countOf(one) {
  const counts = [one.findings && plural(one.findings, "finding"),
    one.advice && plural(one.advice, "piece of advice", "pieces of advice")].filter(Boolean);
  return counts.length ? linkButton(counts.join(", "), () => filterFindings(one.handle)) : "";
}

function structureRow(one) {
  const number = value => value === undefined ? "" : value.toLocaleString("en");
  const row = element("tr");
  const more = one.chain.length > CHAIN_SHOWN ? `, and ${one.chain.length - CHAIN_SHOWN} more` : "";
  const chain = one.chain.length ? `from ${one.chain.slice(0, CHAIN_SHOWN).join(", ")}${more}` : "";
  row.append(cell("structure", [one.name ? `“${one.name}”` : one.handle, one.name ? one.handle : "",
    `${one.type ? `${one.type}, ` : ""}${stateOf(one)}`, countOf(one)]),
  cell("last built by", [one.by, one.flags === undefined ? "" : describeFlags(one.flags),
    describeReferences(one)]),
  cell("builds", [number(one.builds)], true), cell("updates", [number(one.updates), chain], true),
  cell("primitives", [number(one.primitives)], true),
  cell("size", [number(one.size),
    one.compacted_size === undefined ? "" : `compacted:\u00a0${number(one.compacted_size)}`], true),
  cell("scratch", [number(one.build_scratch),
    one.update_scratch === undefined ? "" : `update:\u00a0${number(one.update_scratch)}`], true),
  cell("memory", one.memory ? [one.memory, `+ ${number(one.memory_offset)}`] : []));
  return row;
}

/* Totals count each structure once, however often it was built. */
function showTotals(builds, structures) {
  const sum = (list, member) => list.reduce((total, one) => total + (one[member] || 0), 0);
  const count = (type, filter) => builds.filter(line => line.Type === type && filter(line)).length;
  const measured = structures.filter(one => one.compacted_size !== undefined);
  const alive = structures.filter(one => one.destroyed === undefined).length;
  const lines = [plural(structures.length, "structure"), plural(sum(structures, "size"), "byte"),
    `${alive.toLocaleString("en")} alive at the end`,
    plural(count("Build", line => line.mode !== "update"), "build"),
    plural(count("Build", line => line.mode === "update"), "update"),
    plural(count("Copy", () => true), "copy", "copies"),
    plural(count("Submission", () => true), "submission"),
    plural(sum(builds, "primitives"), "primitive") + " built"];
  if (measured.length)
    lines.push(`compacted sizes of ${plural(measured.length, "structure")}: ` +
      `${sum(measured, "compacted_size").toLocaleString("en")} of ${plural(sum(measured, "size"), "byte")}`);
  get("totals").textContent = lines.join(", ");
}

/* The last structure with the handle: findings are mostly about what is alive. */
function findStructure(structures, handle, process) {
  return structures.findLast(one => one.handle === handle && (process === null || one.process === process));
}

function countFindings(structures) {
  for (const [list, member] of [[data.new, "findings"], [data.advice, "advice"]])
    for (const finding of list)
      for (const one of new Set([...finding.objects, ...finding.otherObjects].map(
        object => findStructure(structures, object.handle, finding.reports[0].process))))
        if (one) one[member]++;
}

function showStructures(builds, structures) {
  let shown = ROWS_AT_ONCE;
  const show = () => {
    const word = get("structure").value.toLowerCase();
    const isHandle = structures.some(one => one.handle === word);
    const matches = one => isHandle ? one.handle === word
      : `${named(one.handle, one.name)} ${one.by} ${one.type} ${stateOf(one)}`.toLowerCase().includes(word);
    const found = structures.filter(matches).sort(ORDERS[get("order").value]);
    get("structures").replaceChildren(...found.slice(0, shown).map(structureRow));
    get("more").hidden = found.length <= shown;
  };
  get("structures-section").hidden = structures.length === 0;
  for (const order of Object.keys(ORDERS)) get("order").append(element("option", order));
  showTotals(builds, structures);
  for (const control of ["structure", "order"])
    get(control).addEventListener("input", () => { shown = ROWS_AT_ONCE; show(); });
  get("more").addEventListener("click", () => { shown += ROWS_AT_ONCE; show(); });
  show();
}

/* A control that leads to the structure, or plain text if the page does not show it. */
function objectLink(object, process, structures) {
  const text = `${object.type} ${object.handle}${object.name ? ` “${object.name}”` : ""}`;
  if (!findStructure(structures, object.handle, process)) return text;
  return linkButton(text, () => {
    get("structure").value = object.handle;
    get("structure").dispatchEvent(new Event("input"));
    get("structure").focus();
  });
}
