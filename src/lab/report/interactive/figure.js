// A figure: one quantity over another. It follows the time that the panels show: what is outside is faint.

class PlaneFigure {
  constructor(spec, group) {
    Object.assign(this, { spec, group, plot: null });
    this.place = make('div', { class: 'plot', role: 'img', 'aria-label': spec.title });
    this.here = make('div', { class: 'here', hidden: '' });
    this.element = make('figure', {}, make('h2', {}, spec.title));
    if (spec.answer) this.element.append(make('p', { class: 'answer' }, spec.answer));
    if (spec.empty) {
      this.element.append(make('p', { class: 'empty' }, spec.empty));
      return;
    }
    const legend = new Legend();
    for (const [at, points] of spec.points.entries()) {
      // One scale for all that have the same.
      if (points.shade && spec.points.findIndex(({ shade }) => shade?.name === points.shade.name) === at) legend.scale(points.shade);
      if (points.shade) continue;
      if (points.shape === 'path') legend.line(spec.points, at, false);
      else legend.add(points.shape === 'dots' ? 'dot' : 'dot ring', points.color, points.name, false);
    }
    spec.lines.forEach((_, at) => legend.line(spec.lines, at, false));
    if (spec.lines.some((line) => line.interval)) legend.add('band', 'muted', '95 % interval', false);
    for (const ring of spec.rings) legend.add('band', ring.color, ring.name, false);
    this.element.append(legend.element, make('p', { class: 'axis' }, `↑ ${spec.y_axis}`), this.place);
    this.element.append(make('p', { class: 'axis below' }, `${spec.x_axis} →`));
    if (spec.caption) this.element.append(make('figcaption', {}, spec.caption));
  }

  build(width) {
    if (this.spec.empty) return;
    this.plot?.destroy();
    const height = Math.round(Math.min(width * (this.spec.is_equal ? 0.86 : 0.66), 420));
    this.whole = this.extent(width - LEFT - RIGHT, height - TOP - BELOW);
    this.view ??= this.whole;
    // uPlot draws the axes and knows the scales; the rest is drawn here.
    this.plot = new uPlot(
      {
        width,
        height,
        padding: [TOP, RIGHT, 0, 0],
        legend: { show: false },
        series: [{}, { points: { show: false } }],
        cursor: {
          x: false,
          y: false,
          points: { show: false },
          drag: { x: true, y: true, setScale: false },
          bind: { dblclick: () => () => this.show(this.whole) },
        },
        scales: { x: { time: false, range: () => this.view.x }, y: { range: () => this.view.y } },
        axes: axes(),
        hooks: { draw: [(plot) => this.draw(plot)], setSelect: [(plot) => this.selected(plot)] },
      },
      [[0, 1], [null, null]],
      this.place,
    );
    this.plot.over.append(this.here);
  }

  show(view) {
    this.view = view;
    this.plot.batch(() => {
      this.plot.setScale('x', { min: view.x[0], max: view.x[1] });
      this.plot.setScale('y', { min: view.y[0], max: view.y[1] });
    });
    this.plot.redraw();
    this.point(this.group.time);
  }

  selected(plot) {
    const { left, width, top, height } = plot.select;
    if (width < 4 || height < 4) return;
    const x = [plot.posToVal(left, 'x'), plot.posToVal(left + width, 'x')];
    const y = [plot.posToVal(top + height, 'y'), plot.posToVal(top, 'y')];
    plot.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
    this.show({ x, y });
  }

  // What the axes go over to have all of it in them; with a unit as long on both axes where that is asked for.
  extent(width, height) {
    const box = { x: [Infinity, -Infinity], y: [Infinity, -Infinity] };
    const take = (axis, value) => {
      if (value === null) return;
      if (value < box[axis][0]) box[axis][0] = value;
      if (value > box[axis][1]) box[axis][1] = value;
    };
    for (const { x, y } of [...this.spec.points, ...this.spec.lines]) {
      x.forEach((value) => take('x', value));
      y.forEach((value) => take('y', value));
    }
    for (const { interval } of this.spec.lines) interval?.flat().forEach((value) => take('y', value));
    for (const { radii } of this.spec.rings) {
      for (const axis of ['x', 'y']) {
        take(axis, -radii[1]);
        take(axis, radii[1]);
      }
    }
    const pad = (range) => {
      const more = Math.max((range[1] - range[0]) * 0.05, 1e-6);
      return [range[0] - more, range[1] + more];
    };
    const whole = { x: pad(box.x), y: pad(box.y) };
    if (this.spec.is_equal) {
      const unit = Math.max((whole.x[1] - whole.x[0]) / width, (whole.y[1] - whole.y[0]) / height);
      const around = ([low, high], length) => [(low + high) / 2 - (unit * length) / 2, (low + high) / 2 + (unit * length) / 2];
      return { x: around(whole.x, width), y: around(whole.y, height) };
    }
    return whole;
  }

  draw(plot) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    const at = { x: (value) => plot.valToPos(value, 'x', true), y: (value) => plot.valToPos(value, 'y', true) };
    for (const ring of this.spec.rings) this.drawRing(ctx, at, ring);
    for (const points of this.spec.points) {
      if (points.shape === 'path') this.drawPath(ctx, at, points);
      else this.drawPoints(ctx, at, points);
    }
    for (const line of this.spec.lines) this.drawLine(ctx, at, line);
    ctx.restore();
  }

  drawRing(ctx, at, { radii, color }) {
    const [x, y] = [at.x(0), at.y(0)];
    const ellipse = (radius) => ctx.ellipse(x, y, at.x(radius) - x, Math.abs(at.y(radius) - y), 0, 0, 2 * Math.PI);
    ctx.fillStyle = ctx.strokeStyle = colour(color);
    ctx.globalAlpha = 0.18;
    ctx.beginPath();
    ellipse(radii[1]);
    ellipse(radii[0]);
    ctx.fill('evenodd');
    ctx.globalAlpha = 1;
    ctx.lineWidth = 1.5 * devicePixelRatio;
    ctx.setLineDash(lineForm('estimated').dash.map((length) => length * devicePixelRatio));
    for (const radius of radii) {
      ctx.beginPath();
      ellipse(radius);
      ctx.stroke();
    }
    ctx.setLineDash([]);
  }

  // What has no time is of all of it.
  isShown(time) {
    const [from, to] = this.group.range;
    return time === undefined || (time >= from && time <= to);
  }

  drawPoints(ctx, at, { x, y, times, shape, color, shade }) {
    ctx.fillStyle = ctx.strokeStyle = colour(color);
    ctx.lineWidth = 1.2 * devicePixelRatio;
    const colours = shade && shades();
    // A colour takes some room to be seen.
    const radius = (shape === 'rings' || shade ? 2.6 : 1.6) * devicePixelRatio;
    x.forEach((value, place) => {
      if (value === null || y[place] === null) return;
      if (shade) ctx.fillStyle = colours.get(shadeStep(shade, place));
      ctx.globalAlpha = this.isShown(times[place]) ? 0.75 : 0.12;
      ctx.beginPath();
      ctx.arc(at.x(value), at.y(y[place]), radius, 0, 2 * Math.PI);
      if (shape === 'dots') ctx.fill();
      else ctx.stroke();
    });
    ctx.globalAlpha = 1;
  }

  // In pieces of one colour and width; more of what shades it is wider, too.
  drawPath(ctx, at, { x, y, times, shade, color }) {
    const step = (place) => (shade ? shadeStep(shade, place) : 0);
    const colours = shade ? shades() : new Map([[0, colour(color)]]);
    ctx.lineCap = 'round';
    let place = 1;
    while (place < x.length) {
      const [kind, isShown] = [step(place), this.isShown(times[place])];
      ctx.strokeStyle = colours.get(kind);
      ctx.lineWidth = (1.6 + (3 * Math.abs(kind)) / SHADES) * devicePixelRatio;
      ctx.globalAlpha = isShown ? 1 : 0.15;
      ctx.beginPath();
      for (; place < x.length && step(place) === kind && this.isShown(times[place]) === isShown; place += 1) {
        if (x[place] === null || x[place - 1] === null) continue;
        ctx.moveTo(at.x(x[place - 1]), at.y(y[place - 1]));
        ctx.lineTo(at.x(x[place]), at.y(y[place]));
      }
      ctx.stroke();
    }
    ctx.globalAlpha = 1;
    if (times.length) this.drawStart(ctx, at, x, y);
  }

  drawStart(ctx, at, x, y) {
    const pixel = devicePixelRatio;
    const [left, top] = [at.x(x[0]), at.y(y[0])];
    ctx.strokeStyle = ctx.fillStyle = colour('ink');
    ctx.lineWidth = 2 * pixel;
    ctx.strokeRect(left - 4 * pixel, top - 4 * pixel, 8 * pixel, 8 * pixel);
    write(ctx, 'start', left + 8 * pixel, top - 6 * pixel);
  }

  drawLine(ctx, at, { x, y, source, color, interval }) {
    const run = (values, isBack) => {
      const places = isBack ? x.map((_, place) => x.length - 1 - place) : x.map((_, place) => place);
      for (const place of places) ctx.lineTo(at.x(x[place]), at.y(values[place]));
    };
    ctx.strokeStyle = ctx.fillStyle = colour(color);
    if (interval) {
      ctx.globalAlpha = 0.2;
      ctx.beginPath();
      run(interval[0], false);
      run(interval[1], true);
      ctx.fill();
      ctx.globalAlpha = 1;
    }
    const { width, dash } = lineForm(source);
    ctx.lineWidth = width * devicePixelRatio;
    ctx.setLineDash(dash.map((length) => length * devicePixelRatio));
    ctx.beginPath();
    run(y, false);
    ctx.stroke();
    ctx.setLineDash([]);
  }

  // Where the car was at a time.
  point(time) {
    if (!this.plot) return;
    const [LONGEST, over] = [1, this.plot.over.getBoundingClientRect()];
    let [best, left, top] = [LONGEST, -1, -1];
    for (const { times, x, y } of time === null ? [] : this.spec.points) {
      const place = nearest(times, time);
      const apart = Math.abs(times[place] - time);
      // Without times it is not a number, and nothing is nearer.
      if (!(apart < best) || x[place] === null) continue;
      [best, left, top] = [apart, this.plot.valToPos(x[place], 'x'), this.plot.valToPos(y[place], 'y')];
    }
    this.here.hidden = left < 0 || top < 0 || left > over.width || top > over.height;
    this.here.style.left = `${left}px`;
    this.here.style.top = `${top}px`;
  }

  zoom() {
    this.plot?.redraw();
  }
}
