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
    this.element.querySelector(".reading").textContent = why;
    this.moved();
  }

  // Recorded motions are shown from their start, where the next one may begin; others go on or play.
  show(share) {
    if (this.tip.held) return;
    const playing = this.playing, after = this.after;
    Object.assign(this, { live: false, after: null });
    this.seek(after === "end" ? this.duration : after ? 0 : share * this.duration);
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
    for (const name of ["gripper", "learn", "save", "export", "restore"])
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
    this.find("export").disabled = this.find("learn").disabled;
    this.find("save").disabled = !state.learned;
    this.find("next").hidden = !state.command;
    this.find("next").querySelector("code").textContent = state.command;
    this.find("restore").hidden = !state.restorable;
    this.relist(state);
  }

  // Lists the demonstrations anew where they changed; the focus stays at its place in the list.
  relist({ demonstrations, shown }) {
    const told = JSON.stringify([demonstrations, shown]), list = this.find("demonstrations");
    if (told === this.listed) return;
    this.listed = told;
    const controls = () => [...list.querySelectorAll("input, button")];
    const at = controls().indexOf(document.activeElement);
    list.replaceChildren(...demonstrations.map((each, i) => this.row(each, i, shown.includes(i))));
    if (at >= 0) controls().at(Math.min(at, controls().length - 1))?.focus();
  }

  row({ name, seconds, metres, differs, faults }, index, shown) {
    const row = document.createElement("li"), text = document.createElement("span");
    const own = differs === null ? [] : [`${faults.join(", ") || "agrees"} (${Math.max(differs, 0).toFixed(1)})`];
    text.textContent = [`${seconds.toFixed(1)} s`, `${metres.toFixed(2)} m`, ...own].join(", ");
    text.title = "In brackets, the largest difference from the others in usual ones; 3 and more are faults";
    text.classList.toggle("faulty", faults.length > 0);
    const button = (label, does, after, message) => {
      const made = document.createElement("button");
      made.textContent = label;
      made.setAttribute("aria-label", `${does} ${name}`);
      made.onclick = () => { this.after = after; this.send({ index, ...message() }); };
      return made;
    };
    row.append(
      this.field(name, index), button("▶", "play", "play", () => ({ do: "play" })),
      button("✕", "delete", null, () => ({ do: "delete" })), text,
    );
    if (shown)
      row.append(
        button("trim to start here", "start at the time shown:", "rest", () => ({ do: "trim", first: this.time })),
        button("trim to end here", "end at the time shown:", "end", () => ({ do: "trim", last: this.time })),
      );
    return row;
  }

  field(name, index) {
    const field = Object.assign(document.createElement("input"), { value: name, maxLength: 80 });
    field.setAttribute("aria-label", `name of ${name}`);
    field.onkeydown = ({ key }) => { if (key === "Escape") field.value = name; };
    field.onchange = () => {
      this.listed = null; // a name that is refused is shown as it was
      this.send({ do: "rename", index, name: field.value });
    };
    return field;
  }
}

if (document.querySelector(".panel.teach")) window.leadthrough.View = TeachingView;
