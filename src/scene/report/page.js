'use strict';
const data = JSON.parse(document.getElementById('data').textContent);
const at = id => document.getElementById(id);
const ACCURACIES = ['fast', 'robust', 'exact'];

function make(tag, attributes, ...children) {
  const isSvg = ['svg', 'g', 'line', 'path', 'circle', 'text', 'title', 'polyline', 'rect'].includes(tag);
  const element = isSvg ? document.createElementNS('http://www.w3.org/2000/svg', tag) : document.createElement(tag);
  for (const [key, value] of Object.entries(attributes || {}))
    if (value !== undefined && value !== false) element.setAttribute(key, value);
  element.append(...children.filter(child => child !== undefined && child !== null));
  return element;
}

function number(value, digits = 3) {
  if (value === undefined || value === null) return '';
  if (typeof value !== 'number') return String(value);
  if (Number.isInteger(value) && Math.abs(value) < 1e15) return value.toLocaleString('en');
  const size = Math.abs(value);
  if (size >= 1e7 || size < 1e-3) return value.toExponential(2);
  return size >= 1000 ? Math.round(value).toLocaleString('en') : String(Number(value.toPrecision(digits)));
}

/* Rows are arrays of cells: text, numbers, or elements. */
function table(heads, rows, title) {
  const isNumber = heads.map((_, column) => rows.every(row => row[column] === '' || row[column] === undefined ||
    typeof row[column] === 'number'));
  const cells = rows.map(row => make('tr', row.isGroup ? {class: 'group'} : {}, ...row.map((cell, column) =>
    make('td', {class: isNumber[column] && 'number', 'data-title': heads[column]},
      make('div', {}, cell instanceof Node ? cell : number(cell))))));
  return make('table', {'aria-label': title},
    make('thead', {}, make('tr', {}, ...heads.map((head, column) =>
      make('th', {scope: 'col', class: isNumber[column] && 'number'}, head)))),
    make('tbody', {}, ...cells));
}

function nothing(text) { return make('p', {class: 'muted'}, text); }

/* ---- accuracy */

const sets = data.accuracy.sets.map(set => set.rays);
const rowOf = (quality, accuracy, set) => data.accuracy.rows.find(row =>
  row.quality === quality && row.accuracy === accuracy && row.set === set);

/* Error against time: a chart for each set, with one mark for each accuracy. All have the same axes. */
function charts(quality) {
  const width = 300, height = 190, left = 70, right = 10, top = 26, bottom = 34;
  const rows = data.accuracy.rows.filter(row => row.quality === quality);
  const times = rows.map(row => row['ns a ray']);
  const least = Math.log10(Math.min(...times)) - 0.1, most = Math.log10(Math.max(...times)) + 0.1;
  const x = time => left + (Math.log10(time) - least) / (most - least) * (width - left - right);
  const floor = height - bottom, step = (floor - top - 16) / 6;
  const y = wrong => wrong < 1 ? floor : floor - 16 - Math.log10(wrong) * step;
  return sets.map(set => {
    const svg = make('svg', {viewBox: `0 0 ${width} ${height}`, role: 'img',
      'aria-label': `Wrong answers in a million rays against nanoseconds a ray, ${set}, quality ${quality}`});
    svg.append(make('text', {x: left, y: 16, class: 'title'}, set));
    for (const [wrong, name] of [[0, 'none'], [1, '1'], [1e3, '1,000'], [1e6, '1,000,000']])
      svg.append(make('line', {x1: left, x2: width - right, y1: y(wrong), y2: y(wrong), class: 'grid'}),
        make('text', {x: left - 6, y: y(wrong) + 4, 'text-anchor': 'end'}, name));
    let last = -Infinity;
    for (const time of [0, 1, 2, 3, 4, 5, 6, 7].flatMap(power => [1, 3].map(digit => digit * 10 ** power)))
      if (Math.log10(time) > least && Math.log10(time) < most && x(time) - last > 34) {
        last = x(time);
        svg.append(make('line', {x1: last, x2: last, y1: top, y2: floor, class: 'grid'}),
          make('text', {x: last, y: floor + 15, 'text-anchor': 'middle'}, `${time.toLocaleString('en')}`));
      }
    svg.append(make('text', {x: width - right, y: height - 4, 'text-anchor': 'end', class: 'muted'}, 'ns a ray'));
    const points = ACCURACIES.map(accuracy => rowOf(quality, accuracy, set)).map(row =>
      ({row, x: x(row['ns a ray']), y: y(row.wrong)}));
    svg.append(make('polyline', {points: points.map(point => `${point.x},${point.y}`).join(' '), class: 'link'}));
    for (const point of points)
      svg.append(make('circle', {cx: point.x, cy: point.y, r: 5, class: point.row.accuracy},
        make('title', {}, `${set}, ${point.row.accuracy}: ${number(point.row['ns a ray'])} ns, ${number(point.row.wrong)} wrong`)));
    return svg;
  });
}

function showAccuracy() {
  const quality = at('quality').value;
  at('charts').replaceChildren(...charts(quality));
  at('key').replaceChildren('Wrong answers in a million rays against time:',
    ...ACCURACIES.flatMap(accuracy => [make('i', {class: accuracy}), accuracy]));
  const heads = ['rays', 'accuracy', 'ns a ray', 'wrong', 'missed', 'double', 'nearest'];
  const rows = sets.flatMap(set => ACCURACIES.map((accuracy, index) => {
    const row = rowOf(quality, accuracy, set);
    const cells = [index ? '' : set, accuracy, Math.round(row['ns a ray']), row.wrong, row.missed, row.double, row.nearest];
    cells.isGroup = !index;
    return cells;
  }));
  for (const row of data.device?.rays || []) {
    const place = rows.findLastIndex((_, index) => sets[Math.floor(index / 3)] === row.set);
    const cells = ['', 'device', row['ns a ray'] === undefined ? '' : Math.round(row['ns a ray']), row.wrong, row.missed,
      row.double, row.nearest];
    rows.inserts = [...rows.inserts || [], [place + 1, cells]];
  }
  for (const [place, cells] of (rows.inserts || []).reverse()) rows.splice(place, 0, cells);
  at('rows').replaceChildren(table(heads, rows, 'Accuracies by set of rays'));
}

at('quality').append(...data.accuracy.qualities.map(({quality}) => make('option', {selected: quality === 'balanced'}, quality)));
at('quality').addEventListener('change', showAccuracy);
showAccuracy();
at('qualities').append(table(['quality', 'ms to build', 'million primitives a second', 'SAH cost', 'bytes a primitive', 'depth'],
  data.accuracy.qualities.map(row => [row.quality, row['ms build'], row.primitives / row['ms build'] / 1e3, row.sah,
    row.bytes / Math.max(row.primitives, 1), row.depth]), 'Qualities'));
at('sets').append(table(['set', 'rays', 'what they are'], data.accuracy.sets.map(set => [set.rays, set.count, set.says]),
  'Sets of rays'));

/* ---- what it is about */

const summary = data.summary;
at('about').textContent = [summary.application || summary.executable?.split('/').pop(), data.devices.map(each => each.device).join(', '),
  summary.time && summary.time.slice(0, 10)].filter(Boolean).join(' · ');
const missing = Object.entries(data.subject['left out']).map(([why, count]) => `${number(count)} ${why}`);
at('subject').append(`Top-level structure ${data.subject['top level']}, at ${data.subject.at}: ` +
  `${number(data.subject.instances)} instances of ${number(data.subject.structures)} structures with ` +
  `${number(data.accuracy.qualities[0].primitives)} primitives.` +
  (missing.length ? ` Left out: ${missing.join(', ')}.` : ''));

/* ---- pictures */

function plane(name, isWide) {
  const text = atob(data.planes[name]), bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  return isWide ? new Uint16Array(bytes.buffer) : bytes;
}

/* An approximation of the color map Turbo (Mikhailov 2019). */
function heat(value) {
  const stops = [[48, 18, 59], [70, 98, 215], [53, 171, 248], [27, 228, 182], [114, 254, 94], [200, 239, 52],
    [250, 186, 57], [246, 107, 25], [202, 42, 4], [122, 4, 3]];
  const place = Math.min(value, 1) * (stops.length - 1), low = Math.min(Math.floor(place), stops.length - 2);
  return stops[low].map((from, i) => from + (stops[low + 1][i] - from) * (place - low));
}

function hue(index) {
  const turn = index * 0.618034 % 1 * 6;
  return [5, 3, 1].map(offset => {
    const part = (offset + turn) % 6;
    return 1 - 0.35 * Math.max(0, Math.min(part, 4 - part, 1));
  });
}

function showPictures() {
  const {width, height} = data.pictures, shade = plane('shade'), mesh = plane('mesh'), wrong = plane('wrong');
  const counts = {nodes: plane('nodes', true), primitives: plane('primitives', true)};
  const most = counts => counts.slice().sort()[Math.floor(counts.length * 0.999)] || 1;
  const add = (name, caption, color, says) => {
    const canvas = make('canvas', {width, height, role: 'img', 'aria-label': name});
    const image = new ImageData(width, height);
    for (let i = 0; i < width * height; i++) {
      const at = color(i);
      for (let part = 0; part < 3; part++) image.data[4 * i + part] = at[part];
      image.data[4 * i + 3] = 255;
    }
    canvas.getContext('2d').putImageData(image, 0, 0);
    const pixel = make('span', {}), figure = make('figure', {}, canvas,
      make('figcaption', {}, make('b', {}, name), ' ', caption, ' ', pixel));
    canvas.addEventListener('pointermove', event => {
      const box = canvas.getBoundingClientRect();
      const x = Math.min(width - 1, Math.floor((event.clientX - box.left) / box.width * width));
      const y = Math.min(height - 1, Math.floor((event.clientY - box.top) / box.height * height));
      pixel.textContent = `Pixel ${x}, ${y}: ${says(y * width + x)}.`;
    });
    canvas.addEventListener('pointerleave', () => { pixel.textContent = ''; });
    at('canvases').append(figure);
  };
  const hues = Array.from({length: 256}, (_, i) => hue(i));
  const shaded = i => shade[i] ? hues[mesh[i]].map(part => part * shade[i]) : [22, 25, 29];
  add('Shaded', 'A color for each structure.', shaded, i => shade[i] ? `structure ${mesh[i]} of this report` : 'nothing');
  for (const [kind, name] of [['nodes', 'Node visits'], ['primitives', 'Primitive tests']]) {
    const limit = most(counts[kind]), colors = Array.from({length: 257}, (_, i) => heat(i / 256)), scale = make('span', {}, '0 ', make('span', {class: 'scale'}), ` ${number(limit)}`);
    add(name, scale, i => colors[Math.min(256, Math.round(counts[kind][i] / limit * 256))], i => `${number(counts[kind][i])} ${kind}`);
    at('canvases').lastChild.querySelector('figcaption').append(make('span', {},
      ` On average ${number(data.pictures[`${kind} a pixel`])}, at most ${number(data.pictures[`most ${kind}`])}.`));
  }
  const red = new Uint8Array(width * height);
  for (let i = 0; i < red.length; i++)
    for (const flag of [1, 2])
      if (wrong[i] & flag)
        for (const near of [i, i - 1, i + 1, i - width, i + width]) red[near] |= flag;
  add('Where accuracies differ', make('span', {}, `Red: fast differs from exact (${number(data.pictures['pixels wrong at fast'])} ` +
    `pixels). Yellow: robust does, too (${number(data.pictures['pixels wrong at robust'])}). Marks are larger than pixels.`),
  i => red[i] & 2 ? [255, 210, 60] : red[i] & 1 ? [255, 70, 70] : shaded(i).map(part => part * 0.35),
  i => wrong[i] & 2 ? 'robust and exact differ' : wrong[i] & 1 ? 'fast and exact differ' : 'no difference');
}
if (data.planes) showPictures();
else at('canvases').append(nothing('No pictures were made.'));

/* ---- fragile inputs */

const usual = ['boxes', 'shared edges', 'open edges'];
const harmless = row => usual.includes(row.kind) && !row.robust?.wrong;
const fragile = data.fragile.rows.filter(row => !harmless(row)).sort((a, b) => (b.robust?.wrong || 0) - (a.robust?.wrong || 0));
at('inputs').append(fragile.length ? table(
  ['kind', 'structure', 'geometry', 'how many', 'such as', 'figure', 'wrong at robust', 'what it means'],
  fragile.map(row => [row.kind, row.name ?? '', row.geometry ?? '', row.count,
    (row.primitives || row.instances).slice(0, 4).join(', '),
    row.figure === undefined ? '' : `${number(row.figure)} (${row['figure of']})`, row.robust ? row.robust.wrong : '', row.says]),
  'Fragile inputs') : nothing('Nothing was found.'));
const kinds = usual.filter(kind => data.fragile.rows.some(row => row.kind === kind && harmless(row)));
at('more-inputs').textContent = (kinds.length ? `Not listed, because no ray was wrong: ${kinds.join(', ')}. ` : '') + data.fragile.more.map(({kind, rows, count}) =>
  `${kind}: ${number(rows)} more rows with ${number(count)} primitives.`).join(' ');

/* ---- effects */

function costOf({cost}) {
  if (!cost) return '';
  if (!cost.with) return Object.entries(cost).map(([key, value]) => `${number(value)} ${key}`).join(', ');
  return Object.keys(cost.with).filter(key => !key.startsWith('ns') && !key.startsWith('ms') && key in cost.without)
    .map(key => [key, cost.without[key], cost.with[key]]).filter(([, without, used]) => without || used)
    .map(([key, without, used]) => `${key}: ${number(without)} without, ${number(used)} with`).join('; ');
}
at('used').append(data.effects.length ? table(['effect', 'how often', 'what it costs a camera ray, and the structures'],
  data.effects.map(effect => [effect.effect, effect.count, costOf(effect)]), 'Effects') :
  nothing('None of those that the report counts.'));
at('used').append(make('p', {class: 'muted'}, `A camera ray at accuracy robust: ${number(data.scene['nodes a ray'])} nodes, ` +
  `${number(data.scene['primitives a ray'])} primitives, ${number(data.scene['any-hit invocations a ray'])} any-hit and ` +
  `${number(data.scene['intersection invocations a ray'])} intersection invocations. Costs without figures are those ` +
  'that the reference builder cannot leave out.'));
const unused = data['enabled and not used'];
at('unused').append(unused.length ? table(['what', 'structures'], unused.map(row => [row.unused, row.count]),
  'Enabled and not used') : nothing('Nothing.'));

/* ---- device */

const device = data.device || {missing: 'This report was made without a device.'};
if (device.missing) at('of-device').append(nothing(device.missing));
else showDevice();

/* What is best by a figure, if it matters: by more than a tenth. */
function bestFlags(figure, verb) {
  const rows = device.flags.filter(row => row[figure] !== undefined).sort((a, b) => a[figure] - b[figure]);
  if (!rows.length) return '';
  const worst = rows[rows.length - 1], best = rows[0];
  return worst[figure] < 1.1 * best[figure] ? ` No flag matters for ${verb}.` :
    ` ${best.flags} is best for ${verb}: ${number(worst[figure] / best[figure])} times better than ${worst.flags}.`;
}

function showDevice() {
  const pays = device.type === 'CPU' ? ' It is a driver on the CPU: times depend on what else the machine does.' :
    bestFlags('ns a ray', 'tracing') + bestFlags('ms build', 'building');
  at('of-device').append(make('p', {}, `${device.device}, ${device.driver}.${pays}${bestFlags('bytes', 'memory')}` +
    (device.rays.length ?
    ' The table of accuracies above has its answers, about triangles alone.' : ' It has no ray queries, so it traces nothing here.')),
  make('div', {class: 'scroll'}, table(['build flags', 'ms to build', 'MiB', 'MiB compacted', 'KiB of scratch', 'ns a camera ray'],
    device.flags.map(row => [row.flags, row['ms build'] ?? '', row.bytes / 2 ** 20,
      row['compacted bytes'] ? row['compacted bytes'] / 2 ** 20 : '', row['scratch bytes'] / 2 ** 10, row['ns a ray'] ?? '']),
  'Build flags')));
}

/* ---- waste */

const advice = data.waste.advice;
at('advice').append(advice.length ? make('ul', {}, ...advice.map(each => make('li', {}, `${each.message} (${each.id})`))) :
  nothing('The capture has none: setting advice was off, or had nothing to say.'));

function curve({name, updates, points}) {
  const values = points.flatMap(point => [point.sah, point.rebuilt]), most = Math.max(...values) * 1.05;
  const path = key => points.map((point, i) =>
    `${i * 300 / Math.max(points.length - 1, 1)},${100 - point[key] / most * 100}`).join(' ');
  const last = points[points.length - 1];
  return make('figure', {}, make('figcaption', {}, make('b', {}, name), ` ${number(updates)} updates; SAH cost at the end ` +
    `${number(last.sah)}, rebuilt ${number(last.rebuilt)}`),
  make('svg', {viewBox: '0 0 300 100', preserveAspectRatio: 'none', role: 'img',
    'aria-label': `SAH cost of ${name} over its updates: from ${number(points[0].sah)} to ${number(last.sah)}`},
  make('polyline', {points: path('rebuilt'), class: 'rebuilt'}), make('polyline', {points: path('sah'), class: 'refitted'})));
}
const refits = data.waste.refits;
if (refits.length) {
  at('refits').before(make('p', {class: 'muted'}, 'The SAH cost is the expected work of a ray. Red: after updates; green: rebuilt ' +
    'from the same data. ' + (data.waste['structures left out'] ?
    `${number(data.waste['structures left out'])} structures with fewer updates are left out.` : '')));
  at('refits').append(...refits.map(curve));
} else {
  at('refits').append(nothing('No structure is updated.'));
}
