// One question under way, and the latest that waits.

/** Asks an asynchronous function one question at a time. Of those that come meanwhile the latest waits; the answer of one that
 * another takes the place of is `undefined`. */
export class Latest {
  #ask;
  #busy = false;
  #waiting;

  constructor(ask) {
    this.#ask = ask;
  }

  /** The answer, or `undefined` if a later question took its place before it was asked. */
  ask(...question) {
    this.#waiting?.resolve(undefined);
    return new Promise((resolve, reject) => {
      this.#waiting = { question, resolve, reject };
      this.#next();
    });
  }

  async #next() {
    if (this.#busy || !this.#waiting) return;
    const { question, resolve, reject } = this.#waiting;
    [this.#busy, this.#waiting] = [true, undefined];
    try {
      resolve(await this.#ask(...question));
    } catch (fault) {
      reject(fault);
    }
    this.#busy = false;
    this.#next();
  }
}
