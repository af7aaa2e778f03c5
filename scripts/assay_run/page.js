"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const get = id => document.getElementById(id);
const MOST_COLUMNS = 100;
const ROWS_AT_ONCE = 100;

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
  get("run").textContent = [data.command, plural(data.processes, "process", "processes"),
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
  for (const object of finding.objects) list.append(element("li", object));
  if (finding.labels) list.append(element("li", `labels: ${finding.labels.replaceAll("::", " › ")}`));
  if (finding.submission !== undefined && finding.submission !== null)
    list.append(element("li", `submission ${finding.submission} to queue ${finding.queue}`));
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
  const all = [finding.id, finding.message, finding.labels, ...finding.objects, ...finding.place]
    .join("\n").toLowerCase();
  return words.every(word => all.includes(word));
}

function showFindings() {
  const words = get("text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const id = get("id").value;
  const findings = [...data.new, ...(get("known").checked ? data.known : [])]
    .filter(finding => (!id || finding.id === id) && matchesText(finding, words));
  const groups = [...groupById(findings)].sort((a, b) => b[1].length - a[1].length);
  get("groups").replaceChildren(...groups.map(([name, group]) => groupElement(name, group)));
  get("count").textContent = plural(findings.length, "finding");
}

function showFilters() {
  const ids = [...new Set([...data.new, ...data.known].map(finding => finding.id))].sort();
  for (const id of ids) get("id").append(element("option", id));
  get("filters").addEventListener("input", showFindings);
  get("filters").addEventListener("submit", event => event.preventDefault());
}

/* ---- submissions ---- */

function readBuilds() {
  const { members, words, rows } = data.builds;
  return rows.map(row => Object.fromEntries(members.map((member, i) =>
    [member, Array.isArray(row[i]) ? words[row[i][0]] : row[i]])));
}

/* The submissions of each queue in their order, with their builds and findings. Handles may be the same
   in several processes. */
function submissionsByQueue(builds) {
  const queues = new Map();
  const submission = ({ queue, pid, submission: number }) => {
    const title = data.processes > 1 ? `Queue ${queue}, process ${pid}` : `Queue ${queue}`;
    if (!queues.has(title)) queues.set(title, new Map());
    const submissions = queues.get(title);
    if (!submissions.has(number)) submissions.set(number, { number, builds: 0, findings: 0 });
    return submissions.get(number);
  };
  for (const build of builds)
    if (build.queue && build.submission !== null)
      submission(build).builds += build.Type === "Submission" ? 0 : 1;
  for (const finding of data.new)
    if (finding.queue && finding.submission !== null && finding.submission !== undefined)
      submission(finding).findings++;
  return queues;
}

function columnsOf(submissions) {
  const sorted = [...submissions.values()].sort((a, b) => a.number - b.number);
  const each = Math.ceil(sorted.length / MOST_COLUMNS);
  const columns = [];
  for (let i = 0; i < sorted.length; i += each) {
    const part = sorted.slice(i, i + each);
    columns.push({ first: part[0].number, last: part[part.length - 1].number,
      builds: part.reduce((sum, one) => sum + one.builds, 0),
      findings: part.reduce((sum, one) => sum + one.findings, 0) });
  }
  return columns;
}

function describe(column) {
  const which = column.first === column.last ? `Submission ${column.first}`
    : `Submissions ${column.first} to ${column.last}`;
  return `${which}: ${plural(column.builds, "command")}, ${plural(column.findings, "finding")}`;
}

function showTimeline(builds) {
  const queues = submissionsByQueue(builds);
  get("timeline-section").hidden = queues.size === 0;
  for (const [title, submissions] of queues) {
    const columns = columnsOf(submissions);
    const most = Math.max(1, ...columns.map(column => column.builds));
    const bars = element("div", undefined, "columns");
    for (const column of columns) {
      const bar = element("button", undefined, column.findings ? "bad" : "");
      bar.type = "button";
      bar.style.height = `${100 * column.builds / most}%`;
      bar.title = describe(column);
      bar.setAttribute("aria-label", describe(column));
      const select = () => { get("selected").textContent = describe(column); };
      bar.addEventListener("focus", select);
      bar.addEventListener("click", select);
      bars.append(bar);
    }
    const part = element("div", undefined, "queue");
    part.append(element("h3", title), bars);
    get("timeline").append(part);
  }
}

/* ---- structures ---- */

function structuresOf(builds) {
  const structures = new Map();
  for (const build of builds) {
    if (!build.dst) continue;
    const key = `${build.pid} ${build.device} ${build.dst}`;
    if (!structures.has(key))
      structures.set(key, { name: build.dst_name || "", handle: build.dst, by: "", chain: [], updates: 0 });
    const one = structures.get(key);
    if (build.dst_name) one.name = build.dst_name;
    if (build.mode === "update") {
      one.updates++;
      if (build.src && build.src !== build.dst && !one.chain.includes(build.src)) one.chain.push(build.src);
    } else {
      one.by = build.Type === "Copy" ? `copy of ${build.src || "memory"}`
        : build.command_buffer ? `${build.type}, command buffer ${build.command_buffer}, build ${build.build}`
          : `${build.type}, on the host`;
      one.updates = 0;
      one.chain = [];
    }
    for (const member of ["primitives", "size", "compacted_size", "memory"])
      if (build[member] !== null && build[member] !== undefined) one[member] = build[member];
  }
  return [...structures.values()];
}

function cell(title, text, isNumber) {
  const made = element("td", text, isNumber ? "number" : "");
  made.dataset.title = title;
  return made;
}

function structureRow(one) {
  const number = value => value === undefined ? "" : value.toLocaleString("en");
  const row = element("tr");
  row.append(cell("structure", `${one.name ? `“${one.name}” ` : ""}${one.handle}`),
    cell("built by", one.by),
    cell("updates", one.updates + (one.chain.length ? ` from ${one.chain.join(", ")}` : ""), true),
    cell("primitives", number(one.primitives), true), cell("size", number(one.size), true),
    cell("compacted", number(one.compacted_size), true), cell("memory", one.memory || ""));
  return row;
}

function showStructures(builds) {
  const structures = structuresOf(builds);
  let shown = ROWS_AT_ONCE;
  const show = () => {
    const word = get("structure").value.toLowerCase();
    const found = structures.filter(one => `${one.name} ${one.handle}`.toLowerCase().includes(word));
    get("structures").replaceChildren(...found.slice(0, shown).map(structureRow));
    get("more").hidden = found.length <= shown;
  };
  get("structures-section").hidden = structures.length === 0;
  const bytes = structures.reduce((sum, one) => sum + (one.size || 0), 0);
  const count = type => builds.filter(build => build.Type === type).length;
  get("totals").textContent = [plural(structures.length, "structure"), `${bytes.toLocaleString("en")} bytes`,
    plural(builds.filter(build => build.Type === "Build" && build.mode !== "update").length, "build"),
    plural(builds.filter(build => build.mode === "update").length, "update"),
    plural(count("Copy"), "copy", "copies"), plural(count("Submission"), "submission")].join(", ");
  get("structure").addEventListener("input", () => { shown = ROWS_AT_ONCE; show(); });
  get("more").addEventListener("click", () => { shown += ROWS_AT_ONCE; show(); });
  show();
}

function showNotes() {
  const notes = [...data.warnings, ...data.unchecked.map(reason => `Not checked: ${reason}`),
    ...data.unused.map(line => `This line of the baseline matches no finding any more: ${line}`)];
  get("notes-section").hidden = notes.length === 0;
  for (const note of notes) get("notes").append(element("li", note));
}

const builds = readBuilds();
showHead();
showFilters();
showFindings();
showTimeline(builds);
showStructures(builds);
showNotes();
window.addEventListener("beforeprint", () => {
  for (const group of document.querySelectorAll("details")) group.open = true;
});
