// The live page on which an arm is led by its tip: what it says goes to the server, which answers with
// poses, surfaces and the state of all. After handles.js.

const AGAIN = 1000; // ms after which a lost server is called again

class TeachingView extends SceneView {
  constructor(element, data) {
    super(element, data);
    this.panel = document.querySelector(".teach");
    this.state = { demonstrations: [], obstacles: [] };
    this.obstacles = [];
    const drop = () => this.send({ do: "release" });
    this.tip = new Handle(this, "Tip of the arm", "tip", {
      grabbed: () => this.grab(), left: drop,
      moved: (position) => this.send({ do: "lead", position }),
      turned: (vector) => this.send({ do: "turn", vector }),
    });
    this.goal = new Handle(this, "Goal", "goal", { moved: (position) => this.send({ do: "goal", position }) });
    this.point = new Handle(this, "Point of the path", "point", {
      grabbed: () => { this.play(false); this.held = this.time; },
      moved: (position) => this.send({ do: "correct", time: this.held, position }),
    });
    this.buttons();
    this.call();
  }

  // ---- the server

  call() {
    this.socket = new WebSocket(location.href.replace(/^http/, "ws").replace(/[?#].*$/, "") + "live");
    this.socket.onmessage = (event) => this.hear(JSON.parse(event.data));
    this.socket.onclose = () => {
      this.find("told").textContent = "The connection is lost; is leadthrough teach still running?";
      setTimeout(() => this.call(), AGAIN);
    };
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  async hear(message) {
    // Surfaces are unpacked meanwhile: those that come later wait for those before.
    if (message.kind === "scene") {
      this.before = (this.before || Promise.resolve()).then(() => this.redraw(message));
      await this.before;
    } else if (message.kind === "poses") this.follow(message);
    else this.tell_state(message);
  }

  // Poses of the led arm, which the page shows from now on.
  follow({ poses, tip, why }) {
    if (this.playing) this.play(false);
    this.live = true;
    this.links = this.links.map((_, i) => posed(poses.slice(7 * i, 7 * i + 3), poses.slice(7 * i + 3, 7 * i + 7)));
    this.at = tip;
    this.find("reading").textContent = why;
    this.moved();
  }

  async redraw({ data, moves }) {
    const scene = await unpacked(data), { layers, times, poses, arrays, readouts } = scene;
    this.painter.replace(layers, scene);
    this.list(scene.items);
    const share = this.duration ? this.time / this.duration : 0, playing = this.playing;
    Object.assign(this.data, { times, poses, arrays, readouts: readouts || this.data.readouts });
    this.slider.max = this.duration;
    if (moves && !this.tip.held) {
      this.live = false;
      this.seek(this.after ? 0 : share * this.duration);
      this.play(this.after === "play" || !this.after && playing);
      this.after = null;
    }
    this.changed();
  }

  // ---- the arm and its rings

  seek(time) {
    if (this.live && this.panel) this.live = false;
    super.seek(time);
  }

  advance(now) {
    this.live = false;
    super.advance(now);
  }

  grab() {
    const time = this.live ? null : this.time;
    this.play(false);
    this.send({ do: "grab", time });
  }

  draw(way) {
    super.draw(way);
    if (!this.tip) return;
    const { tip, arrays, poses, times } = this.data, shown = this.links[tip];
    const place = shown ? [...shown.slice(12, 15)] : this.at;
    this.tip.put(place);
    this.goal.put(this.state.goal);
    this.point.put(this.state.learned && !this.live && times.length > 1 && poses !== undefined && arrays ? place : null);
    this.obstacles.forEach((ring, i) => ring.put(this.state.obstacles[i]));
  }

  tell() {
    super.tell();
    const told = this.data.readouts;
    if (!this.panel || !told || this.live) return;
    let i = told.times.findIndex((time) => time >= this.time);
    if (i < 0) i = told.times.length - 1;
    const clear = told.clearance ? `clearance ${(1000 * told.clearance[i]).toFixed(0)} mm, ` : "";
    this.find("reading").textContent = `${clear}${told.names[told.joint[i]]} at ${
      (100 * told.share[i]).toFixed(0)} % of its speed, tip ${told.speed[i].toFixed(2)} m/s`;
  }

  // ---- the panel

  find(name) { return this.panel.querySelector(`.${name}`); }

  buttons() {
    const said = (name, message) => { this.find(name).onclick = () => this.send(message()); };
    // Recorded motions are shown from their start, where the next one may begin; others are played.
    this.find("record").onclick = () => {
      if (this.state.recording) this.after = "rest"; else this.grab();
      this.send({ do: this.state.recording ? "stop" : "record" });
    };
    for (const name of ["gripper", "undo", "save"]) said(name, () => ({ do: name }));
    said("learn", () => { this.after = "play"; return { do: "learn" }; });
    this.find("turning").onclick = () => {
      this.tip.turning = !this.tip.turning;
      this.find("turning").setAttribute("aria-pressed", this.tip.turning);
    };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || /input|select/i.test(event.target.tagName)) return;
      const name = { r: "record", g: "gripper", t: "turning" }[event.key];
      if (name) this.find(name).click();
    });
  }

  tell_state(state) {
    this.state = state;
    this.find("told").textContent = state.text;
    this.find("record").textContent = state.recording ? "Stop" : "Record";
    this.panel.classList.toggle("recording", state.recording);
    this.find("gripper").disabled = !state.recording;
    this.find("learn").disabled = !state.demonstrations.length || state.recording;
    this.find("undo").disabled = !state.corrections;
    this.find("save").disabled = !state.learned;
    this.find("next").hidden = !state.command;
    this.find("next").querySelector("code").textContent = state.command;
    this.find("demonstrations").replaceChildren(...state.demonstrations.map((each, i) => this.row(each, i)));
    this.rings(state.obstacles.length);
    this.changed();
  }

  row({ name, seconds, metres }, index) {
    const row = document.createElement("li"), text = document.createElement("span");
    text.textContent = `${name}: ${seconds.toFixed(1)} s, ${metres.toFixed(2)} m`;
    const button = (label, word, does) => {
      const made = document.createElement("button");
      made.textContent = label;
      made.setAttribute("aria-label", `${word} ${name}`);
      made.onclick = () => { if (does === "play") this.after = "play"; this.send({ do: does, index }); };
      return made;
    };
    row.append(text, button("▶", "play", "play"), button("✕", "delete", "delete"));
    return row;
  }

  rings(count) {
    while (this.obstacles.length > count) this.obstacles.pop().drop();
    while (this.obstacles.length < count) {
      const index = this.obstacles.length, moved = (position) => this.send({ do: "obstacle", index, position });
      this.obstacles.push(new Handle(this, `Obstacle ${index + 1}`, "obstacle", { moved }));
    }
  }
}

window.leadthrough.View = TeachingView;
