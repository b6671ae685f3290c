// The page: takes what comes from the program, keeps the last minutes, shows numbers and draws plots.

import { PAUSE, Plot, isUtc, numberText, readColors, timeText } from "./plot.js";

const KEPT_S = 600;
const byId = (id) => document.getElementById(id);

let meta = null;
let place = {};
let rows = [];
let now = null;
// What the numbers beside the plots say while nothing points into them: the same as the cards.
let current = null;
// The program does not answer: what is shown is old.
let gone = false;
let plots = [];
let cursor = null;
let paused = false;
let shownTo = null;
let updates = 0;

// A value of a row by the column's name; null where there is none.
const at = (name) => (row) => row[place[name]] ?? null;
const scaled = (name, factor) => (row) => {
  const value = at(name)(row);
  return value === null ? null : value * factor;
};
const DEGREES = 180 / Math.PI;

// value ± 1.96 standard deviations.
const interval = (name, std) => (row) => {
  const [value, half] = [at(name)(row), at(std)(row)];
  return value === null || half === null ? null : [value - 1.96 * half, value + 1.96 * half];
};

// What the friction may be: bounded from above, or open.
const friction = (open) => (row) => {
  const [low, best, high] = ["mu_max_low", "mu_max", "mu_max_high"].map((name) => at(name)(row));
  const bounded = best !== null && high !== null;
  if (low === null && best === null) return null;
  return open === bounded ? null : [low ?? 0, bounded ? high : null];
};

const WHEEL_NAMES = { fl: "front left", fr: "front right", rl: "rear left", rr: "rear right" };

function makePlots() {
  const slopes = meta.driven.flatMap((wheel, index) => {
    const color = ["first", "second", "third", "truth"][index];
    return [
      { kind: "band", name: `${WHEEL_NAMES[wheel]}: 95 % interval`, color, band: interval(`slope_${wheel}`, "slope_std") },
      { kind: "line", name: WHEEL_NAMES[wheel], color, get: at(`slope_${wheel}`) },
    ];
  });
  const axles = [["front", "first"], ["rear", "second"]].flatMap(([axle, color]) => [
    { kind: "band", name: `${axle}: 95 % interval`, color, band: interval(`cornering_${axle}`, `cornering_${axle}_std`) },
    { kind: "line", name: axle, color, get: at(`cornering_${axle}`) },
  ]);
  const has = (name) => meta.inputs.includes(name);
  const list = [
    new Plot({
      title: "Friction between tires and road", height: 250, range: [0, 1.2], step: 0.2, decimals: 2,
      note: "Shaded is what the friction may be. While little of it is used, nothing tells how much there is: only that it is at least what was used.",
      series: [
        { kind: "band", name: "available: this or any more", color: "muted", loose: true, band: friction(true) },
        { kind: "band", name: "available: 95 % interval", color: "third", band: friction(false) },
        { kind: "line", name: "in use", color: "first", get: at("mu_used") },
        { kind: "line", name: "at least", color: "second", get: at("mu_max_low") },
        { kind: "line", name: "available", color: "third", get: at("mu_max") },
      ],
    }),
    new Plot({ title: "Slip slope: force / static wheel load, per slip", height: 210, least: 10, decimals: 1, series: slopes, note: "No line: not available." }),
    new Plot({ title: "Cornering stiffness, 1/rad", height: 210, least: 5, decimals: 2, series: axles, note: "" }),
    new Plot({
      title: "Sideslip, degrees", height: 160, least: 2, decimals: 2, note: "Positive to the left.",
      series: [{ kind: "line", name: "sideslip", color: "first", get: scaled("sideslip", DEGREES) }],
    }),
    new Plot({
      title: "Speed, km/h", height: 160, least: 20, decimals: 1, note: "",
      series: [{ kind: "line", name: "speed", color: "first", get: scaled("speed", 3.6) }],
    }),
    new Plot({
      title: "Steering wheel angle, degrees", height: 160, least: 20, decimals: 1, note: "As measured, positive to the left.",
      series: [{ kind: "line", name: "steering wheel", color: "first", get: scaled("steering_wheel_angle", DEGREES) }],
    }),
  ];
  const accelerations = [["lateral", "first", "lateral_acceleration"], ["longitudinal", "second", "longitudinal_acceleration"]]
    .filter(([, , name]) => has(name))
    .map(([name, color, column]) => ({ kind: "line", name, color, get: at(column) }));
  if (accelerations.length > 0) {
    list.push(new Plot({ title: "Acceleration, m/s²", height: 160, least: 2, decimals: 2, note: "As measured, positive to the left and forward.", series: accelerations }));
  }
  list.push(new Plot({ title: "Valid, state and faults", height: 60, spans: lanes, note: "From when to when a number could be acted upon (green), the service was not running as it should (orange), something was wrong (pink)." }));
  byId("plots").replaceChildren(...list.map((plot) => plot.figure));
  for (const plot of list) {
    plot.canvas.addEventListener("pointermove", (event) => {
      const [from, to] = shownTime();
      cursor = plot.timeAt(event.clientX, from, to);
      schedule();
    });
    plot.canvas.addEventListener("pointerleave", () => {
      cursor = null;
      schedule();
    });
  }
  return list;
}

// Stretches of time in which something held, one lane for each thing that held at all.
function lanes(all, from, to) {
  const seen = all.filter((row) => row[0] >= from - 1 && row[0] <= to);
  const lane = (name, color, holds) => {
    const spans = [];
    for (const row of seen) {
      if (!holds(row)) continue;
      const last = spans[spans.length - 1];
      if (last && row[0] - last[1] < 0.35) last[1] = row[0] + 0.1;
      else spans.push([row[0], row[0] + 0.1]);
    }
    return { name, color, spans };
  };
  const flag = (name) => (row) => at(name)(row) === 1;
  const state = (number) => (row) => at("state")(row) === number;
  const list = [
    lane("friction valid", "third", flag("mu_valid")),
    lane("slopes valid", "third", flag("slope_valid")),
    lane("cornering valid", "third", flag("cornering_valid")),
    lane("motion valid", "third", flag("motion_valid")),
    ...meta.states.map((name, number) => (name === "running" ? null : lane(name.replace("_", " "), "second", state(number)))),
    ...meta.faults.map((name, bit) => lane(name.replaceAll("_", " "), "notice", (row) => ((at("faults")(row) ?? 0) >> bit) & 1)),
  ];
  return list.filter((one) => one && one.spans.length > 0);
}

// No more than there is: until the window is full, its beginning is that of what came, but for the first seconds.
const LEAST_SHOWN_S = 10;
function shownTime() {
  const to = (paused ? shownTo : null) ?? now?.time ?? rows[rows.length - 1]?.[0] ?? 0;
  const first = Math.min(rows[0]?.[0] ?? to, to - LEAST_SHOWN_S);
  return [Math.max(first, to - Number(byId("window").value)), to];
}

// The last row with the newest estimates in it, which are up to a tenth of a second younger.
function currentRow() {
  const last = rows[rows.length - 1];
  if (!last || now.time - last[0] > PAUSE) return null;
  return last.map((value, index) => (value === null ? null : now.estimates[meta.columns[index - 1]] ?? value));
}

let scheduled = false;
function schedule() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    const [from, to] = shownTime();
    for (const plot of plots) plot.draw(rows, from, to, cursor, current);
  });
}

function element(name, text, className) {
  const made = document.createElement(name);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

function age(ms) {
  if (ms === null) return "never";
  return ms < 1000 ? `${Math.round(ms)} ms` : ms < 100000 ? `${(ms / 1000).toFixed(1)} s` : `${Math.round(ms / 60000)} min`;
}

const WORDS = { valid: "valid", not_valid: "not valid", absent: "not available", stale: "stale", never: "not published" };

// One card: its name, the number, and how sure it is.
function card(name, value, unit, state, note) {
  const box = element("div", "", state);
  const explained = element("dd", "", "note");
  explained.append(element("b", WORDS[state] ?? ""), note ? ` ${note}` : "");
  box.append(element("dt", name), element("dd", `${value}${unit && value !== "–" ? " " + unit : ""}`), explained);
  return box;
}

function range(low, high, decimals) {
  return low === null || high === null ? "" : `${numberText(low, decimals)} to ${numberText(high, decimals)}`;
}

// Is what a message said still so?
function wordOf(message) {
  const word = now.words[message] ?? "never";
  return gone && word === "fresh" ? "stale" : word;
}

function showFacts() {
  const e = now.estimates;
  const around = (value, std, decimals) => (value === null || std === null ? "" : range(value - 1.96 * std, value + 1.96 * std, decimals));
  const state = (message, value, valid) => {
    const word = wordOf(message);
    if (word !== "fresh") return word;
    return value === null ? "absent" : valid ? "valid" : "not_valid";
  };
  const mu = state("GRIP_FRICTION", e.mu_max, e.mu_valid);
  const bounds = e.mu_max === null && e.mu_max_low !== null ? `at least ${numberText(e.mu_max_low, 2)}` : range(e.mu_max_low, e.mu_max_high, 2);
  const cards = [
    card("Friction available", numberText(e.mu_max, 2), "", mu, [bounds, e.mu_max === null ? "" : now.source].filter(Boolean).join("; ")),
    card("Friction in use", numberText(e.mu_used, 2), "", wordOf("GRIP_FRICTION") === "fresh" ? "" : mu, ""),
  ];
  for (const wheel of meta.driven) {
    const value = e[`slope_${wheel}`];
    cards.push(card(`Slip slope, ${WHEEL_NAMES[wheel]}`, numberText(value, 1), "", state("GRIP_STIFFNESS_LONG", value, e.slope_valid), around(value, e.slope_std, 1)));
  }
  for (const axle of ["front", "rear"]) {
    const value = e[`cornering_${axle}`];
    cards.push(card(`Cornering stiffness, ${axle}`, numberText(value, 1), "/rad", state("GRIP_STIFFNESS_LAT", value, e.cornering_valid), around(value, e[`cornering_${axle}_std`], 1)));
  }
  const sideslip = e.sideslip === null ? null : e.sideslip * DEGREES;
  cards.push(card("Sideslip", numberText(sideslip, 1), "°", state("GRIP_MOTION", e.sideslip, e.motion_valid), ""));
  const speed = e.speed === null ? null : e.speed * 3.6;
  cards.push(card("Speed", numberText(speed, 0), "km/h", wordOf("GRIP_MOTION") === "fresh" ? "" : state("GRIP_MOTION", e.speed, true), ""));
  byId("facts").replaceChildren(...cards);
  const found = mu === "valid" || mu === "not_valid"
    ? `Friction ${numberText(e.mu_max, 2)}${bounds ? ` (${bounds})` : ""}${mu === "valid" ? "" : ", not valid"}`
    : mu === "absent" ? (e.mu_max_low === null ? "Friction: nothing tells it yet" : `Friction: at least ${numberText(e.mu_max_low, 2)}`)
    : mu === "stale" ? "The estimates are stale" : "No estimates so far";
  byId("headline").textContent = found;
}

function fill(id, lines) {
  byId(id).tBodies[0].replaceChildren(...lines.map(([bad, head, ...cells]) => {
    const row = element("tr", "", bad ? "bad" : "");
    const name = element("th", head);
    name.scope = "row";
    row.append(name, ...cells.map(([text, className]) => element("td", text, className)));
    return row;
  }));
}

function showTables() {
  // Ages are as the program told them last: without it they say nothing.
  const aged = (ms) => (gone ? "–" : age(ms));
  const rate = (message) => (gone ? "–" : message.rate.toFixed(0));
  fill("inputs", now.inputs.map((input) => {
    const state = gone && input.state === "" ? "stale" : input.state;
    return [
      state !== "",
      input.label,
      [`${numberText(input.value, input.decimals)} ${input.unit}`.trim()],
      [aged(input.age_ms)],
      [state, "state"],
    ];
  }));
  const errors = (count) => [String(count), count > 0 ? "error" : ""];
  fill("messages", now.messages.map((message) => [
    gone || message.state === "stale",
    message.name,
    [rate(message)],
    [gone ? "stale" : message.state === "stale" ? `stale, ${age(message.age_ms)}` : age(message.age_ms)],
    errors(message.crc_errors),
    errors(message.counter_errors),
  ]));
  fill("traffic", now.traffic.map((message) => [gone, message.name, [message.id], [rate(message)], [aged(message.age_ms)]]));
  byId("messages-title").textContent = now.own ? "What gripd would publish" : "Published messages";
}

function show() {
  current = currentRow();
  document.body.classList.toggle("gone", gone);
  byId("clock").textContent = `· ${timeText(now.time)}${isUtc(now.time) ? " UTC" : ""}${now.remark ? " · " + now.remark : ""}`;
  const told = byId("told");
  told.textContent = gone ? "The program that sent this does not answer any more: everything here is as it said last." : now.told;
  told.className = gone || now.warn ? "lead warn" : "lead";
  const chips = now.faults.map(([name, words]) => element("li", `${name}: ${words}`));
  byId("faults").replaceChildren(...(chips.length > 0 ? chips : [element("li", "no faults", "none")]));
  showFacts();
  showTables();
}

function take(update) {
  if (update.anew) rows = [];
  for (const row of update.rows) rows.push(row);
  const end = rows[rows.length - 1]?.[0] ?? 0;
  let old = 0;
  while (old < rows.length && rows[old][0] < end - KEPT_S) old += 1;
  if (old > 0) rows = rows.slice(old);
  now = update.now;
  updates += 1;
  document.body.dataset.updates = updates;
  document.body.dataset.rows = rows.length;
  if (!paused) show();
  schedule();
}

function begin(hello) {
  meta = hello.meta;
  place = Object.fromEntries(meta.columns.map((name, index) => [name, index + 1]));
  byId("place").textContent = `gripd view · ${meta.name}`;
  document.title = `gripd view: ${meta.name}`;
  byId("version").textContent = meta.version;
  rows = [];
  if (plots.length === 0) plots = makePlots();
  take(hello);
}

// News come five times a second. A program that hangs, or a link that is lost, leaves the connection open and silent.
const SILENT_MS = 3000;

function connect() {
  const connection = byId("connection");
  let events = null;
  let heard = 0;
  const answers = (does) => {
    if (does) heard = performance.now();
    connection.textContent = does ? "" : "The program does not answer; trying again.";
    if (gone === !does) return;
    gone = !does;
    if (now) show();
    schedule();
  };
  const open = () => {
    events?.close();
    heard = performance.now();
    events = new EventSource("events");
    events.addEventListener("open", () => answers(true));
    events.addEventListener("hello", (event) => begin(JSON.parse(event.data)));
    events.addEventListener("update", (event) => {
      answers(true);
      if (meta) take(JSON.parse(event.data));
    });
    // The browser tries again by itself.
    events.addEventListener("error", () => answers(false));
  };
  setInterval(() => {
    if (performance.now() - heard < SILENT_MS) return;
    answers(false);
    open();
  }, 1000);
  open();
}

byId("window").addEventListener("change", schedule);
byId("pause").addEventListener("click", () => {
  paused = !paused;
  shownTo = paused ? now?.time ?? null : null;
  byId("pause").setAttribute("aria-pressed", String(paused));
  byId("pause").textContent = paused ? "Go on" : "Pause";
  if (!paused && now) show();
  schedule();
});
addEventListener("resize", schedule);
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  readColors();
  schedule();
});
readColors();
connect();
