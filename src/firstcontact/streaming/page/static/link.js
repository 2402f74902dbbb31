// The socket: opens it, takes its messages apart, and opens it again when it was lost.

const LONGEST_WAIT = 4000;

export class Link {
  constructor(handlers) {
    this.handlers = handlers;
    this.wait = 250;
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(`${scheme}//${location.host}/socket`);
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onmessage = (event) => this.attempt("a message", () => this.take(event.data));
    socket.onclose = () => {
      this.handlers.lost();
      setTimeout(() => this.connect(), this.wait);
      this.wait = Math.min(2 * this.wait, LONGEST_WAIT);
    };
  }

  take(data) {
    if (data instanceof ArrayBuffer) {
      const head = new DataView(data);
      const [n, channels] = [head.getUint32(0, true), head.getUint32(4, true)];
      this.handlers.columns(head.getFloat64(8, true), n, channels, new Float32Array(data, 16));
      return;
    }
    const message = JSON.parse(data);
    if (message.hello) this.wait = 250;
    for (const [part, tree] of Object.entries(message)) {
      this.attempt(part, () => this.handlers[part]?.(tree));
    }
  }

  // What one part does wrong is told, and the others go on.
  attempt(what, show) {
    try {
      show();
    } catch (error) {
      this.handlers.failed(what, error);
    }
  }

  // Whether it could be sent: what is asked of a server that is gone is not asked later.
  ask(what) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(what));
    return true;
  }
}
