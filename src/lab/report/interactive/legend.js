// The legend of a plot: what each line is, and its number at the cursor.

class Legend {
  constructor() {
    this.element = make('ul', { class: 'legend' });
  }

  // A line of the legend; gives the element that a number can be written into.
  add(mark, colourName, name, hasNumber) {
    const sign = make('i', { class: mark, style: `color: var(--${colourName})` });
    const number = make('b');
    this.element.append(make('li', {}, sign, name, ' ', ...(hasNumber ? [number] : [])));
    return number;
  }

  // One of several things drawn as lines; where it comes from stands behind its name, unless that is said elsewhere.
  line(lines, at, hasNumber, isSaid = false) {
    const it = lines[at];
    const word = isSaid || !WORDS[it.source] ? '' : ` (${WORDS[it.source]})`;
    const number = this.add('line', it.color, it.name + word, hasNumber);
    const { width, dash } = lineForm(it.source, placeOfKind(lines, at));
    const sign = this.element.lastChild.firstChild;
    sign.style.height = `${width}px`;
    sign.style.backgroundImage = dashed(dash);
    return number;
  }

  // The colours of a path and what they stand for.
  scale(shade) {
    const ramp = `linear-gradient(to right, ${[-1, -0.5, 0, 0.5, 1].map(shadeColour).join(', ')})`;
    const sign = make('i', { class: 'scale', style: `background: ${ramp}` });
    const most = said(shade.most);
    this.element.append(make('li', {}, `${shade.name}: −${most} `, sign, `+${most}`));
  }
}

// A piece of a line as a background: the same dashes as in the plot.
function dashed(dash) {
  if (!dash.length) return 'linear-gradient(currentColor, currentColor)';
  let end = 0;
  const stops = dash.map((length, place) => {
    const from = end;
    end += length;
    return `${place % 2 ? 'transparent' : 'currentColor'} ${from}px ${end}px`;
  });
  return `repeating-linear-gradient(to right, ${stops.join(', ')})`;
}

// From one side (−1) by nothing (0) to the other (+1).
function shadeColour(share) {
  const [end, weight] = [share < 0 ? 'first' : 'second', Math.round(Math.min(Math.abs(share), 1) * 100)];
  return `color-mix(in srgb, ${colour(end)} ${weight}%, ${colour('muted')})`;
}

// So many colours to either side.
const SHADES = 5;

// They by their number, as they are now.
function shades() {
  const colours = new Map();
  for (let number = -SHADES; number <= SHADES; number += 1) colours.set(number, shadeColour(number / SHADES));
  return colours;
}

// Which of them a point has.
const shadeStep = ({ values, most }, place) => Math.round(Math.max(-1, Math.min(1, (values[place] ?? 0) / most)) * SHADES);
