// Scenes of moving arms on a page, to play and to turn: no library, no network. After vectors.js,
// shaders.js, painter.js and pace.js.

const STILL = 200; // ms without a movement, after which a frame is drawn in full
const TOLD = 100; // ms from one time that is shown beside a playing scene to the next
const STEADY = 4; // px that a click moves at most
const NEAR = 14; // px from the path at which a click is meant for it
const REST = 700; // ms at the end of a motion before it starts anew

async function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  const kinds = { float32: Float32Array, int8: Int8Array, uint32: Uint32Array };
  const arrays = head.arrays.map((a) => new kinds[a.kind](buffer, 4 + length + a.offset, a.count));
  return { ...head, arrays };
}

class SceneView {
  constructor(element, data) {
    Object.assign(this, { element, data, time: 0, sample: 0, playing: true, frames: 0, hidden: new Set() });
    this.links = data.links.map(() => UNMOVED);
    this.canvas = element.querySelector("canvas");
    this.painter = new Painter(this.canvas, data);
    this.pace = begun(this.painter.byProcessor ? BY_PROCESSOR : 0);
    this.pairs = new Pairs(this);
    this.curves = new Curves(this);
    this.controls();
    this.orbit();
    this.home();
    this.watch();
    this.seek(0);
  }

  get duration() { return this.data.times[this.data.times.length - 1]; }

  seek(time) {
    const { times, arrays, links } = this.data, last = times.length - 1;
    this.time = Math.min(Math.max(time, 0), this.duration);
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= this.time) low = middle; else high = middle;
    }
    const span = times[high] - times[low], share = span > 0 ? (this.time - times[low]) / span : 0;
    const poses = arrays[this.data.poses], n = links.length;
    this.sample = share < 0.5 ? low : high;
    this.links = links.map((_, link) => {
      const a = 7 * (low * n + link), b = 7 * (high * n + link), mixed = [];
      for (let k = 0; k < 7; k++) mixed.push((1 - share) * poses[a + k] + share * poses[b + k]);
      const length = Math.hypot(...mixed.slice(3));
      return posed(mixed.slice(0, 3), mixed.slice(3).map((x) => x / length));
    });
    if (!this.playing || performance.now() - this.toldAt > TOLD) this.tell();
    this.changed();
  }

  tell() {
    this.toldAt = performance.now();
    this.slider.value = this.time;
    this.clock.textContent = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    this.element.querySelector(".reading").textContent = read(this.data.readouts, this.sample);
    this.curves.mark();
  }

  play(on) {
    this.playing = on && this.duration > 0;
    this.button.textContent = this.playing ? "❚❚" : "▶";
    this.button.setAttribute("aria-label", this.playing ? "pause" : "play");
    this.last = undefined;
    this.tell();
    this.changed();
  }

  // Draws anew when the page has another size or other colours, and nothing while out of sight.
  watch() {
    new ResizeObserver(() => this.changed()).observe(this.canvas);
    matchMedia("(prefers-color-scheme: dark)").onchange = () => { this.painter.recolour(); this.changed(); };
    new IntersectionObserver((entries) => {
      this.unseen = !entries.at(-1).isIntersecting;
      this.next();
    }).observe(this.element);
  }

  // There is something else to draw.
  changed() {
    this.stale = true;
    this.next();
  }

  // Something is moved by hand.
  moved() {
    this.movedAt = performance.now();
    this.changed();
  }

  next() {
    if (!this.waiting) this.waiting = requestAnimationFrame((now) => this.tick(now));
  }

  tick(now) {
    this.waiting = 0;
    const moves = !this.unseen && (this.playing || now - this.movedAt < STILL);
    if (!moves) this.last = undefined;
    if (moves && this.playing) this.advance(now);
    // Only from one frame to the very next: in between, nothing is waited for.
    if (moves && this.drawnAt !== undefined) this.pace = paced(this.pace, now - this.drawnAt);
    this.drawnAt = undefined;
    if (!this.unseen && (this.stale || this.coarse && !moves)) {
      this.draw(moves ? this.pace.way : 0);
      if (moves) this.drawnAt = now;
    }
    if (moves) this.next();
  }

  advance(now) {
    const passed = this.last === undefined ? 0 : now - this.last;
    this.last = now;
    if (now < this.restsTo) return;
    this.seek(this.time >= this.duration ? 0 : this.time + passed / 1000 * this.speed);
    if (this.time >= this.duration) this.restsTo = now + REST;
  }

  draw(way) {
    const { target, distance, links, hidden } = this;
    this.painter.draw(WAYS[way], { eye: this.eye(), target, distance }, links, hidden);
    this.pairs.draw();
    Object.assign(this, { stale: false, coarse: way > 0 });
    this.frames += 1;
  }

  controls() {
    const find = (name) => this.element.querySelector(`.${name}`);
    [this.button, this.slider, this.clock] = ["play", "time", "clock"].map(find);
    this.speed = 1;
    this.slider.max = this.duration;
    this.button.onclick = () => this.play(!this.playing);
    this.slider.oninput = () => { const at = +this.slider.value; this.play(false); this.seek(at); this.moved(); };
    find("speed").onchange = (event) => { this.speed = +event.target.value; };
    find("home").onclick = () => { this.home(); this.changed(); };
    this.boxes = find("layers");
    this.list(this.data.items);
    this.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    this.keys();
  }

  // Boxes that show and hide the layers of these surfaces, where there is none yet.
  list(items) {
    const known = [...this.boxes.querySelectorAll("input")].map((box) => box.name);
    const told = this.data.readouts?.pairs.length ? [PAIRS] : [];
    const layers = new Map([...items, ...told].map((item) => [item.layer, item]));
    for (const [layer, item] of layers) {
      if (known.includes(layer)) continue;
      const label = document.createElement("label"), box = document.createElement("input");
      const swatch = document.createElement("i");
      Object.assign(box, { type: "checkbox", checked: true, name: layer });
      swatch.style.background = `rgb(${item.colour.map((c) => Math.round(255 * c))})`;
      box.onchange = () => {
        this.hidden[box.checked ? "delete" : "add"](layer);
        this.changed();
      };
      label.append(box, swatch, layer);
      this.boxes.append(label);
    }
  }

  keys() {
    const turn = (dx, dy) => () => this.turn(dx, dy), zoom = (f) => () => { this.distance *= f; };
    const by = {
      ArrowLeft: turn(-12, 0), ArrowRight: turn(12, 0), ArrowUp: turn(0, 12), ArrowDown: turn(0, -12),
      "+": zoom(0.9), "=": zoom(0.9), "-": zoom(1 / 0.9), " ": () => this.play(!this.playing),
      Home: () => this.home(),
    };
    const pressed = (event) => {
      if (!by[event.key] || event.ctrlKey || event.metaKey || event.defaultPrevented) return;
      event.preventDefault();
      by[event.key]();
      this.moved();
    };
    this.canvas.onkeydown = pressed;
    // A page with nothing but the scene takes keys from wherever the focus is not in a control.
    if (document.body.className === "whole")
      document.onkeydown = (event) => { if (event.target === document.body) pressed(event); };
  }

  turn(dx, dy) {
    this.azimuth -= 0.008 * dx;
    this.elevation = Math.min(Math.max(this.elevation + 0.008 * dy, -0.2), 1.55);
  }

  home() {
    const { centre, radius } = this.data, shape = this.canvas.clientWidth / this.canvas.clientHeight;
    // A little lower than the middle: the bar with the time lies over the bottom.
    const target = along(centre, [0, 0, 1], -0.1 * radius);
    const distance = 0.98 * radius / Math.sin(FIELD_OF_VIEW / 2) / Math.min(shape || 1, 1);
    Object.assign(this, { azimuth: -0.85, elevation: 0.42, target, distance });
  }

  orbit() {
    const held = new Map(), canvas = this.canvas;
    const apart = () => { const [a, b] = [...held.values()]; return Math.hypot(a.x - b.x, a.y - b.y); };
    let first = null;
    canvas.onpointerdown = (e) => {
      canvas.setPointerCapture(e.pointerId);
      held.set(e.pointerId, e);
      first = e;
    };
    canvas.onpointercancel = (e) => held.delete(e.pointerId);
    canvas.onpointerup = (e) => {
      held.delete(e.pointerId);
      if (Math.hypot(e.x - first.x, e.y - first.y) < STEADY) this.pick(e.offsetX, e.offsetY);
    };
    canvas.oncontextmenu = (e) => e.preventDefault();
    canvas.onpointermove = (e) => {
      const before = held.get(e.pointerId);
      if (!before) return;
      const dx = e.x - before.x, dy = e.y - before.y, gap = held.size === 2 && apart();
      held.set(e.pointerId, e);
      if (gap) this.distance *= gap / apart();
      else if (e.buttons & 2 || e.shiftKey) this.pan(dx, dy);
      else this.turn(dx, dy);
      this.moved();
    };
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.distance *= Math.exp(0.001 * e.deltaY);
      this.moved();
    }, { passive: false });
  }

  // Goes to the time at which the tip passes next to a point of the canvas.
  pick(x, y) {
    const time = this.timeAt(x, y);
    if (time === null) return;
    this.play(false);
    this.seek(time);
    this.moved();
  }

  // The time at which the tip is seen nearest to a point of the canvas; null if it never is there.
  timeAt(x, y) {
    const { tip, times, arrays, poses, links } = this.data;
    if (tip === null || times.length < 2) return null;
    let nearest = NEAR, found = null;
    times.forEach((time, i) => {
      const k = 7 * (i * links.length + tip), seen = this.onCanvas([...arrays[poses].subarray(k, k + 3)]);
      const apart = Math.hypot(seen[0] - x, seen[1] - y);
      if (apart < nearest) [nearest, found] = [apart, time];
    });
    return found;
  }

  // Pixels of a point of the scene on the canvas, and its distance along the view.
  onCanvas(point) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { target, distance } = this, seen = this.painter.seen({ eye: this.eye(), target, distance }, [width, height]);
    const [x, y, , w] = transformed(seen.view, point);
    return [0.5 * width * (1 + x / w), 0.5 * height * (1 - y / w), w];
  }

  // Directions of the canvas in the scene: right and up.
  axes() {
    const z = normalise(sub(this.eye(), this.target)), x = normalise(cross([0, 0, 1], z));
    return [x, cross(z, x)];
  }

  pan(dx, dy) {
    const size = this.distance * Math.tan(FIELD_OF_VIEW / 2) * 2 / this.canvas.clientHeight;
    const [x, y] = this.axes();
    this.target = along(along(this.target, x, -dx * size), y, dy * size);
  }

  eye() {
    const c = Math.cos(this.elevation);
    const toward = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    return along(this.target, toward, this.distance);
  }
}

// Scenes start when they come into sight: a browser keeps few of them at a time.
window.leadthrough = { scenes: [], View: SceneView };
for (const element of document.querySelectorAll("figure.scene")) {
  const start = async () => {
    const data = await unpacked(element.querySelector("script").textContent.trim());
    window.leadthrough.scenes.push(new window.leadthrough.View(element, data));
  };
  const failed = (error) => { element.querySelector(".trouble").textContent = error.message; };
  const watch = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) { watch.disconnect(); start().catch(failed); }
  });
  watch.observe(element);
}
