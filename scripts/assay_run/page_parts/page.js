/* The head of the page, findings, advice and notes. */
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const get = id => document.getElementById(id);

function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function plural(count, noun, nouns = noun + "s") {
  return `${count.toLocaleString("en")} ${count === 1 ? noun : nouns}`;
}

/* A button that looks like a link: it leads to another part of the page. */
function linkButton(text, act) {
  const made = element("button", text, "link");
  made.type = "button";
  made.addEventListener("click", act);
  return made;
}

function itemElement(...parts) {
  const made = element("li");
  made.append(...parts);
  return made;
}

/* ---- head ---- */

function showHead() {
  const bad = data.new.length > 0 || data.mistakes.length > 0;
  get("version").textContent = data.version;
  const count = data.new.length === 0 ? "No findings" : plural(data.new.length, "finding");
  const advice = data.advice.length === 0 ? []
    : [plural(data.advice.length, "piece of advice", "pieces of advice")];
  get("verdict").textContent = [count, ...data.mistakes, ...advice].join("; ") + ".";
  get("verdict").className = bad ? "bad" : "good";
  const settings = Object.entries(data.settings).map(([key, value]) => `${key} = ${value}`);
  const isShown = line => line.startsWith("level =") || line.startsWith("backend =");
  get("run").textContent = [data.command, plural(data.processes.length, "process", "processes"),
    ...data.drivers, ...settings.filter(isShown)].filter(Boolean).join(" · ");
  get("settings").hidden = settings.length === 0;
  get("settings").append(...settings.map(line => element("div", line)));
}

/* Links to the sections that have something to show. */
function showSections() {
  for (const title of document.querySelectorAll("section:not([hidden]) h2")) {
    const link = element("a", title.textContent);
    link.href = `#${title.id}`;
    get("sections").append(link);
  }
}

/* ---- findings ---- */

const GROUPS = {
  id: finding => [finding.id],
  structure: finding => {
    const found = [...finding.objects, ...finding.otherObjects]
      .filter(object => object.type.startsWith("VkAccelerationStructure"));
    return found.length ? found.map(object => named(object.handle, object.name)) : ["no structure"];
  },
  submission: finding => [finding.reports[0].submission === null ? "no submission"
    : `submission ${finding.reports[0].submission} to queue ${finding.reports[0].queue}`],
};

function groupBy(findings, keysOf) {
  const groups = new Map();
  for (const finding of findings)
    for (const key of new Set(keysOf(finding))) {
      if (!groups.has(key)) groups.set(key, []);
      groups.get(key).push(finding);
    }
  return groups;
}

function placeItems(finding, structures) {
  const [report] = finding.reports;
  const links = finding.objects.map(object => objectLink(object, report.process, structures));
  const isNew = (link, i) => typeof link !== "string" || !finding.message.includes(finding.objects[i].handle);
  const items = links.filter(isNew).map(link => itemElement(link));
  if (finding.labels) items.push(element("li", `labels: ${finding.labels.replaceAll("::", " › ")}`));
  const others = data.axis.filter(key => key !== "submission" && report[key] !== null)
    .map(key => `${key} ${report[key]}`).join(", ");
  if (report.submission !== null)
    items.push(itemElement(report.isRecorded ? "recorded in a command buffer of " : "",
      submissionLink(report), others ? `, ${others}` : "",
      report.ms === null ? "" : `, ${seconds(report.ms)} after the start`));
  else if (others)
    items.push(itemElement(others));
  return items;
}

function findingElement(finding, structures, hasId) {
  const article = element("article", undefined, "finding");
  if (hasId) article.append(element("h3", finding.id));
  article.append(element("p", (finding.layers ? `${finding.layers}: ` : "") + finding.message));
  const list = element("ul");
  for (const id of finding.also) list.append(element("li", `also violates ${id}`));
  list.append(...placeItems(finding, structures));
  for (const line of finding.repetition) list.append(element("li", line));
  for (const frame of finding.place) list.append(element("li", frame));
  const link = data.scene && sceneLink(finding);
  if (link) list.append(itemElement(link));
  if (list.childElementCount) article.append(list);
  finding.article = article;
  return article;
}

function specificationElement({ spec, url }) {
  const quote = element("p", spec, "specification");
  if (url && url.startsWith("https://")) {
    const link = element("a", "specification");
    link.href = url;
    quote.append(" ", link);
  }
  return quote;
}

function groupElement(title, findings, structures, isById) {
  const group = element("details", undefined, "group");
  group.open = true;
  const heldBack = isById && data.heldBack[title] ? `, ${data.heldBack[title]} more not reported` : "";
  group.append(element("summary", `${title} (${findings.length}${heldBack})`));
  if (isById && (findings[0].spec || findings[0].url)) group.append(specificationElement(findings[0]));
  for (const finding of findings) group.append(findingElement(finding, structures, !isById));
  return group;
}

function matchesText(finding, words) {
  const objects = [...finding.objects, ...finding.otherObjects]
    .flatMap(({ type, handle, name }) => [type, handle, name]);
  const all = [finding.id, ...finding.also, finding.message, finding.labels, finding.layers, ...objects,
    ...finding.place].join("\n").toLowerCase();
  return words.every(word => all.includes(word));
}

function showFindings(structures) {
  const words = get("text").value.toLowerCase().split(/\s+/).filter(Boolean);
  const id = get("id").value;
  const findings = [...data.new, ...(get("known").checked ? data.known : [])]
    .filter(finding => !id || finding.id === id || finding.also.includes(id))
    .filter(finding => matchesText(finding, words));
  const kind = get("group").value;
  get("fold").textContent = "Fold all";
  const groups = [...groupBy(findings, GROUPS[kind])].sort((a, b) => b[1].length - a[1].length);
  get("groups").replaceChildren(...groups.map(
    ([title, group]) => groupElement(title, group, structures, kind === "id")));
  get("count").textContent = plural(findings.length, "finding");
  showAdvice(words, structures);
}

/* The worst first, as the layer lists it. */
function showAdvice(words, structures) {
  const groups = groupBy(data.advice.filter(finding => matchesText(finding, words)), GROUPS.id);
  get("advice-section").hidden = data.advice.length === 0;
  get("advice").replaceChildren(...[...groups].map(
    ([title, group]) => groupElement(title, group, structures, true)));
}

/* Shows what is about a structure. */
function filterFindings(word) {
  get("text").value = word;
  get("id").value = "";
  get("text").dispatchEvent(new Event("input", { bubbles: true }));
  get("text").focus();
}

function showFilters(structures) {
  for (const kind of Object.keys(GROUPS)) get("group").append(element("option", kind));
  const ids = [...new Set([...data.new, ...data.known]
    .flatMap(finding => [finding.id, ...finding.also]))].sort();
  for (const id of ids) get("id").append(element("option", id));
  get("filters").addEventListener("input", () => showFindings(structures));
  get("fold").addEventListener("click", () => {
    const groups = [...document.querySelectorAll("#groups .group, #advice .group")];
    const isOpen = groups.some(group => group.open);
    for (const group of groups) group.open = !isOpen;
    get("fold").textContent = isOpen ? "Unfold all" : "Fold all";
  });
  get("filters").addEventListener("submit", event => event.preventDefault());
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
const { structures, curves } = structuresOf(builds, names);
countFindings(structures);
showHead();
showTimeline(builds, names);
if (data.scene) showScene(structures);
showFilters(structures);
showFindings(structures);
showMemory(curves);
showStructures(builds, structures);
showNotes();
showSections();
window.addEventListener("beforeprint", () => {
  for (const group of document.querySelectorAll("details")) group.open = true;
});
