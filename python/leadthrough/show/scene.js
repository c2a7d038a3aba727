// Draws scenes of moving arms with WebGL 2: no library, no network. After shaders.js.

const FIELD_OF_VIEW = 0.6; // rad
const LIGHT = normalise([0.45, -0.35, 1.0]);

// Vectors, and matrices by columns.
function sub(a, b) { return [a[0] - b[0], a[1] - b[1], a[2] - b[2]]; }
function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
function along(a, d, t) { return [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]]; }
function normalise(a) { return along([0, 0, 0], a, 1 / Math.hypot(...a)); }

function product(a, b) {
  const out = new Float32Array(16);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++)
      for (let k = 0; k < 4; k++) out[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return out;
}

function looking(eye, target, up) {
  const z = normalise(sub(eye, target)), x = normalise(cross(up, z)), y = cross(z, x);
  return new Float32Array([
    x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0,
    -dot(x, eye), -dot(y, eye), -dot(z, eye), 1,
  ]);
}

function perspective(aspect, near, far) {
  const f = 1 / Math.tan(FIELD_OF_VIEW / 2);
  return new Float32Array([
    f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (near + far) / (near - far), -1,
    0, 0, 2 * near * far / (near - far), 0,
  ]);
}

function orthographic(reach, depth) {
  return new Float32Array([1 / reach, 0, 0, 0, 0, 1 / reach, 0, 0, 0, 0, -1 / depth, 0, 0, 0, 0, 1]);
}

function posed(p, q) {
  const [w, x, y, z] = q;
  return new Float32Array([
    1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y), 0,
    2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x), 0,
    2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y), 0,
    p[0], p[1], p[2], 1,
  ]);
}

const UNMOVED = posed([0, 0, 0], [1, 0, 0, 0]);

function shader(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const part = gl.createShader(kind);
    gl.shaderSource(part, text);
    gl.compileShader(part);
    gl.attachShader(program, part);
    if (!gl.getShaderParameter(part, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(part));
  }
  gl.linkProgram(program);
  const at = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(program, i).name;
    at[name] = gl.getUniformLocation(program, name);
  }
  return { program, at };
}

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
    Object.assign(this, { element, data, time: 0, playing: true, frames: 0, hidden: new Set() });
    this.links = data.links.map(() => UNMOVED);
    this.canvas = element.querySelector("canvas");
    this.start();
    this.controls();
    this.orbit();
    this.home();
    new ResizeObserver(() => this.changed()).observe(this.canvas);
    this.seek(0);
  }

  start() {
    const gl = this.gl = this.canvas.getContext("webgl2", { antialias: false, alpha: true });
    if (!gl) throw new Error("this browser shows no WebGL 2");
    const told = gl.getExtension("WEBGL_debug_renderer_info");
    const renderer = gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    this.way = BY_PROCESSOR.test(renderer) ? WAYS.length - 2 : 0;
    this.surface = shader(gl, SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.ground = shader(gl, SURFACE_VERTEX, GROUND_FRAGMENT);
    this.depth = shader(gl, SURFACE_VERTEX, DEPTH_FRAGMENT);
    this.items = this.data.items.map((item) => ({ ...item, ...this.upload(
      ...["vertices", "normals", "faces"].map((name) => this.data.arrays[item[name]])) }));
    this.items.sort((a, b) => b.opacity - a.opacity);
    const r = 2.2 * this.data.radius, z = this.data.floor;
    this.floor = { reach: r, link: -1, ...this.upload(
      new Float32Array([-r, -r, z, r, -r, z, r, r, z, -r, r, z]),
      new Int8Array([0, 0, 127, 0, 0, 127, 0, 0, 127, 0, 0, 127]), new Uint32Array([0, 1, 2, 0, 2, 3])) };
    this.map = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.map);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    this.frame = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.map, 0);
    gl.drawBuffers([gl.NONE]);
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  upload(vertices, normals, faces) {
    const gl = this.gl, array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const [place, data, kind] of [[0, vertices, gl.FLOAT], [1, normals, gl.BYTE]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, kind, kind === gl.BYTE, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    return { array, count: faces.length };
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
    this.links = links.map((_, link) => {
      const a = 7 * (low * n + link), b = 7 * (high * n + link), mixed = [];
      for (let k = 0; k < 7; k++) mixed.push((1 - share) * poses[a + k] + share * poses[b + k]);
      const length = Math.hypot(...mixed.slice(3));
      return posed(mixed.slice(0, 3), mixed.slice(3).map((x) => x / length));
    });
    this.slider.value = this.time;
    this.clock.textContent = `${this.time.toFixed(2)} / ${this.duration.toFixed(2)} s`;
    this.changed();
  }

  play(on) {
    this.playing = on && this.duration > 0;
    this.button.textContent = this.playing ? "❚❚" : "▶";
    this.button.setAttribute("aria-label", this.playing ? "pause" : "play");
    this.last = undefined;
    this.changed();
  }

  changed() {
    if (!this.waiting) this.waiting = requestAnimationFrame((now) => this.tick(now));
  }

  // Something moves: by hand now, or all the time.
  moved() {
    this.movedAt = performance.now();
    clearTimeout(this.refining);
    this.refining = setTimeout(() => this.changed(), STILL);
    this.changed();
  }

  // Takes another way of drawing where frames come slowly; back again if that was no help.
  adapt(interval) {
    if (this.settled || !(interval < 5000)) return;
    this.pace = this.pace === undefined ? interval : 0.7 * this.pace + 0.3 * interval;
    this.counted = (this.counted || 0) + 1;
    if (this.counted < (this.pace > 100 ? 3 : 12)) return;
    const helped = this.slower === undefined || this.pace < 0.9 * this.slower;
    if (!helped) this.way -= 1;
    this.settled = !helped || this.pace < SLOW || this.way === WAYS.length - 1;
    if (!this.settled) this.way += 1;
    [this.slower, this.pace, this.counted] = [this.pace, undefined, 0];
  }

  tick(now) {
    this.waiting = 0;
    const moves = this.playing || now - this.movedAt < STILL;
    if (this.playing) {
      if (this.last !== undefined && this.last < now) this.adapt(now - this.last);
      const step = this.last === undefined ? 0 : (now - this.last) / 1000 * this.speed;
      this.last = now;
      this.seek(this.time >= this.duration ? 0 : this.time + step);
      if (this.time >= this.duration) this.last = now + 700; // rest at the end before it starts anew
    }
    this.draw(WAYS[moves ? this.way : 0]);
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
    const layers = new Map();
    for (const item of this.data.items) if (!layers.has(item.layer)) layers.set(item.layer, item);
    for (const [layer, item] of layers) {
      const label = document.createElement("label"), box = document.createElement("input");
      const swatch = document.createElement("i");
      Object.assign(box, { type: "checkbox", checked: true, name: layer });
      swatch.style.background = `rgb(${item.colour.map((c) => Math.round(255 * c))})`;
      box.onchange = () => {
        this.hidden[box.checked ? "delete" : "add"](layer);
        this.changed();
      };
      label.append(box, swatch, layer);
      find("layers").append(label);
    }
    this.play(!matchMedia("(prefers-reduced-motion: reduce)").matches);
    this.keys();
  }

  keys() {
    const turn = (dx, dy) => () => this.turn(dx, dy), zoom = (f) => () => { this.distance *= f; };
    const by = {
      ArrowLeft: turn(-12, 0), ArrowRight: turn(12, 0), ArrowUp: turn(0, 12), ArrowDown: turn(0, -12),
      "+": zoom(0.9), "=": zoom(0.9), "-": zoom(1 / 0.9), " ": () => this.play(!this.playing),
    };
    this.canvas.onkeydown = (event) => {
      if (!by[event.key] || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      by[event.key]();
      this.moved();
    };
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
    canvas.onpointerdown = (e) => { canvas.setPointerCapture(e.pointerId); held.set(e.pointerId, e); };
    canvas.onpointerup = canvas.onpointercancel = (e) => held.delete(e.pointerId);
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

  pan(dx, dy) {
    const size = this.distance * Math.tan(FIELD_OF_VIEW / 2) * 2 / this.canvas.clientHeight;
    const z = normalise(sub(this.eye(), this.target)), x = normalise(cross([0, 0, 1], z));
    this.target = along(along(this.target, x, -dx * size), cross(z, x), dy * size);
  }

  eye() {
    const c = Math.cos(this.elevation);
    const toward = [c * Math.cos(this.azimuth), c * Math.sin(this.azimuth), Math.sin(this.elevation)];
    return along(this.target, toward, this.distance);
  }

  draw(way) {
    const { gl, canvas, data } = this, ratio = Math.min(window.devicePixelRatio || 1, way.ratio);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.round(ratio * x));
    if (!width || !height) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const r = data.radius, eye = this.eye(), sunAt = along(data.centre, LIGHT, 2 * r);
    const light = product(orthographic(1.6 * r, 4 * r), looking(sunAt, data.centre, [0, 1, 0]));
    const lens = perspective(width / height, 0.02 * this.distance, this.distance + 6 * r);
    const view = product(lens, looking(eye, this.target, [0, 0, 1]));
    const shown = this.items.filter((item) => !this.hidden.has(item.layer));

    gl.bindTexture(gl.TEXTURE_2D, null);
    if (way.blur >= 0) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
      gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
      gl.clear(gl.DEPTH_BUFFER_BIT);
      this.paint(this.depth, shown.filter((item) => item.opacity > 0.5), { view: light, light });
    }

    const many = way.samples > 1 ? this.sampled(width, height, way.samples) : null;
    gl.bindFramebuffer(gl.FRAMEBUFFER, many);
    gl.bindTexture(gl.TEXTURE_2D, this.map);
    gl.viewport(0, 0, width, height);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const where = { view, light, eye, sun: LIGHT, blur: way.blur };
    this.paint(this.surface, shown.filter((item) => item.opacity === 1), where);
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    if (eye[2] > data.floor) this.paint(this.ground, [this.floor], where);
    gl.depthMask(true);
    gl.enable(gl.CULL_FACE);
    this.paint(this.surface, shown.filter((item) => item.opacity < 1), where);
    gl.disable(gl.CULL_FACE);
    gl.disable(gl.BLEND);
    if (many) {
      gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
      gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    }
    this.frames += 1;
  }

  // A frame buffer with several samples for each pixel.
  sampled(width, height, samples) {
    const gl = this.gl;
    if (!this.samples) {
      this.samples = { buffer: gl.createFramebuffer(), of: [gl.createRenderbuffer(), gl.createRenderbuffer()] };
    }
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.samples.buffer);
    const most = Math.min(samples, gl.getParameter(gl.MAX_SAMPLES));
    const formats = [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]];
    if (this.samples.width !== width || this.samples.height !== height)
      formats.forEach(([format, attachment], i) => {
        gl.bindRenderbuffer(gl.RENDERBUFFER, this.samples.of[i]);
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, most, format, width, height);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, this.samples.of[i]);
      });
    Object.assign(this.samples, { width, height });
    return this.samples.buffer;
  }

  paint({ program, at }, items, { view, light, eye, sun, blur }) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.view, false, view);
    gl.uniformMatrix4fv(at.light, false, light);
    if (at.eye) gl.uniform3fv(at.eye, eye);
    if (at.sun) gl.uniform3fv(at.sun, sun);
    if (at.blur) gl.uniform1i(at.blur, blur);
    for (const item of items) {
      const moved = item.link >= 0 ? this.links[item.link] : UNMOVED;
      gl.uniformMatrix4fv(at.model, false, moved);
      gl.polygonOffset(0, 60 * (item.link % 3)); // where links share a face one of them wins
      if (at.colour) gl.uniform3fv(at.colour, item.colour);
      if (at.opacity) gl.uniform1f(at.opacity, item.opacity);
      if (at.reach) gl.uniform1f(at.reach, item.reach);
      gl.bindVertexArray(item.array);
      gl.drawElements(gl.TRIANGLES, item.count, gl.UNSIGNED_INT, 0);
    }
  }
}

// Scenes start when they come into sight: a browser keeps few of them at a time.
window.leadthrough = { scenes: [] };
for (const element of document.querySelectorAll("figure.scene")) {
  const start = async () => {
    const data = await unpacked(element.querySelector("script").textContent.trim());
    window.leadthrough.scenes.push(new SceneView(element, data));
  };
  const failed = (error) => { element.querySelector(".trouble").textContent = error.message; };
  const watch = new IntersectionObserver((entries) => {
    if (entries.some((entry) => entry.isIntersecting)) { watch.disconnect(); start().catch(failed); }
  });
  watch.observe(element);
}
