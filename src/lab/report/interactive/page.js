// The page: what is shown of the time, the cursor, and when to draw.
//
// For tests and for whoever wants to steer it from outside there is `window.gripd`: `show(from, to)` and `reset()` zoom all
// panels (s from the start), `point(time)` sets the cursor, `ranges()` gives what each panel shows. `<html>` has
// `data-ready` (how many plots are drawn) when it is done, and `data-error` when something went wrong.

const root = document.documentElement;

function fail(message) {
  root.dataset.error = message;
  const place = document.getElementById('failure');
  place.hidden = false;
  place.textContent = `The plots cannot be drawn: ${message}`;
}
addEventListener('error', (event) => fail(event.message));

class Page {
  constructor(data) {
    this.data = data;
    const { times } = data;
    this.whole = times.length ? [times[0], Math.max(times[times.length - 1], times[0] + 0.01)] : [0, 1];
    // What the panels and figures ask for.
    this.range = this.whole;
    this.time = null;
    const first = data.panels.findIndex((panel) => !panel.empty);
    this.panels = data.panels.map((panel, place) => new TimePanel(panel, data, this, place === first));
    this.figures = data.figures.map((figure) => new PlaneFigure(figure, this));
    document.getElementById('panels').append(...this.panels.map((panel) => panel.element));
    document.getElementById('figures').append(...this.figures.map((figure) => figure.element));
  }

  all() {
    return [...this.figures, ...this.panels];
  }

  // Draws everything anew.
  build() {
    // CSS pixels, of what is printed on an upright sheet.
    const PAPER = { panels: 690, figures: 218 };
    for (const part of ['figures', 'panels']) {
      for (const it of this[part]) it.build(root.hasAttribute('data-paper') ? PAPER[part] : Math.max(it.element.clientWidth, 200));
    }
    this.tell();
    root.dataset.ready = String(this.all().filter((it) => it.plot).length);
  }

  // Shows a stretch of time in all panels.
  show(from, to) {
    const SHORTEST = 0.05;
    const [first, last] = this.whole;
    const length = Math.min(Math.max(to - from, SHORTEST), last - first);
    const start = Math.min(Math.max(from, first), last - length);
    this.range = [start, start + length];
    for (const it of this.all()) it.zoom();
    this.point(this.time);
    this.tell();
  }

  reset() {
    this.show(...this.whole);
  }

  // The cursor stands at a time, or nowhere; `from` is the panel that it is in.
  point(asked, from = null) {
    const [first, last] = this.whole;
    const time = asked === null ? null : Math.min(Math.max(asked, first), last);
    this.time = time;
    for (const panel of this.panels) {
      if (panel !== from) panel.follow(time);
      panel.read(time);
    }
    for (const figure of this.figures) figure.point(time);
    document.getElementById('clock').textContent = time === null ? '' : this.moment(time, 2);
  }

  // A time as both clocks have it; of several recordings that count for themselves, with the one it is of.
  moment(time, decimals) {
    const { clocks } = this.data;
    const [clock, wall] = [clockAt(clocks, time), wallClock(clocks, time)];
    const isOwn = clocks.length > 1 && clock.own_s !== undefined;
    const own = isOwn ? clock.own_s + time - clock.from_s : time;
    return `${own.toFixed(decimals)} s${isOwn ? ` of ${clock.name}` : ''}${wall ? ` (${wall.toISOString()})` : ''}`;
  }

  tell() {
    const [from, to] = this.range;
    const [begin, end] = [wallClock(this.data.clocks, from), wallClock(this.data.clocks, to)];
    const wall = begin && end ? ` (${begin.toISOString()} to ${hour(end)})` : ' from the start';
    const areOwn = this.data.clocks.length > 1 && this.data.clocks[0].own_s !== undefined;
    document.getElementById('shown').textContent = areOwn
      ? `${this.moment(from, 1)} to ${this.moment(to, 1)}`
      : `${from.toFixed(1)} to ${to.toFixed(1)} s${wall}`;
  }

  move(how) {
    const [from, to] = this.range;
    const length = to - from;
    const middle = this.time ?? (from + to) / 2;
    const share = (middle - from) / length;
    if (how === 'earlier') this.show(from - length / 3, to - length / 3);
    if (how === 'later') this.show(from + length / 3, to + length / 3);
    if (how === 'closer') this.show(middle - (share * length) / 2, middle + ((1 - share) * length) / 2);
    if (how === 'farther') this.show(middle - share * length * 2, middle + (1 - share) * length * 2);
    if (how === 'all') this.reset();
  }
}

function begin() {
  const page = new Page(JSON.parse(document.getElementById('data').textContent));
  page.build();
  for (const button of document.querySelectorAll('[data-move]')) {
    button.addEventListener('click', () => page.move(button.dataset.move));
  }
  // For another width, and in other colours, everything is drawn anew; a moment later, for sizes change in steps.
  let waiting = 0;
  const again = () => {
    clearTimeout(waiting);
    waiting = setTimeout(() => page.build(), 80);
  };
  let width = innerWidth;
  addEventListener('resize', () => {
    if (innerWidth !== width) again();
    width = innerWidth;
  });
  matchMedia('(prefers-color-scheme: dark)').addEventListener('change', again);
  addEventListener('beforeprint', () => {
    root.dataset.paper = '';
    page.build();
  });
  addEventListener('afterprint', () => {
    delete root.dataset.paper;
    page.build();
  });
  window.gripd = {
    show: (from, to) => page.show(from, to),
    reset: () => page.reset(),
    point: (time) => page.point(time),
    ranges: () => page.panels.filter((panel) => panel.plot).map(({ plot: { scales } }) => [scales.x.min, scales.x.max]),
  };
}

try {
  begin();
} catch (error) {
  fail(error.message);
  throw error;
}
