// Rings over the scene that a pointer or the arrow keys move: the tip, the goal, obstacles, a point of
// the path. After scene.js.

const KEY_STEP = 0.01; // m that an arrow key moves

class Handle {
  // `moved` takes the new place, or with `turned` a rotation vector; `grabbed` and `left` nothing.
  constructor(view, name, kind, { moved, turned, grabbed, left }) {
    Object.assign(this, { view, kind, moved, turned, grabbed, left, place: null, turning: false });
    this.button = document.createElement("button");
    Object.assign(this.button, { className: `handle ${kind}`, title: name, hidden: true });
    this.button.setAttribute("aria-label", `${name}: drag it, or move it by the arrow keys`);
    view.element.querySelector(".stage").append(this.button);
    this.listen();
  }

  get held() { return this.pointer !== undefined; }

  // Shows the ring at a place, unless a pointer has it; nowhere without a place.
  put(place) {
    if (!this.held) this.place = place;
    this.draw();
  }

  draw() {
    this.button.hidden = !this.place;
    if (!this.place) return;
    const [x, y] = this.view.onCanvas(this.place);
    this.button.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px) translate(-50%, -50%)`;
  }

  drop() { this.button.remove(); }

  listen() {
    const button = this.button;
    button.onpointerdown = (e) => {
      e.preventDefault();
      button.focus({ preventScroll: true });
      button.setPointerCapture(e.pointerId);
      Object.assign(this, { pointer: e.pointerId, x: e.x, y: e.y });
      this.grabbed?.();
    };
    button.onpointermove = (e) => {
      if (e.pointerId !== this.pointer) return;
      const dx = e.x - this.x, dy = e.y - this.y;
      Object.assign(this, { x: e.x, y: e.y });
      if (this.turning) this.turn(dx, dy); else this.shift(dx, dy);
    };
    button.onpointerup = button.onpointercancel = (e) => {
      if (e.pointerId !== this.pointer) return;
      this.pointer = undefined;
      this.left?.();
    };
    button.onkeydown = (e) => this.pressed(e);
  }

  // Pixels on the canvas to metres in the plane of the ring that faces the camera.
  shift(dx, dy) {
    const { canvas } = this.view, depth = this.view.onCanvas(this.place)[2];
    const size = depth * Math.tan(FIELD_OF_VIEW / 2) * 2 / canvas.clientHeight;
    this.by(dx * size, -dy * size, 0);
  }

  by(right, up, near) {
    const [x, y] = this.view.axes();
    this.place = along(along(along(this.place, x, right), y, up), cross(x, y), near);
    this.draw();
    this.moved(this.place);
  }

  turn(dx, dy) {
    const [x, y] = this.view.axes();
    this.turned(along(along([0, 0, 0], y, 0.01 * dx), x, 0.01 * dy));
  }

  pressed(event) {
    const s = KEY_STEP, by = {
      ArrowLeft: [-s, 0, 0], ArrowRight: [s, 0, 0], ArrowUp: [0, s, 0], ArrowDown: [0, -s, 0],
      PageUp: [0, 0, -s], PageDown: [0, 0, s],
    }[event.key];
    if (!by) return;
    event.preventDefault();
    this.grabbed?.();
    if (this.turning && !by[2]) this.turn(1000 * by[0], -1000 * by[1]); else this.by(...by);
  }
}
