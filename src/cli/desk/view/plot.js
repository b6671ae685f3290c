// A plot over time on a canvas: bands, lines and spans. It knows colours by the names of the style sheet's
// variables, so that light and dark screens have their own.

const LEFT = 46;
const RIGHT = 10;
const TOP = 8;
const AXIS = 24;
const ROW = 32;
// Between rows further apart than this there was nothing, s.
export const PAUSE = 1.0;

let colors = {};

export function readColors() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ground", "panel", "rule", "ink", "muted", "grid", "truth", "first", "second", "third", "notice"];
  colors = Object.fromEntries(names.map((name) => [name, style.getPropertyValue("--" + name).trim()]));
}

function niceStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return ([1, 2, 5, 10].find((factor) => factor * power >= least * 0.999) ?? 10) * power;
}

function timeSteps(span) {
  return [1, 2, 5, 10, 15, 30, 60, 120, 300].find((step) => span / step <= 8) ?? 600;
}

// Is a clock one that counts from 1970? The frames' clocks that do are in UTC.
export const isUtc = (t) => t >= 1e8;

// Seconds; hours, minutes and seconds where they are many, in UTC where the clock is one: as `gripd monitor` has them.
export function timeText(t) {
  const seconds = Math.round(t);
  if (Math.abs(seconds) < 3600) return `${numberText(seconds, 0)} s`;
  return new Date(seconds * 1000).toISOString().slice(11, 19);
}

export function numberText(value, decimals) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  const text = value.toFixed(decimals);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

export class Plot {
  // `series`: { kind: "line" | "band", name, color, ... }; `get` functions take a row.
  // `range` and `step` fix the scale: what is outside is drawn at its end. `least`: the smallest span it shows.
  constructor({ title, note, height, range, step, least, decimals, series, spans }) {
    Object.assign(this, { range, step, least, decimals, series, spans });
    this.figure = document.createElement("figure");
    const heading = document.createElement("h2");
    heading.textContent = title;
    this.legend = document.createElement("ul");
    this.legend.className = "legend";
    this.outputs = [];
    for (const item of series ?? []) this.addLegend(item);
    this.canvas = document.createElement("canvas");
    this.canvas.style.height = height + "px";
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", title);
    this.figure.append(heading, this.legend, this.canvas);
    if (note) {
      const caption = document.createElement("figcaption");
      caption.textContent = note;
      this.figure.append(caption);
    }
    this.drawn = 0;
  }

  addLegend(item) {
    const entry = document.createElement("li");
    const swatch = document.createElement("i");
    if (item.kind === "band") swatch.className = "band";
    // Not an attribute: the page's policy forbids styles in the text, not those that its script sets.
    swatch.style.color = `var(--${item.color})`;
    entry.append(swatch, item.name);
    if (item.get) {
      const output = document.createElement("output");
      this.outputs.push([output, item]);
      entry.append(output);
    }
    this.legend.append(entry);
  }

  // The time under the pointer, if it is on this plot.
  timeAt(clientX, from, to) {
    const box = this.canvas.getBoundingClientRect();
    const share = (clientX - box.left - LEFT) / Math.max(1, box.width - LEFT - RIGHT);
    return from + Math.min(1, Math.max(0, share)) * (to - from);
  }

  // `current` is the row of the moment, for the numbers while there is no cursor.
  draw(rows, from, to, cursor, current) {
    const box = this.canvas.getBoundingClientRect();
    if (box.width < 10) return;
    const scale = window.devicePixelRatio || 1;
    if (this.spans) this.canvas.style.height = `${TOP + AXIS + ROW * Math.max(1, this.spans(rows, from, to).length)}px`;
    const height = this.canvas.getBoundingClientRect().height;
    const pixels = [Math.round(box.width * scale), Math.round(height * scale)];
    if (this.canvas.width !== pixels[0] || this.canvas.height !== pixels[1]) {
      [this.canvas.width, this.canvas.height] = pixels;
    }
    const g = this.canvas.getContext("2d");
    g.setTransform(scale, 0, 0, scale, 0, 0);
    g.clearRect(0, 0, box.width, height);
    const area = { left: LEFT, right: box.width - RIGHT, top: TOP, bottom: height - AXIS };
    const x = (t) => area.left + ((t - from) / (to - from)) * (area.right - area.left);
    g.font = "12px system-ui, sans-serif";
    this.timeAxis(g, area, x, from, to);
    if (this.spans) this.drawSpans(g, area, x, rows, from, to);
    else this.drawSeries(g, area, x, rows, from, to);
    if (cursor !== null && cursor >= from && cursor <= to) {
      g.strokeStyle = colors.muted;
      g.lineWidth = 1;
      g.beginPath();
      g.moveTo(x(cursor), area.top);
      g.lineTo(x(cursor), area.bottom);
      g.stroke();
    }
    const row = cursor === null ? current : rowAt(rows, cursor);
    for (const [output, item] of this.outputs) {
      const value = row ? item.get(row) : null;
      output.textContent = numberText(value, this.decimals);
    }
    this.drawn += 1;
  }

  timeAxis(g, area, x, from, to) {
    g.strokeStyle = colors.grid;
    g.fillStyle = colors.muted;
    g.lineWidth = 1;
    g.textBaseline = "top";
    g.textAlign = "center";
    const room = (area.right - area.left) / 74;
    let step = timeSteps(to - from);
    while ((to - from) / step > room) step *= 2;
    for (let t = Math.ceil(from / step) * step; t <= to; t += step) {
      const at = Math.round(x(t)) + 0.5;
      g.beginPath();
      g.moveTo(at, area.top);
      g.lineTo(at, area.bottom);
      g.stroke();
      if (at > area.left + 18 && at < area.right - 18) g.fillText(timeText(t), at, area.bottom + 6);
    }
  }

  // From where to where the values reach, rounded outwards.
  extent(rows, from, to) {
    if (this.range) return { low: this.range[0], high: this.range[1], step: this.step };
    let [low, high] = [Infinity, -Infinity];
    for (const row of rows) {
      if (row[0] < from || row[0] > to) continue;
      for (const item of this.series) {
        for (const value of item.kind === "band" ? item.band(row) ?? [] : [item.get(row)]) {
          if (value === null || !Number.isFinite(value)) continue;
          low = Math.min(low, value);
          high = Math.max(high, value);
        }
      }
    }
    if (!(low <= high)) [low, high] = [0, this.least ?? 1];
    const missing = (this.least ?? 0) - (high - low);
    if (missing > 0) [low, high] = [low - missing / 2, high + missing / 2];
    const step = niceStep(Math.max(high - low, 1e-9) / 4);
    return { low: Math.floor(low / step + 1e-6) * step, high: Math.ceil(high / step - 1e-6) * step, step };
  }

  drawSeries(g, area, x, rows, from, to) {
    const { low, high, step } = this.extent(rows, from, to);
    const y = (value) => area.bottom - ((Math.min(high, Math.max(low, value)) - low) / (high - low)) * (area.bottom - area.top);
    const decimals = Math.min(6, Math.max(0, -Math.floor(Math.log10(step) + 1e-9)));
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (let line = low; line <= high + step / 2; line += step) {
      const at = Math.round(y(line)) + 0.5;
      g.strokeStyle = colors.grid;
      g.beginPath();
      g.moveTo(area.left, at);
      g.lineTo(area.right, at);
      g.stroke();
      g.fillStyle = colors.muted;
      g.fillText(numberText(line, decimals), area.left - 6, at);
    }
    // A little beyond the edges, so that lines reach them.
    const seen = rows.filter((row) => row[0] >= from - PAUSE && row[0] <= to + PAUSE);
    g.save();
    g.beginPath();
    g.rect(area.left, 0, area.right - area.left, area.bottom + 1);
    g.clip();
    // Lines over bands: no interval is to hide another one's value.
    for (const item of this.series) if (item.kind === "band") drawBand(g, seen, item, x, y, high);
    for (const item of this.series) if (item.kind === "line") drawLine(g, seen, item, x, y);
    g.restore();
  }

  drawSpans(g, area, x, rows, from, to) {
    const lanes = this.spans(rows, from, to);
    g.textBaseline = "middle";
    if (lanes.length === 0) {
      g.fillStyle = colors.muted;
      g.textAlign = "left";
      g.fillText("none in this time", area.left, area.top + ROW / 2);
    }
    lanes.forEach((lane, place) => {
      const top = area.top + place * ROW;
      g.fillStyle = colors.ink;
      g.textAlign = "left";
      g.fillText(lane.name, area.left, top + 8);
      for (const [start, end, color] of lane.spans) {
        const [a, b] = [Math.max(start, from), Math.min(end, to)];
        if (b < a) continue;
        g.fillStyle = colors[color ?? lane.color];
        g.fillRect(x(a), top + 17, Math.max(2, x(b) - x(a)), 10);
      }
    });
  }
}

function drawLine(g, rows, item, x, y) {
  g.strokeStyle = colors[item.color];
  g.lineWidth = 1.8;
  g.lineJoin = "round";
  g.beginPath();
  let before = null;
  for (const row of rows) {
    const value = item.get(row);
    if (value === null || !Number.isFinite(value)) {
      before = null;
      continue;
    }
    const together = before !== null && row[0] - before <= PAUSE;
    if (together) g.lineTo(x(row[0]), y(value));
    else {
      // A single value is a dot, not nothing.
      g.moveTo(x(row[0]) - 0.5, y(value));
      g.lineTo(x(row[0]), y(value));
    }
    before = row[0];
  }
  g.stroke();
}

function drawBand(g, rows, item, x, y, top) {
  g.fillStyle = colors[item.color];
  g.globalAlpha = item.loose ? 0.14 : 0.24;
  let piece = [];
  const fill = () => {
    if (piece.length > 0) {
      g.beginPath();
      for (const [t, , high] of piece) g.lineTo(x(t), y(high));
      for (const [t, low] of piece.reverse()) g.lineTo(x(t), y(low));
      g.closePath();
      g.fill();
    }
    piece = [];
  };
  for (const row of rows) {
    const band = item.band(row);
    if (!band || (piece.length > 0 && row[0] - piece[piece.length - 1][0] > PAUSE)) fill();
    if (band) piece.push([row[0], band[0], band[1] ?? top]);
  }
  fill();
  g.globalAlpha = 1;
}

// The last row that is not after this time, if there is one near it.
function rowAt(rows, time) {
  let [low, high] = [0, rows.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (rows[middle][0] <= time) low = middle + 1;
    else high = middle;
  }
  const row = rows[low - 1];
  return row && time - row[0] <= PAUSE ? row : null;
}
