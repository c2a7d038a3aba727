// The search of these pages works in a worker, which browsers do not start for pages opened from
// disk. There, a hidden frame takes its place.
"use strict";

if (location.protocol === "file:") window.Worker = class extends EventTarget {
  constructor(url) {
    super();
    const frame = document.createElement("iframe");
    frame.hidden = true;
    frame.title = "search";
    document.body.append(frame);
    const inside = frame.contentWindow, text = frame.contentDocument;
    this.frame = frame;
    this.told = (event) => {
      if (event.source !== inside) return;
      const message = new MessageEvent("message", { data: event.data });
      this.dispatchEvent(message);
      if (this.onmessage) this.onmessage(message);
    };
    addEventListener("message", this.told);
    this.ready = new Promise((done) => {
      const script = text.createElement("script");
      inside.postMessage = (data) => setTimeout(() => this.told({ source: inside, data }));
      inside.importScripts = () => {};
      script.src = url;
      script.onload = done;
      text.body.append(script);
    });
  }

  postMessage(data) {
    this.ready.then(() =>
      this.frame.contentWindow.dispatchEvent(new MessageEvent("message", { data })));
  }

  terminate() {
    removeEventListener("message", this.told);
    this.frame.remove();
  }
};
