// How things look and how numbers are said; the other scripts take it from here.
'use strict';

// What a colour of the style sheet is now: on a light or a dark screen, or on paper.
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

// A line tells by its form, not by its colour alone, where it comes from.
const LINES = {
  measured: { width: 1.2, dashes: [[]] },
  estimated: { width: 2.2, dashes: [[9, 4], [14, 3, 3, 3], [5, 3]] },
  expected: { width: 1.8, dashes: [[2, 4]] },
  predicted: { width: 1.8, dashes: [[2, 4], [9, 4], [14, 3, 3, 3]] },
  bound: { width: 1.8, dashes: [[2, 4]] },
};

// How a line is drawn that is the so manyth of its kind in a plot: front and rear differ in grey, too.
function lineForm(source, place = 0) {
  const { width, dashes } = LINES[source];
  return { width, dash: dashes[place % dashes.length] };
}

// How many before a line in a list are of its kind.
const placeOfKind = (lines, at) => lines.slice(0, at).filter((line) => line.source === lines[at].source).length;

// In the legend, where a name alone does not say it.
const WORDS = { measured: '', estimated: 'estimated by gripd', expected: 'expected', predicted: '', bound: '' };

// Space around every plot, in CSS pixels: the same, so that the time axes of all panels lie below each other.
const LEFT = 48;
const RIGHT = 10;
const TOP = 8;
const BELOW = 26;
const FONT = '12px system-ui, sans-serif';

// A number with as many digits as one can tell apart in a plot.
function said(value) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  const decimals = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  return value.toFixed(decimals).replace('-', '−');
}

// The clock of the recording that a time of the page is in.
const clockAt = (clocks, time) => clocks.findLast((it) => it.from_s <= time) ?? clocks[0];

// The wall clock at a time of the page, where the recording has one.
function wallClock(clocks, time) {
  const clock = clockAt(clocks, time);
  if (!clock || clock.utc_s === null) return null;
  return new Date((clock.utc_s + time - clock.from_s) * 1000);
}

const hour = (moment) => moment.toISOString().slice(11);

// Writes into a plot. uPlot leaves its own alignment behind when it has drawn its axes.
function write(ctx, text, left, foot, align = 'left', size = 12) {
  ctx.font = `${size * devicePixelRatio}px system-ui, sans-serif`;
  ctx.textAlign = align;
  ctx.textBaseline = 'alphabetic';
  ctx.fillText(text, left, foot);
}

// Makes an element.
function make(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...children);
  return element;
}

// The axes of a plot.
function axes(names = {}) {
  const one = (size, more) => ({
    size,
    font: FONT,
    stroke: colour('muted'),
    grid: { stroke: colour('grid'), width: 0.6 },
    ticks: { stroke: colour('grid'), width: 0.6, size: 4 },
    gap: 4,
    values: (plot, splits) => splits.map((value) => String(value).replace('-', '−')),
    ...more,
  });
  return [one(BELOW, { space: 60, ...names.x }), one(leftOf, { space: 32, ...names.y })];
}

// Room for the widest number beside an axis; all panels begin at the same place where none is wider than usual.
function leftOf(plot, values) {
  const letters = (values ?? []).map((value) => (value ?? '').length);
  return Math.max(LEFT, 14 + 7 * Math.max(0, ...letters));
}

// The place of a time in a list of times in order: the nearest one's.
function nearest(times, time) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return high >= 0 && Math.abs(times[high] - time) < Math.abs(times[low] - time) ? high : low;
}
