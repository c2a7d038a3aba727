// Draws surfaces with WebGL 2: sky, ground and shadow, and what moves over what rests.

const LIGHT = normalise([0.45, -0.35, 1.0]);

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

// Red, green and blue of "#dfe7ef", in [0, 1].
function colourOf(text) {
  return [1, 3, 5].map((i) => parseInt(text.trim().slice(i, i + 2), 16) / 255);
}

// A colour as amounts of light.
function linear(colour) { return colour.map((part) => part ** 2.2); }

class Painter {
  constructor(canvas, data) {
    Object.assign(this, { canvas, data, resting: "" });
    // Opaque: without a graphics card it takes a browser 10 ms to mix a canvas with what is below.
    const gl = this.gl = canvas.getContext("webgl2", { antialias: false, alpha: false });
    if (!gl) throw new Error("this browser shows no WebGL 2");
    this.sky = shader(gl, WHOLE_VERTEX, SKY_FRAGMENT);
    this.kept = shader(gl, WHOLE_VERTEX, KEPT_FRAGMENT);
    this.surface = shader(gl, SURFACE_VERTEX, SURFACE_FRAGMENT);
    this.ground = shader(gl, SURFACE_VERTEX, GROUND_FRAGMENT);
    this.depth = shader(gl, SURFACE_VERTEX, DEPTH_FRAGMENT);
    this.items = [];
    this.replace([], data);
    const r = 2.2 * data.radius, z = data.floor;
    this.floor = { reach: r, link: -1, ...this.upload(
      new Float32Array([-r, -r, z, r, -r, z, r, r, z, -r, r, z]),
      new Int8Array([0, 0, 127, 0, 0, 127, 0, 0, 127, 0, 0, 127]), new Uint32Array([0, 1, 2, 0, 2, 3])) };
    this.nothing = gl.createVertexArray();
    this.shadow();
    this.recolour();
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.blendFuncSeparate(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA, gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  }

  // Draws other surfaces in these layers.
  replace(layers, { items, arrays }) {
    const gl = this.gl, gone = this.items.filter((item) => layers.includes(item.layer));
    for (const { array, buffers } of gone) {
      gl.deleteVertexArray(array);
      buffers.forEach((buffer) => gl.deleteBuffer(buffer));
    }
    const added = items.map((item) => ({ ...item, colour: linear(item.colour), ...this.upload(
      ...["vertices", "normals", "faces"].map((name) => arrays[item[name]])) }));
    this.items = this.items.filter((item) => !gone.includes(item)).concat(added);
    this.items.sort((a, b) => b.opacity - a.opacity);
    this.resting = "";
  }

  // Whether frames are drawn by the processor, without a graphics card.
  get byProcessor() {
    const gl = this.gl, told = gl.getExtension("WEBGL_debug_renderer_info");
    const name = gl.getParameter(told ? told.UNMASKED_RENDERER_WEBGL : gl.RENDERER);
    return /swiftshader|llvmpipe|softpipe|basic render|software/i.test(name);
  }

  // Takes the colours of the sky from the page, light or dark.
  recolour() {
    const style = getComputedStyle(this.canvas);
    this.colours = ["--zenith", "--horizon"].map((name) => colourOf(style.getPropertyValue(name)));
    this.resting = "";
  }

  shadow() {
    const gl = this.gl;
    this.map = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, this.map);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.DEPTH_COMPONENT24, SHADOW_SIZE, SHADOW_SIZE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_COMPARE_MODE, gl.COMPARE_REF_TO_TEXTURE);
    for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
      gl.texParameteri(gl.TEXTURE_2D, filter, gl.LINEAR);
    this.cast = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.cast);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.DEPTH_ATTACHMENT, gl.TEXTURE_2D, this.map, 0);
    gl.drawBuffers([gl.NONE]);
  }

  upload(vertices, normals, faces) {
    const gl = this.gl, array = gl.createVertexArray();
    const buffers = [0, 1, 2].map(() => gl.createBuffer());
    gl.bindVertexArray(array);
    for (const [place, data, kind] of [[0, vertices, gl.FLOAT], [1, normals, gl.BYTE]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[place]);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(place);
      gl.vertexAttribPointer(place, 3, kind, kind === gl.BYTE, 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers[2]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, faces, gl.STATIC_DRAW);
    return { array, buffers, count: faces.length };
  }

  // Draws a frame in one of the WAYS; `links` are the poses of the links, `hidden` layers.
  draw(way, camera, links, hidden) {
    const size = this.resized(way.ratio), gl = this.gl;
    if (!size) return;
    const where = { ...this.seen(camera, size), links, blur: way.blur };
    const shown = this.items.filter((item) => !hidden.has(item.layer));
    const opaque = shown.filter((item) => item.opacity === 1);
    const resting = opaque.filter((item) => item.link < 0);
    const fine = way.samples > 1 ? this.samples(size, way.samples) : null;
    if (way.blur >= 0) this.darken(shown, { ...where, view: where.light });
    if (way.blur >= 0) this.rest(fine, size, resting, where);
    else this.keep(size, resting, where, [...hidden].join());
    this.paint(this.surface, opaque.filter((item) => item.link >= 0), where);
    gl.enable(gl.CULL_FACE);
    this.mixed(this.surface, shown.filter((item) => item.opacity < 1), where, true);
    gl.disable(gl.CULL_FACE);
    if (fine) this.resolve(fine, size);
  }

  // What the camera and the light see.
  seen({ eye, target, distance }, [width, height]) {
    const { centre, radius: r } = this.data, sun = along(centre, LIGHT, 2 * r);
    const light = product(orthographic(1.6 * r, 4 * r), looking(sun, centre, [0, 1, 0]));
    const lens = perspective(width / height, 0.02 * distance, distance + 6 * r);
    return { eye, light, view: product(lens, looking(eye, target, [0, 0, 1])), sun: LIGHT };
  }

  // Gives the canvas so many pixels for one of the page.
  resized(most) {
    const { canvas } = this, ratio = Math.min(window.devicePixelRatio || 1, most);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((x) => Math.round(ratio * x));
    if (!width || !height) return null;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    return [width, height];
  }

  // The depths that the light sees.
  darken(items, where) {
    const gl = this.gl;
    gl.bindTexture(gl.TEXTURE_2D, null);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.cast);
    gl.viewport(0, 0, SHADOW_SIZE, SHADOW_SIZE);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.DEPTH_BUFFER_BIT);
    this.paint(this.depth, items.filter((item) => item.opacity > 0.5), where);
    gl.bindTexture(gl.TEXTURE_2D, this.map);
  }

  // Draws what rests into a frame buffer.
  rest(buffer, size, items, where) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.viewport(0, 0, ...size);
    this.backdrop();
    this.paint(this.surface, items, where);
    if (where.eye[2] > this.data.floor) this.mixed(this.ground, [this.floor], where, false);
  }

  // The same where there is no moving shadow: it is drawn only when the camera has moved.
  keep(size, items, where, hidden) {
    const seen = [...where.view, ...size, hidden].join();
    const still = this.still(size);
    if (seen !== this.resting) this.rest(still, size, items, where);
    this.resting = seen;
    this.restore();
  }

  backdrop() {
    const gl = this.gl, { program, at } = this.sky;
    gl.disable(gl.DEPTH_TEST);
    gl.useProgram(program);
    gl.uniform3fv(at.zenith, this.colours[0]);
    gl.uniform3fv(at.horizon, this.colours[1]);
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.enable(gl.DEPTH_TEST);
    gl.clear(gl.DEPTH_BUFFER_BIT);
  }

  // Paints what mixes with what is behind it, and hides what is drawn later behind it or does not.
  mixed(program, items, where, hides) {
    const gl = this.gl;
    gl.enable(gl.BLEND);
    gl.depthMask(hides);
    this.paint(program, items, where);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
  }

  // Puts the mean of a pixel's samples on the canvas.
  resolve(fine, size) {
    const gl = this.gl, [width, height] = size;
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.still(size));
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, fine);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
    this.resting = "";
    this.restore();
  }

  // Copies colours and depths that were kept onto the canvas.
  restore() {
    const gl = this.gl, { program, at } = this.kept;
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    gl.useProgram(program);
    gl.uniform1i(at.colours, 1);
    gl.uniform1i(at.depths, 2);
    gl.depthFunc(gl.ALWAYS);
    gl.bindVertexArray(this.nothing);
    gl.drawArrays(gl.TRIANGLES, 0, 3);
    gl.depthFunc(gl.LESS);
  }

  // A frame buffer with several samples for each pixel.
  samples(size, samples) {
    const gl = this.gl, fine = this.fine ||= { buffer: gl.createFramebuffer(), parts: [] };
    gl.bindFramebuffer(gl.FRAMEBUFFER, fine.buffer);
    const most = Math.min(samples, gl.getParameter(gl.MAX_SAMPLES));
    const formats = [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]];
    if (`${fine.size}` !== `${size}`)
      formats.forEach(([format, attachment], i) => {
        fine.parts[i] ||= gl.createRenderbuffer();
        gl.bindRenderbuffer(gl.RENDERBUFFER, fine.parts[i]);
        gl.renderbufferStorageMultisample(gl.RENDERBUFFER, most, format, ...size);
        gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, fine.parts[i]);
      });
    fine.size = size;
    return fine.buffer;
  }

  // A frame buffer whose colours and depths can be read: texture units 1 and 2.
  still(size) {
    const gl = this.gl, kept = this.image ||= { buffer: gl.createFramebuffer(), parts: [] };
    if (`${kept.size}` === `${size}`) return kept.buffer;
    gl.bindFramebuffer(gl.FRAMEBUFFER, kept.buffer);
    const formats = [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]];
    formats.forEach(([format, attachment], i) => {
      gl.deleteTexture(kept.parts[i] || null);
      kept.parts[i] = gl.createTexture();
      gl.activeTexture(gl.TEXTURE1 + i);
      gl.bindTexture(gl.TEXTURE_2D, kept.parts[i]);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, ...size);
      for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
        gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, attachment, gl.TEXTURE_2D, kept.parts[i], 0);
    });
    gl.activeTexture(gl.TEXTURE0);
    kept.size = size;
    return kept.buffer;
  }

  paint({ program, at }, items, { view, light, eye, sun, blur, links }) {
    const gl = this.gl;
    gl.useProgram(program);
    gl.uniformMatrix4fv(at.view, false, view);
    gl.uniformMatrix4fv(at.light, false, light);
    if (at.eye) gl.uniform3fv(at.eye, eye);
    if (at.sun) gl.uniform3fv(at.sun, sun);
    if (at.blur) gl.uniform1i(at.blur, blur);
    for (const item of items) {
      gl.uniformMatrix4fv(at.model, false, item.link >= 0 ? links[item.link] : UNMOVED);
      gl.polygonOffset(0, 60 * (item.link % 3)); // where links share a face one of them wins
      if (at.colour) gl.uniform3fv(at.colour, item.colour);
      if (at.opacity) gl.uniform1f(at.opacity, item.opacity);
      if (at.reach) gl.uniform1f(at.reach, item.reach);
      gl.bindVertexArray(item.array);
      gl.drawElements(gl.TRIANGLES, item.count, gl.UNSIGNED_INT, 0);
    }
  }
}
