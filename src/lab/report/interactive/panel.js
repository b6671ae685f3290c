// A panel: lines over time. All panels show the same time and the same cursor; `group` holds both.

const LANE = 32;

class TimePanel {
  constructor(spec, data, group, isFirst) {
    Object.assign(this, { spec, data, group, isFirst, plot: null, numbers: [] });
    this.place = make('div', { class: 'plot', role: 'img', 'aria-label': spec.title });
    this.legend = new Legend();
    this.element = make('figure', {}, make('h2', {}, spec.title));
    if (spec.empty) {
      this.element.append(make('p', { class: 'empty' }, spec.empty));
      return;
    }
    const areEstimated = spec.series.length > 0 && spec.series.every(({ source }) => ['estimated', 'bound'].includes(source));
    this.numbers = spec.series.map((_, at) => this.legend.line(spec.series, at, true, areEstimated));
    if (spec.series.some((series) => series.interval)) this.legend.add('band', 'muted', '95 % interval', false);
    for (const shade of spec.shades) this.legend.add('strip', shade.color, shade.name, false);
    for (const band of spec.bands ?? []) this.legend.add('band', band.color, band.name, false);
    this.element.append(this.legend.element);
    const axis = areEstimated ? `${spec.axis}; ${WORDS.estimated}` : spec.axis;
    if (axis) this.element.append(make('p', { class: 'axis' }, axis));
    this.element.append(this.place);
    if (spec.caption) this.element.append(make('figcaption', {}, spec.caption));
  }

  // Draws it anew: at first, for another width, in other colours.
  build(width) {
    if (this.spec.empty) return;
    this.plot?.destroy();
    const lanes = this.spec.lanes.length;
    const height = lanes ? lanes * LANE + TOP + BELOW : width < 500 ? 170 : 180;
    const { rows, series, bands } = this.lines();
    this.plot = new uPlot(
      {
        width,
        height,
        padding: [TOP, RIGHT, 0, 0],
        legend: { show: false },
        series,
        bands,
        cursor: {
          y: false,
          drag: { x: true, y: false, setScale: false },
          points: { size: (plot, place) => (series[place].isEdge ? 0 : 7) },
          bind: { dblclick: () => () => this.group.reset() },
        },
        scales: {
          x: { time: false, range: () => this.group.range },
          y: { range: (plot, low, high) => (lanes ? [0, lanes] : this.scale(low, high)) },
        },
        axes: axes(lanes ? { y: { values: () => [], splits: () => [], grid: { show: false } } } : {}),
        hooks: {
          drawClear: [(plot) => this.drawBehind(plot)],
          draw: [(plot) => this.drawMarks(plot)],
          setSelect: [(plot) => this.selected(plot)],
        },
      },
      rows,
      this.place,
    );
    // Mouse or finger themselves, not uPlot's cursor: that moves when the scale does, too.
    const { over } = this.plot;
    over.addEventListener('pointermove', (event) => {
      const left = event.clientX - over.getBoundingClientRect().left;
      this.group.point(this.plot.posToVal(left, 'x'), this);
    });
    over.addEventListener('pointerleave', (event) => {
      // What a finger has touched is still to be read when it is lifted.
      if (event.pointerType === 'mouse') this.group.point(null, this);
    });
  }

  // uPlot's columns: the times, each line, and the two edges of each interval, with the fill between them.
  lines() {
    const [rows, series, bands] = [[this.data.times], [{}], []];
    for (const [at, line] of this.spec.series.entries()) {
      const { width, dash } = lineForm(line.source, placeOfKind(this.spec.series, at));
      const stroke = colour(line.color);
      if (line.interval) {
        for (const edge of line.interval) {
          rows.push(edge);
          series.push({ stroke, width: 0.5, alpha: 0.5, points: { show: false }, isEdge: true });
        }
        bands.push({ series: [rows.length - 1, rows.length - 2], fill: `color-mix(in srgb, ${stroke} 20%, transparent)` });
      }
      rows.push(line.values);
      series.push({ stroke, width, dash, points: { size: 3, show: true, fill: stroke, filter: alone } });
    }
    if (this.spec.lanes.length) {
      rows.push(this.data.times.map(() => null));
      series.push({ points: { show: false } });
    }
    return { rows, series, bands };
  }

  // The vertical axis: all that is shown, within what makes sense.
  scale(low, high) {
    const { limits, reach } = this.spec;
    let [from, to] = [low ?? reach?.[0] ?? 0, high ?? reach?.[1] ?? 1];
    if (reach) [from, to] = [Math.min(from, reach[0]), Math.max(to, reach[1])];
    if (limits) [from, to] = [Math.max(from, limits[0]), Math.min(to, limits[1])];
    if (!(to > from)) [from, to] = [from - 1, from + 1];
    const pad = (to - from) * 0.06;
    return [limits && from === limits[0] ? from : from - pad, limits && to === limits[1] ? to : to + pad];
  }

  // How large something usually is; when something was so: a light ground, and a strip at the foot that is seen without colours, too.
  drawBehind(plot) {
    const { ctx, bbox } = plot;
    const pixel = devicePixelRatio;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const pieces = (span, draw) => {
      for (let at = 0; at < span.times.length; at += 2) {
        const from = plot.valToPos(span.times[at], 'x', true);
        const to = plot.valToPos(span.times[at + 1], 'x', true);
        if (to >= bbox.left && from <= bbox.left + bbox.width) draw(from, Math.max(to - from, 2 * pixel));
      }
    };
    const foot = bbox.top + bbox.height;
    for (const { values, color } of this.spec.bands ?? []) {
      const [low, high] = values.map((value) => plot.valToPos(value, 'y', true));
      ctx.fillStyle = colour(color);
      ctx.globalAlpha = 0.14;
      ctx.fillRect(bbox.left, high, bbox.width, low - high);
      ctx.globalAlpha = 1;
    }
    this.spec.shades.forEach((span, place) => {
      ctx.fillStyle = colour(span.color);
      const height = 4 * pixel;
      pieces(span, (from, length) => {
        ctx.globalAlpha = 0.07;
        ctx.fillRect(from, bbox.top, length, bbox.height);
        ctx.globalAlpha = 1;
        ctx.fillRect(from, foot - height * (1.5 * place + 1), length, height);
      });
    });
    this.spec.lanes.forEach((span, place) => {
      const top = bbox.top + place * LANE * pixel;
      ctx.fillStyle = colour('muted');
      write(ctx, span.name, bbox.left + 4 * pixel, top + 13 * pixel);
      ctx.fillStyle = colour(span.color);
      pieces(span, (from, length) => ctx.fillRect(from, top + 18 * pixel, length, 7 * pixel));
    });
    ctx.restore();
  }

  drawMarks(plot) {
    const { ctx, bbox } = plot;
    const pixel = devicePixelRatio;
    ctx.save();
    ctx.strokeStyle = ctx.fillStyle = colour('notice');
    ctx.font = `${11 * pixel}px system-ui, sans-serif`;
    ctx.setLineDash([3 * pixel, 3 * pixel]);
    ctx.lineWidth = pixel;
    let written = -Infinity;
    for (const { at_s: at, name } of [...this.data.marks].sort((one, other) => one.at_s - other.at_s)) {
      const x = plot.valToPos(at, 'x', true);
      if (x < bbox.left || x > bbox.left + bbox.width) continue;
      ctx.beginPath();
      ctx.moveTo(x, bbox.top);
      ctx.lineTo(x, bbox.top + bbox.height);
      ctx.stroke();
      // A name where there is room for it.
      const length = ctx.measureText(name).width + 8 * pixel;
      const isRight = x + length > bbox.left + bbox.width;
      const begin = isRight ? x - length : x;
      if (!this.isFirst || begin < written) continue;
      write(ctx, name, x + (isRight ? -4 : 4) * pixel, bbox.top + 12 * pixel, isRight ? 'right' : 'left', 11);
      written = begin + length;
    }
    ctx.restore();
  }

  selected(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    this.group.show(plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x'));
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
  }

  // The cursor of another panel.
  follow(time) {
    this.plot?.setCursor({ left: time === null ? -10 : this.plot.valToPos(time, 'x'), top: 0 }, false);
  }

  // The numbers at a time.
  read(time) {
    const row = time === null ? null : nearest(this.data.times, time);
    this.numbers.forEach((number, place) => {
      const { values, interval } = this.spec.series[place];
      const value = row === null ? null : values[row];
      const edges = row === null || value === null || !interval ? '' : ` (${said(interval[0][row])} to ${said(interval[1][row])})`;
      number.textContent = row === null ? '' : said(value) + edges;
    });
  }

  // Shows the time that the group shows.
  zoom() {
    const [min, max] = this.group.range;
    // In a batch the scale is there at once, and places can be asked for.
    this.plot?.batch(() => this.plot.setScale('x', { min, max }));
  }
}

// A value between two gaps would not be seen as a line.
function alone(plot, series, isShown, gaps) {
  const values = plot.data[series];
  const [from, to] = plot.series[0].idxs ?? [0, values.length - 1];
  const found = [];
  for (let row = from; row <= to; row += 1) {
    if (values[row] !== null && (values[row - 1] ?? null) === null && (values[row + 1] ?? null) === null) found.push(row);
  }
  return found;
}
