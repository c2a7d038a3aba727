// Figures along a motion: curves of the joints above the time axis, the nearest pairs over the scene.
// After painter.js.

const PAIRS = { layer: "clearance", colour: [0.84, 0.37, 0] };
const SVG = "http://www.w3.org/2000/svg";

// A joint's figure at its samples; of shares, 1 and -1 are the limits.
const FIGURES = {
  "positions, rad": ({ positions }, j) => positions[j],
  "velocities, rad/s": ({ velocities }, j) => velocities[j],
  "positions, share of limits": ({ positions, limits: [lower, upper] }, j) => {
    const half = (upper[j] - lower[j]) / 2;
    return positions[j].map((q) => lower[j] === null || upper[j] === null ? 0 : (q - lower[j]) / half - 1);
  },
  "velocities, share of limits": ({ velocities, limits }, j) =>
    velocities[j].map((v) => limits[2][j] === null ? 0 : v / limits[2][j]),
};

// Figures at a sample in one line; nothing without any.
function read(told, sample) {
  if (!told) return "";
  const i = Math.min(sample, told.times.length - 1);
  const clear = told.pairs.map((pair) => `${(1000 * pair.distance[i]).toFixed(0)} mm ${pair.bodies[i]}; `);
  return `${clear.join("")}${told.names[told.joint[i]]} at ${(100 * told.share[i]).toFixed(0)} % of its speed; ` +
    `tip ${told.speed[i].toFixed(2)} m/s` + (told.error ? `, ${(1000 * told.error[i]).toFixed(1)} mm off its path` : "");
}

function drawn(kind, parent, attributes) {
  const made = document.createElementNS(SVG, kind);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  parent.append(made);
  return made;
}

class Curves {
  constructor(view) {
    Object.assign(this, { view, rows: [] });
    [this.box, this.choice] = ["curves", "figure"].map((name) => view.element.querySelector(`.${name}`));
    this.svg = drawn("svg", this.box, {
      viewBox: "0 0 1000 100", preserveAspectRatio: "none", role: "img", "aria-label": "curves of the joints over time",
    });
    this.names = document.createElement("p");
    this.box.append(this.names);
    for (const name of Object.keys(FIGURES)) this.choice.append(new Option(name));
    this.choice.hidden = !view.data.readouts && !document.querySelector(".panel");
    this.choice.onchange = () => this.draw();
    const seek = (event) => {
      if (event.type !== "pointerdown" && !event.buttons) return;
      const { left, width } = this.svg.getBoundingClientRect();
      view.play(false);
      view.seek((event.clientX - left) / width * view.duration);
      view.moved();
    };
    this.svg.onpointerdown = this.svg.onpointermove = seek;
  }

  // Draws the chosen figure of all joints; while a new motion is previewed, none.
  draw() {
    const told = this.view.data.readouts, figure = FIGURES[this.choice.value];
    this.box.hidden = !figure || !told;
    if (this.box.hidden) return;
    this.rows = told.names.map((_, j) => figure(told, j));
    const shares = /share/.test(this.choice.value), every = shares ? [-1.1, 1.1] : this.rows.flat();
    const low = Math.min(...every), span = Math.max(...every) - low || 1, last = told.times.at(-1);
    const y = (value) => 100 * (1 - (value - low) / span);
    this.svg.replaceChildren();
    for (const level of shares ? [-1, 0, 1] : low < 0 && low + span > 0 ? [0] : [])
      drawn("line", this.svg, { x1: 0, x2: 1000, y1: y(level), y2: y(level), class: level ? "limit" : "zero" });
    this.rows.forEach((row, j) => {
      const points = row.map((value, i) => `${1000 * told.times[i] / last},${y(value).toFixed(2)}`).join(" ");
      drawn("polyline", this.svg, { points, stroke: this.colour(j) });
    });
    this.line = drawn("line", this.svg, { y1: 0, y2: 100, class: "now" });
    this.names.replaceChildren(...told.names.map((_, j) => {
      return Object.assign(document.createElement("span"), { style: `--own: ${this.colour(j)}` });
    }));
    this.mark();
  }

  colour(j) { return `hsl(${Math.round(360 * j / this.rows.length)} 65% 48%)`; }

  // The present time, and the figures at it.
  mark() {
    const { time, duration, sample, data } = this.view;
    if (this.box.hidden || !data.readouts) return;
    for (const end of ["x1", "x2"]) this.line.setAttribute(end, 1000 * time / duration);
    const i = Math.min(sample, data.readouts.times.length - 1);
    this.rows.forEach((row, j) => {
      this.names.children[j].textContent = `${data.readouts.names[j]} ${row[i].toFixed(2)}`;
    });
  }
}

// Lines from body to body with their lengths, of the sample that is shown.
class Pairs {
  constructor(view) {
    this.view = view;
    this.svg = drawn("svg", view.element.querySelector(".stage"), { class: "pairs", "aria-hidden": true });
    this.marks = [0, 1].map(() => ["line", "text"].map((kind) => drawn(kind, this.svg, {})));
  }

  draw() {
    const { view } = this, told = view.data.readouts;
    const pairs = told && !view.live && !view.hidden.has(PAIRS.layer) ? told.pairs : [];
    this.marks.forEach(([line, text], k) => {
      const points = pairs[k]?.points[Math.min(view.sample, told.times.length - 1)];
      line.style.display = text.style.display = points ? "" : "none";
      if (!points) return;
      const [a, b] = [points.slice(0, 3), points.slice(3)].map((point) => view.onCanvas(point));
      const at = { x1: a[0], y1: a[1], x2: b[0], y2: b[1] };
      for (const [name, value] of Object.entries(at)) line.setAttribute(name, value.toFixed(1));
      text.setAttribute("x", ((a[0] + b[0]) / 2 + 8).toFixed(1));
      text.setAttribute("y", ((a[1] + b[1]) / 2 - 6).toFixed(1));
      text.textContent = `${(1000 * pairs[k].distance[Math.min(view.sample, told.times.length - 1)]).toFixed(0)} mm`;
    });
  }
}
