"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const get = id => document.getElementById(id);
const MOST_COLUMNS = 100;
const ROWS_AT_ONCE = 100;
const COMMANDS_SHOWN = 20;
const CHAIN_SHOWN = 5;

function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function plural(count, noun, nouns = noun + "s") {
  return `${count.toLocaleString("en")} ${count === 1 ? noun : nouns}`;
}

/* ---- head ---- */

function showHead() {
  const bad = data.new.length > 0 || data.mistakes.length > 0;
  get("version").textContent = data.version;
  const count = data.new.length === 0 ? "No findings" : plural(data.new.length, "finding");
  get("verdict").textContent = [count, ...data.mistakes].join("; ") + ".";
  get("verdict").className = bad ? "bad" : "good";
  const settings = Object.entries(data.settings).map(([key, value]) => `${key} = ${value}`);
  const isShown = line => line.startsWith("level =") || line.startsWith("backend =");
  get("run").textContent = [data.command, plural(data.processes.length, "process", "processes"),
    ...data.drivers, ...settings.filter(isShown)].filter(Boolean).join(" · ");
  get("settings").hidden = settings.length === 0;
  get("settings").append(...settings.map(line => element("div", line)));
}

/* ---- findings ---- */

function groupById(findings) {
  const groups = new Map();
  for (const finding of findings) {
    if (!groups.has(finding.id)) groups.set(finding.id, []);
    groups.get(finding.id).push(finding);
  }
  return groups;
}

function findingElement(finding) {
  const article = element("article", undefined, "finding");
  article.append(element("p", finding.message));
  const list = element("ul");
  for (const id of finding.also) list.append(element("li", `also violates ${id}`));
  for (const object of finding.objects) list.append(element("li", object));
  if (finding.labels) list.append(element("li", `labels: ${finding.labels.replaceAll("::", " › ")}`));
  const [report] = finding.reports;
  if (report.submission !== null) {
    const how = report.isRecorded ? "recorded in a command buffer of " : "";
    list.append(element("li", `${how}submission ${report.submission} to queue ${report.queue}`));
  }
  for (const line of finding.repetition) list.append(element("li", line));
  for (const frame of finding.place) list.append(element("li", frame));
  if (list.childElementCount) article.append(list);
  return article;
}

function groupElement(id, findings) {
  const group = element("details", undefined, "group");
  group.open = true;
  const heldBack = data.heldBack[id] ? `, ${data.heldBack[id]} more not reported` : "";
  group.append(element("summary", `${id} (${findings.length}${heldBack})`));
  const { spec, url } = findings[0];
  if (spec || url) {
    const quote = element("p", spec, "specification");
    if (url && url.startsWith("https://")) {
      const link = element("a", "specification");
      link.href = url;
      quote.append(" ", link);
    }
    group.append(quote);
  }
  for (const finding of findings) group.append(findingElement(finding));
  return group;
}

function matchesText(finding, words) {
  const all = [finding.id, ...finding.also, finding.message, finding.labels, ...finding.objects,
    ...finding.place].join("\n").toLowerCase();
  return words.every(word => all.includes(word));
}

function showFindings() {
  const words = get("text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const id = get("id").value;
  const findings = [...data.new, ...(get("known").checked ? data.known : [])]
    .filter(finding => !id || finding.id === id || finding.also.includes(id))
    .filter(finding => matchesText(finding, words));
  const groups = [...groupById(findings)].sort((a, b) => b[1].length - a[1].length);
  get("groups").replaceChildren(...groups.map(([name, group]) => groupElement(name, group)));
  get("count").textContent = plural(findings.length, "finding");
}

function showFilters() {
  const ids = [...new Set([...data.new, ...data.known]
    .flatMap(finding => [finding.id, ...finding.also]))].sort();
  for (const id of ids) get("id").append(element("option", id));
  get("filters").addEventListener("input", showFindings);
  get("filters").addEventListener("submit", event => event.preventDefault());
}

/* ---- what executed ---- */

function readBuilds() {
  const { words, wordMembers, numberMembers, rows } = data.builds;
  return rows.map(row => {
    const line = {};
    wordMembers.forEach((member, i) => { if (row[i] >= 0) line[member] = words[row[i]]; });
    numberMembers.forEach((member, i) => {
      const number = row[wordMembers.length + i];
      if (number >= 0) line[member] = number;
    });
    return line;
  });
}

function named(handle, name) {
  return name ? `“${name}” ${handle}` : handle;
}

const COPIES = { clone: "clone", compact: "compacted copy", deserialize: "deserialization" };

/* What a build or copy did, such as: update of “rock” 0x12 from “rock 2” 0x13, 12 primitives. */
function describeCommand(line, names) {
  const source = line.src && line.src !== line.dst ? ` from ${named(line.src, names.get(line.src))}` : "";
  const primitives = line.primitives === undefined ? "" : `, ${plural(line.primitives, "primitive")}`;
  const buffer = line.command_buffer
    ? `, command buffer ${named(line.command_buffer, line.command_buffer_name)}` : "";
  const position = line.build === undefined ? "" : `, build ${line.build}`;
  const what = COPIES[line.mode] ? `${COPIES[line.mode]} in` : `${line.mode} of`;
  return `${what} ${named(line.dst, line.dst_name)}${source}${primitives}${buffer}${position}`;
}

function namesOf(builds) {
  return new Map(builds.filter(line => line.dst_name).map(line => [line.dst, line.dst_name]));
}

/* ---- submissions ---- */

/* The submissions of each queue in their order, with their builds and findings; each command of the host
   counts as one. Handles may be the same in several processes. */
function submissionsByQueue(builds) {
  const queues = new Map();
  const submission = ({ queue, process, submission: number }) => {
    const of = data.processes.length > 1 ? `, process ${data.processes[process]}` : "";
    const title = (queue ? `Queue ${queue}` : "Host") + of;
    if (!queues.has(title)) queues.set(title, new Map());
    const submissions = queues.get(title);
    if (number === undefined) number = submissions.size + 1;
    if (!submissions.has(number)) submissions.set(number, { number, builds: [], findings: 0 });
    return submissions.get(number);
  };
  for (const line of builds)
    if (line.Type === "Submission") submission(line);
    else if (line.Type !== "CompactedSize") submission(line).builds.push(line);
  for (const report of data.new.flatMap(finding => finding.reports))
    if (report.queue && report.submission !== null) submission(report).findings++;
  return queues;
}

function columnsOf(submissions) {
  const sorted = [...submissions.values()].sort((a, b) => a.number - b.number);
  const each = Math.ceil(sorted.length / MOST_COLUMNS);
  const columns = [];
  for (let i = 0; i < sorted.length; i += each) {
    const part = sorted.slice(i, i + each);
    columns.push({ first: part[0].number, last: part[part.length - 1].number,
      builds: part.flatMap(one => one.builds),
      findings: part.reduce((sum, one) => sum + one.findings, 0) });
  }
  return columns;
}

function describe(column, title) {
  const noun = title.startsWith("Host") ? "Command" : "Submission";
  const which = column.first === column.last ? `${noun} ${column.first}`
    : `${noun}s ${column.first} to ${column.last}`;
  return `${which}: ${plural(column.builds.length, "build or copy", "builds and copies")}, ` +
    plural(column.findings, "finding");
}

function barElement(column, title, most, names) {
  const bar = element("button", undefined, column.findings ? "bad" : "");
  bar.type = "button";
  bar.style.height = `${100 * column.builds.length / most}%`;
  bar.title = describe(column, title);
  bar.setAttribute("aria-label", bar.title);
  const select = () => {
    get("selected").textContent = `${title}. ${bar.title}.`;
    const shown = column.builds.slice(0, COMMANDS_SHOWN)
      .map(line => element("li", describeCommand(line, names)));
    const rest = column.builds.length - shown.length;
    if (rest > 0) shown.push(element("li", `and ${rest.toLocaleString("en")} more`));
    get("commands").replaceChildren(...shown);
  };
  bar.addEventListener("focus", select);
  bar.addEventListener("click", select);
  return bar;
}

function showTimeline(builds, names) {
  const queues = submissionsByQueue(builds);
  get("timeline-section").hidden = queues.size === 0;
  for (const [title, submissions] of queues) {
    const columns = columnsOf(submissions);
    const most = Math.max(1, ...columns.map(column => column.builds.length));
    const bars = element("div", undefined, "columns");
    bars.append(...columns.map(column => barElement(column, title, most, names)));
    const part = element("div", undefined, "queue");
    part.append(element("h3", title), bars);
    get("timeline").append(part);
  }
}

/* ---- structures ---- */

/* A handle may be used again: a structure never changes its size, nor its memory. */
function isSame(one, line) {
  return ["size", "memory", "memory_offset"].every(
    member => one[member] === undefined || line[member] === undefined || one[member] === line[member]);
}

function describeOrigin(line, names) {
  if (line.Type === "Copy")
    return line.src ? `${COPIES[line.mode]} of ${named(line.src, names.get(line.src))}` : COPIES[line.mode];
  const where = line.command_buffer
    ? `command buffer ${named(line.command_buffer, line.command_buffer_name)}` : "the host";
  const position = line.build === undefined ? "" : `, build ${line.build}`;
  const submission = line.submission === undefined ? "" : `, submission ${line.submission}`;
  return `${line.type}, ${where}${position}${submission}`;
}

function structuresOf(builds, names) {
  const structures = [], current = new Map();
  for (const line of builds) {
    if (!line.dst) continue;
    const key = `${line.process} ${line.device} ${line.dst}`;
    let one = current.get(key);
    if (!one || !isSame(one, line)) {
      one = { handle: line.dst, name: "", by: "", chain: [], updates: 0 };
      current.set(key, one);
      structures.push(one);
    }
    if (line.dst_name) one.name = line.dst_name;
    if (line.mode === "update") {
      one.updates++;
      const source = line.src && line.src !== line.dst ? named(line.src, names.get(line.src)) : "";
      if (source && !one.chain.includes(source)) one.chain.push(source);
    } else if (line.mode) {
      Object.assign(one, { by: describeOrigin(line, names), updates: 0, chain: [],
        compacted_size: undefined });
    }
    for (const member of ["primitives", "size", "compacted_size", "memory", "memory_offset"])
      if (line[member] !== undefined) one[member] = line[member];
  }
  return structures;
}

function cell(title, text, isNumber) {
  const made = element("td", text, isNumber ? "number" : "");
  made.dataset.title = title;
  return made;
}

function structureRow(one) {
  const number = value => value === undefined ? "" : value.toLocaleString("en");
  const row = element("tr");
  const more = one.chain.length > CHAIN_SHOWN ? `, and ${one.chain.length - CHAIN_SHOWN} more` : "";
  const chain = one.chain.length ? ` from ${one.chain.slice(0, CHAIN_SHOWN).join(", ")}${more}` : "";
  row.append(cell("structure", named(one.handle, one.name)), cell("built by", one.by),
    cell("updates", one.updates + chain, true),
    cell("primitives", number(one.primitives), true), cell("size", number(one.size), true),
    cell("compacted", number(one.compacted_size), true),
    cell("memory", one.memory ? `${one.memory} + ${number(one.memory_offset)}` : ""));
  return row;
}

/* Totals count each structure once, however often it was built. */
function showTotals(builds, structures) {
  const sum = (list, member) => list.reduce((total, one) => total + (one[member] || 0), 0);
  const count = (type, filter) => builds.filter(line => line.Type === type && filter(line)).length;
  const measured = structures.filter(one => one.compacted_size !== undefined);
  const lines = [plural(structures.length, "structure"), plural(sum(structures, "size"), "byte"),
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

function showStructures(builds, names) {
  const structures = structuresOf(builds, names);
  let shown = ROWS_AT_ONCE;
  const show = () => {
    const word = get("structure").value.toLowerCase();
    const matches = one => `${named(one.handle, one.name)} ${one.by}`.toLowerCase().includes(word);
    const found = structures.filter(matches);
    get("structures").replaceChildren(...found.slice(0, shown).map(structureRow));
    get("more").hidden = found.length <= shown;
  };
  get("structures-section").hidden = structures.length === 0;
  showTotals(builds, structures);
  get("structure").addEventListener("input", () => { shown = ROWS_AT_ONCE; show(); });
  get("more").addEventListener("click", () => { shown += ROWS_AT_ONCE; show(); });
  show();
}

function recordNotes() {
  const { rows, leftOut } = data.builds;
  if (data.version && rows.length === 0)
    return ["The record has no builds. With assay-run --set record_builds=true this page also shows " +
      "submissions, builds and acceleration structures."];
  return leftOut ? [`${leftOut.toLocaleString("en")} later lines of builds are left out.`] : [];
}

function showNotes() {
  const notes = [...data.warnings, ...data.unchecked.map(reason => `Not checked: ${reason}`),
    ...recordNotes(),
    ...data.unused.map(line => `This line of the baseline matches no finding any more: ${line}`)];
  get("notes-section").hidden = notes.length === 0;
  for (const note of notes) get("notes").append(element("li", note));
}

const builds = readBuilds();
const names = namesOf(builds);
showHead();
showFilters();
showFindings();
showTimeline(builds, names);
showStructures(builds, names);
showNotes();
window.addEventListener("beforeprint", () => {
  for (const group of document.querySelectorAll("details")) group.open = true;
});
