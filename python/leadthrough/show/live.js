// A live page: what is dragged goes to the server, which answers with surfaces, a motion and the state
// of all. After handles.js.

const AGAIN = 1000; // ms after which a lost server is called again

class LiveView extends SceneView {
  constructor(element, data) {
    super(element, data);
    this.panel = document.querySelector(".panel");
    this.state = { obstacles: [] };
    this.obstacles = [];
    this.sliders = [];
    this.ends = ["start", "goal"].map((name) => this.ring(name[0].toUpperCase() + name.slice(1), name, { do: name }));
    this.point = new Handle(this, "Point of the path", "point", {
      grabbed: () => { this.play(false); this.held = this.time; },
      moved: (position) => this.send({ do: "correct", time: this.held, position }),
    });
    this.find("undo").onclick = () => this.send({ do: "undo" });
    this.find("turning").onclick = () => this.turning();
    this.call();
  }

  find(name) { return this.panel.querySelector(`.${name}`); }

  // A ring that moves something, or turns it.
  ring(name, kind, message) {
    return new Handle(this, name, kind, {
      moved: (position) => this.send({ ...message, position }),
      turned: (vector) => this.send({ ...message, vector }),
    });
  }

  get turned() { return [...this.ends, ...this.obstacles]; }

  turning() {
    const on = this.find("turning").getAttribute("aria-pressed") === "false";
    this.find("turning").setAttribute("aria-pressed", on);
    for (const ring of this.turned) ring.turning = on;
  }

  // ---- the server

  call() {
    this.socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[?#].*$/, "") + "live");
    this.socket.onmessage = (event) => this.hear(JSON.parse(event.data));
    this.socket.onclose = () => {
      this.find("told").textContent = "The connection is lost; is leadthrough still running?";
      setTimeout(() => this.call(), AGAIN);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  hear(message) {
    // Surfaces are unpacked meanwhile: those that come later wait for those before.
    if (message.kind === "scene")
      this.before = (this.before || Promise.resolve()).then(() => this.redraw(message));
    else this.update(message);
  }

  async redraw({ data, moves }) {
    const scene = await unpacked(data), { layers, times, poses, arrays, readouts } = scene;
    const share = this.duration ? this.time / this.duration : 0;
    this.painter.replace(layers, scene);
    if (readouts || moves) this.data.readouts = readouts;
    this.list(scene.items);
    if (moves) {
      Object.assign(this.data, { times, poses, arrays });
      this.slider.max = this.duration;
      this.show(share);
    }
    this.curves.draw();
    this.changed();
  }

  // Shows the motion that has come, from a share of its duration on.
  show(share) {
    const playing = this.playing;
    this.seek(share * this.duration);
    this.play(playing);
  }

  // ---- the rings and the panel

  draw(way) {
    super.draw(way);
    if (!this.panel) return;
    const place = [...this.links[this.data.tip ?? this.links.length - 1].slice(12, 15)];
    this.ends.forEach((ring) => ring.put(this.state[ring.kind]));
    this.point.put(this.correctable ? place : null);
    this.obstacles.forEach((ring, i) => ring.put(this.state.obstacles[i]));
    return place;
  }

  get correctable() { return this.state.learned && this.duration > 0; }

  update(state) {
    this.state = state;
    this.find("told").textContent = state.text;
    this.find("undo").disabled = !state.corrections;
    this.find("undo").parentElement.hidden = !state.learned && !state.demonstrations;
    while (this.obstacles.length > state.obstacles.length) this.obstacles.pop().drop();
    for (let index = this.obstacles.length; index < state.obstacles.length; index++)
      this.obstacles.push(this.ring(`Obstacle ${index + 1}`, "obstacle", { do: "obstacle", index }));
    (state.sliders || []).forEach((each, index) => this.slide(each, index));
    this.changed();
  }

  slide({ label, value, lower, upper, step }, index) {
    const known = this.sliders[index];
    if (known) {
      if (document.activeElement !== known.input) known.set(value);
      return;
    }
    const row = document.createElement("label"), input = document.createElement("input");
    const [name, number] = [label, ""].map((text) => {
      return Object.assign(document.createElement("span"), { textContent: text });
    });
    Object.assign(input, { type: "range", min: lower, max: upper, step });
    const set = (to) => { input.value = to; number.textContent = +(+to).toFixed(3); };
    input.oninput = () => { set(input.value); this.send({ do: "slide", index, value: +input.value }); };
    row.append(name, number, input);
    this.find("sliders").append(row);
    this.sliders[index] = { input, set };
    set(value);
  }
}

window.leadthrough.View = LiveView;
