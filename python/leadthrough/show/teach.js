// The live page on which an arm is led by its tip and demonstrations are recorded. After live.js.

class TeachingView extends LiveView {
  constructor(element, data) {
    super(element, data);
    this.tip = new Handle(this, "Tip of the arm", "tip", {
      grabbed: () => this.grab(), left: () => this.send({ do: "release" }),
      moved: (position) => this.send({ do: "lead", position }),
      turned: (vector) => this.send({ do: "turn", vector }),
    });
    this.buttons();
  }

  get turned() { return [this.tip, ...super.turned]; }

  get correctable() { return super.correctable && !this.live; }

  // Takes the arm where it is shown.
  grab() {
    const time = this.live ? null : this.time;
    this.play(false);
    this.send({ do: "grab", time });
  }

  update(message) {
    if (message.kind === "poses") this.follow(message); else this.list_all(message);
  }

  // Poses of the led arm, which the page shows from now on.
  follow({ poses, why }) {
    if (this.playing) this.play(false);
    this.live = true;
    this.links = this.links.map((_, i) => posed(poses.slice(7 * i, 7 * i + 3), poses.slice(7 * i + 3, 7 * i + 7)));
    this.find("reading").textContent = why;
    this.moved();
  }

  // Recorded motions are shown from their start, where the next one may begin; others go on or play.
  show(share) {
    if (this.tip.held) return;
    const playing = this.playing, after = this.after;
    Object.assign(this, { live: false, after: null });
    this.seek(after ? 0 : share * this.duration);
    this.play(after === "play" || !after && playing);
  }

  seek(time) {
    this.live = false;
    super.seek(time);
  }

  tell() { if (!this.live) super.tell(); }

  draw(way) {
    const place = super.draw(way);
    this.tip?.put(place);
  }

  buttons() {
    this.find("record").onclick = () => {
      if (this.state.recording) this.after = "rest"; else this.grab();
      this.send({ do: this.state.recording ? "stop" : "record" });
    };
    for (const name of ["gripper", "learn", "save"])
      this.find(name).onclick = () => {
        if (name === "learn") this.after = "play";
        this.send({ do: name });
      };
    document.addEventListener("keydown", (event) => {
      if (event.ctrlKey || event.metaKey || /input|select/i.test(event.target.tagName)) return;
      const name = { r: "record", g: "gripper", t: "turning" }[event.key];
      if (name) this.find(name).click();
    });
  }

  list_all(state) {
    super.update(state);
    this.find("record").textContent = state.recording ? "Stop" : "Record";
    this.panel.classList.toggle("recording", state.recording);
    this.find("gripper").disabled = !state.recording;
    this.find("learn").disabled = !state.demonstrations.length || state.recording;
    this.find("save").disabled = !state.learned;
    this.find("next").hidden = !state.command;
    this.find("next").querySelector("code").textContent = state.command;
    this.find("demonstrations").replaceChildren(...state.demonstrations.map((each, i) => this.row(each, i)));
  }

  row({ name, seconds, metres }, index) {
    const row = document.createElement("li"), text = document.createElement("span");
    text.textContent = `${name}: ${seconds.toFixed(1)} s, ${metres.toFixed(2)} m`;
    const button = (label, does) => {
      const made = document.createElement("button");
      made.textContent = label;
      made.setAttribute("aria-label", `${does} ${name}`);
      made.onclick = () => { if (does === "play") this.after = "play"; this.send({ do: does, index }); };
      return made;
    };
    row.append(text, button("▶", "play"), button("✕", "delete"));
    return row;
  }
}

if (document.querySelector(".panel.teach")) window.leadthrough.View = TeachingView;
