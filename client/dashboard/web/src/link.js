// SPDX-License-Identifier: BSD-3-Clause
// The connection to the gateway: comes back by itself, and matches replies to what was asked.

const FIRST_WAIT_MS = 500, LONGEST_WAIT_MS = 8000;

/** How long to wait before try number k of a lost connection, from 0. @param {number} k */
export function patience(k) {
  return Math.min(LONGEST_WAIT_MS, FIRST_WAIT_MS * 2 ** k);
}

/** @typedef {{topic: string} & Record<string, any>} Message */

export class Link {
  /**
   * @param {string} url
   * @param {object} on
   * @param {(message: Message) => void} on.message
   * @param {(buffer: ArrayBuffer) => void} on.frame
   * @param {(open: boolean, reason: string) => void} on.change
   * @param {() => string} on.token
   */
  constructor(url, on) {
    this.url = url;
    this.on = on;
    this.tries = 0;
    this.nextId = 1;
    /** @type {Map<number, (message: Message) => void>} */
    this.waiting = new Map();
    this.open();
  }

  open() {
    const socket = new WebSocket(this.url, "meniscus-dashboard");
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      const token = this.on.token();
      this.send({ do: "hello", ...(token ? { token } : {}) });
    };
    socket.onmessage = ({ data }) => {
      if (typeof data !== "string") return this.on.frame(data);
      const message = JSON.parse(data);
      if (message.topic === "hello") {
        this.tries = 0;
        this.on.change(true, "");
      }
      if (message.topic !== "reply") return this.on.message(message);
      this.waiting.get(message.id)?.(message);
      this.waiting.delete(message.id);
    };
    socket.onclose = ({ code, reason }) => this.lost(code === 1008 ? reason : "");
    this.socket = socket;
  }

  /** @param {string} reason */
  lost(reason) {
    const error = { status: "unavailable", message: "the connection to the dashboard's server was lost before the answer came", path: "",
      hint: "what was commanded may have been done: look at the state and the journal" };
    for (const answer of this.waiting.values()) answer({ topic: "reply", error });
    this.waiting.clear();
    this.on.change(false, reason);
    if (reason !== "token") setTimeout(() => this.open(), patience(this.tries++));
  }

  /** @param {object} message  @returns {boolean} whether it went out */
  send(message) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  /** Ask, and get the reply; one with an `error` if there was none. @param {object} message @returns {Promise<Message>} */
  ask(message) {
    const id = this.nextId++;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      if (this.send({ ...message, id })) return;
      this.waiting.delete(id);
      resolve({ topic: "reply", error: { status: "unsent", message: "the dashboard's server does not answer", path: "", hint: "it is tried again by itself" } });
    });
  }
}
