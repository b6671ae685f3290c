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

  // A line for something drawn as a line; where it comes from stands behind its name, unless that is said elsewhere.
  line(it, hasNumber, isSaid = false) {
    const word = isSaid || !WORDS[it.source] ? '' : ` (${WORDS[it.source]})`;
    return this.add(LINES[it.source].mark, it.color, it.name + word, hasNumber);
  }

  // The colours of a path and what they stand for.
  scale(shade) {
    const ramp = `linear-gradient(to right, ${[-1, -0.5, 0, 0.5, 1].map(shadeColour).join(', ')})`;
    const sign = make('i', { class: 'scale', style: `background: ${ramp}` });
    const most = said(shade.most);
    this.element.append(make('li', {}, `${shade.name}: −${most} `, sign, `+${most}`));
  }
}

// From one side (−1) by nothing (0) to the other (+1).
function shadeColour(share) {
  const [end, weight] = [share < 0 ? 'first' : 'second', Math.round(Math.min(Math.abs(share), 1) * 100)];
  return `color-mix(in srgb, ${colour(end)} ${weight}%, ${colour('muted')})`;
}
