/* What executed: the lines of record_builds, submissions, and which of them a finding belongs to. */
"use strict";
const MOST_COLUMNS = 100;
const COMMANDS_SHOWN = 20;
const COMMANDS = ["Build", "Copy"];
const COPIES = { clone: "clone", compact: "compacted copy", deserialize: "deserialization" };
const columnsBySubmission = new Map();

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

function seconds(milliseconds) {
  return milliseconds === undefined ? "" : `${(milliseconds / 1000).toFixed(3)} s`;
}

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

/* The submissions of each queue in their order, with their builds and findings; each command of the host
   counts as one. Handles may be the same in several processes. */
function submissionsByQueue(builds) {
  const queues = new Map();
  const submission = line => {
    const { queue, process, ms } = line;
    let number = line.submission;
    const of = data.processes.length > 1 ? `, process ${data.processes[process]}` : "";
    const title = (queue ? `Queue ${queue}` : "Host") + of;
    if (!queues.has(title)) queues.set(title, new Map());
    const submissions = queues.get(title);
    if (number === undefined) number = submissions.size + 1;
    if (!submissions.has(number))
      submissions.set(number, { number, ms, key: `${process} ${queue} ${number}`, builds: [], findings: 0,
        place: { ...line, submission: number } });
    return submissions.get(number);
  };
  for (const line of builds)
    if (line.Type === "Submission") submission(line);
    else if (COMMANDS.includes(line.Type)) submission(line).builds.push(line);
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
    columns.push({ first: part[0].place, last: part[part.length - 1].place, ms: part[0].ms,
      keys: part.map(one => one.key), builds: part.flatMap(one => one.builds),
      findings: part.reduce((sum, one) => sum + one.findings, 0) });
  }
  return columns;
}

/* Where submissions are: their numbers, frames and so on, such as: submissions 3 to 5, frame 2. Commands of
   the host count as submissions. */
function describePlace(first, last, title) {
  return data.axis.filter(key => (last[key] ?? null) !== null).map(key => {
    const noun = key === "submission" && title?.startsWith("Host") ? "command" : key;
    const from = first[key] ?? last[key];
    return from === last[key] ? `${noun} ${from}` : `${noun}s ${from} to ${last[key]}`;
  }).join(", ");
}

function axisElement(first, last, title) {
  const axis = element("div", undefined, "axis");
  for (const end of [first, last])
    axis.append(element("span", describePlace(end, end, title) +
      ((end.ms ?? null) === null ? "" : ` (${seconds(end.ms)})`)));
  return axis;
}

function describeColumn(column, title) {
  const place = describePlace(column.first, column.last, title);
  const which = place[0].toUpperCase() + place.slice(1);
  const when = column.ms === undefined ? "" : `, ${seconds(column.ms)} after the start`;
  return `${which}: ${plural(column.builds.length, "build or copy", "builds and copies")}, ` +
    plural(column.findings, "finding") + when;
}

function barElement(column, title, most, names) {
  const bar = element("button", undefined, column.findings ? "bad" : "");
  bar.type = "button";
  bar.style.height = `${100 * column.builds.length / most}%`;
  bar.title = describeColumn(column, title);
  bar.setAttribute("aria-label", bar.title);
  const select = () => {
    for (const other of document.querySelectorAll(".columns .chosen")) other.classList.remove("chosen");
    bar.classList.add("chosen");
    get("selected").textContent = `${title}. ${bar.title}.`;
    const shown = column.builds.slice(0, COMMANDS_SHOWN)
      .map(line => element("li", describeCommand(line, names)));
    const rest = column.builds.length - shown.length;
    if (rest > 0) shown.push(element("li", `and ${rest.toLocaleString("en")} more`));
    get("commands").replaceChildren(...shown);
  };
  bar.addEventListener("focus", select);
  bar.addEventListener("click", select);
  for (const key of column.keys) columnsBySubmission.set(key, bar);
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
    part.append(element("h3", title), element("p", `at most ${plural(most, "build or copy",
      "builds and copies")} in a column`, "muted"), bars,
      axisElement(columns[0].first, columns[columns.length - 1].last, title));
    get("timeline").append(part);
  }
}

/* A control that leads to a submission, or plain text if the page does not show it. */
function submissionLink(report) {
  const text = `submission ${report.submission} to queue ${report.queue}`;
  const bar = columnsBySubmission.get(`${report.process} ${report.queue} ${report.submission}`);
  return bar ? linkButton(text, () => bar.focus()) : text;
}
