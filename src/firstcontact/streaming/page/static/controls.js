// Recording and markers: the buttons say what is so, not what was wished.

import { announce, byId, number, setText } from "./dom.js";

const SHOWN_FOR = 4000;

export class Controls {
  constructor(link, newObject) {
    this.link = link;
    this.newObject = newObject;
    this.on = false;
    byId("record").onclick = () => this.ask({ do: this.on ? "stop" : "record" });
    byId("new-object").onclick = () => this.ask({ do: "new" });
    addEventListener("keydown", (event) => {
      const typing = event.target instanceof HTMLInputElement;
      const plain = !(event.ctrlKey || event.metaKey || event.altKey || event.repeat);
      if (event.key.toLowerCase() === "n" && plain && !typing && !byId("same").hidden) this.ask({ do: "new" });
    });
    byId("shape-form").onsubmit = (event) => {
      event.preventDefault();
      this.ask({ do: "shape", text: byId("shape").value.trim() });
    };
    byId("controls").onsubmit = (event) => {
      event.preventDefault();
      const text = byId("marker").value.trim();
      if (text) this.ask({ do: "mark", text });
      else byId("marker").focus();
    };
  }

  hello(hello) {
    byId("controls").hidden = !hello.controls;
    this.enable(true);
  }

  enable(yes) {
    for (const id of ["record", "mark", "marker", "new-object", "shape", "tell-shape"]) byId(id).disabled = !yes;
  }

  // What the recorder does now is not known, so nothing is claimed.
  lost() {
    this.enable(false);
    this.status = null;
    this.paint();
  }

  ask(what) {
    if (what.do === "new") {
      byId("shape").value = "";
      this.newObject();
    }
    if (!this.link().ask(what)) this.say("The server is gone: that was not done.", true);
  }

  answer(answer) {
    if (answer.ok && answer.do === "mark") byId("marker").value = "";
    // Where a recording is stays readable until something else is said.
    this.say(answer.text, !answer.ok, answer.ok && answer.do === "stop");
  }

  say(text, failed, stays = false) {
    this.said = { text, failed };
    clearTimeout(this.timer);
    if (!stays) {
      this.timer = setTimeout(() => {
        this.said = null;
        this.paint();
      }, SHOWN_FOR);
    }
    announce(text);
    this.paint();
  }

  recording(status) {
    if (status.failed && status.failed !== this.status?.failed) announce(`Recording stopped: ${status.failed}`);
    this.status = status;
    this.on = status.name !== null && !status.failed;
    byId("record").classList.toggle("on", this.on);
    setText(byId("record-word"), this.on ? "Stop recording" : "Start recording");
    this.paint();
  }

  paint() {
    const band = byId("recording");
    const { name, samples, waiting, failed } = this.status ?? { name: null };
    const parts = [];
    if (failed) parts.push(`! Recording stopped: ${failed}`);
    else if (name !== null) {
      parts.push(`Recording ${name}: ${number(samples)} samples written, ${number(waiting)} waiting`);
    }
    if (this.said) parts.push(this.said.text);
    band.hidden = parts.length === 0;
    band.classList.toggle("failed", Boolean(failed || this.said?.failed));
    setText(band, parts.join(" · "));
  }
}
