/**
 * One or two views, large, for a screen that many look at: which ones is part of the state.
 *
 * @import {App} from "./app.js"
 */
import { element } from "./dom.js";

const FIRST = ["map", "mechanism"];

export class Large {
  /** @param {App} app */
  constructor(app) {
    this.app = app;
    this.arranged = "";
    this.choices = ["First large view", "Second large view"].map((label, place) => {
      const onchange = () => this.#choose(place);
      return element("select", { class: "large-view", "aria-label": label, onchange });
    });
    app.arrange = () => this.arrange();
  }

  get #known() {
    return this.app.presentable.filter((view) => view.isFor(this.app.state));
  }

  toggle() {
    const known = this.#known.map(({ id }) => id);
    const two = [...FIRST.filter((id) => known.includes(id)), ...known];
    const large = this.app.large.length ? [] : [...new Set(two)].slice(0, 2);
    this.app.store.update({ large }, "large");
  }

  /** Leave, if views are presented; tell whether they were. */
  end() {
    const { length } = this.app.large;
    if (length) this.toggle();
    return length > 0;
  }

  /** @param {number} place */
  #choose(place) {
    const large = this.choices.map(({ value }) => value).filter(Boolean);
    const other = this.choices[1 - place].value;
    this.app.store.update({ large: large[0] === large[1] ? [other] : large }, "large");
  }

  arrange() {
    const { large } = this.app;
    const known = this.#known.map(({ id, panel }) => [id, panel.title.textContent ?? ""]);
    const arranged = JSON.stringify([large, known]);
    if (arranged === this.arranged) return;
    this.arranged = arranged;
    document.body.toggleAttribute("data-large", large.length > 0);
    document
      .querySelector(".tool[aria-label=Present]")
      ?.setAttribute("aria-pressed", String(large.length > 0));
    this.choices.forEach((choice, place) => {
      choice.hidden = !large.length;
      const names = place ? [["", "alone"], ...known] : known;
      choice.replaceChildren(...names.map(([value, text]) => element("option", { value }, text)));
      choice.value = large[place] ?? "";
    });
    for (const { id, panel } of this.app.presentable) panel.section.style.order = String(large.indexOf(id));
  }
}
