// The hand that is driven: it can be asked to close, where that is ours to begin, and to open.

import { byId, setText } from "./dom.js";

// A server that does not hear from this page for 1.5 s opens the hand that it had close, ms.
const BEAT = 400;

export class Hand {
  constructor(ask, beat) {
    setInterval(() => byId("close-hand").hidden || beat(), BEAT);
    byId("close-hand").onclick = () => ask({ do: "close" });
    byId("open-hand").onclick = () => ask({ do: "open" });
    addEventListener("keydown", (event) => {
      if (event.key === "Escape" && !byId("hand").hidden) ask({ do: "open" }); // whatever is typed
      const typing = event.target instanceof HTMLInputElement;
      const plain = !(event.ctrlKey || event.metaKey || event.altKey || event.repeat);
      if (!plain || typing || byId("hand").hidden) return;
      if (event.key.toLowerCase() === "o") ask({ do: "open" });
      if (event.key.toLowerCase() === "c" && !byId("close-hand").hidden) ask({ do: "close" });
    });
  }

  hello(hello) {
    byId("hand").hidden = hello.hand_asks.length === 0;
    byId("close-hand").hidden = !hello.hand_asks.includes("close");
    this.command(null);
    this.enable(true);
  }

  enable(yes) {
    for (const id of ["close-hand", "open-hand"]) byId(id).disabled = !yes;
  }

  lost() {
    this.enable(false);
  }

  command(command) {
    setText(byId("hand-told"), command ? `Last command: ${command.ask}, by ${command.by}` : "");
  }
}
