// Controls of a scene: words, choices, sliders, switches, readouts.

type Child = Node | string;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, string> = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

let names = 0;
const fresh = (): string => `c${names++}`;

export interface Option<T extends string> {
  value: T;
  words: string;
  hint?: string;
}

/** One of a few. */
export function choice<T extends string>(
  parent: HTMLElement, title: string, options: Option<T>[], value: T, chosen: (value: T) => void,
): { set(value: T): void } {
  const name = fresh();
  const group = element("fieldset", { class: "choice" }, element("legend", {}, title));
  const row = element("div", { class: "segments" });
  const inputs = options.map((option) => {
    const input = element("input", { type: "radio", name, value: option.value });
    input.checked = option.value === value;
    input.addEventListener("change", () => chosen(option.value));
    const label = element("label", option.hint ? { title: option.hint } : {}, input, element("span", {}, option.words));
    row.append(label);
    return input;
  });
  group.append(row);
  parent.append(group);
  return { set: (next) => inputs.forEach((input) => (input.checked = input.value === next)) };
}

/** A number between two others. */
export function slider(
  parent: HTMLElement, title: string, range: { min: number; max: number; step: number }, value: number,
  words: (value: number) => string, moved: (value: number) => void,
): { set(value: number): void } {
  const id = fresh();
  const input = element("input", { type: "range", id, min: `${range.min}`, max: `${range.max}`, step: `${range.step}` });
  const output = element("output", { for: id });
  const show = (next: number) => {
    input.value = `${next}`;
    output.textContent = words(next);
    input.setAttribute("aria-valuetext", words(next));
    const share = (100 * (next - range.min)) / (range.max - range.min);
    input.style.setProperty("--share", `${Math.min(100, Math.max(0, share))}%`);
  };
  input.addEventListener("input", () => {
    show(Number(input.value));
    moved(Number(input.value));
  });
  parent.append(element("div", { class: "slider" }, element("label", { for: id }, title), output, input));
  show(value);
  return { set: show };
}

/** On or off. */
export function toggle(
  parent: HTMLElement, title: string, on: boolean, turned: (on: boolean) => void, hint = "",
): { set(on: boolean): void } {
  const input = element("input", { type: "checkbox", role: "switch" });
  input.checked = on;
  input.addEventListener("change", () => turned(input.checked));
  const words = element("span", { class: "words" }, title);
  if (hint) words.append(element("small", {}, hint));
  parent.append(element("label", { class: "toggle" }, input, element("span", { class: "track" }), words));
  return { set: (next) => (input.checked = next) };
}

export function button(parent: HTMLElement, title: string, pressed: () => void, kind = ""): HTMLButtonElement {
  const made = element("button", { type: "button", class: kind }, title);
  made.addEventListener("click", pressed);
  parent.append(made);
  return made;
}

/** Names and what they are at now. */
export class Readout {
  private readonly list = element("dl", { class: "readout" });
  private readonly values = new Map<string, HTMLElement>();

  constructor(parent: HTMLElement) {
    parent.append(this.list);
  }

  set(name: string, value: string, kind = ""): void {
    let held = this.values.get(name);
    if (!held) {
      held = element("dd");
      this.values.set(name, held);
      this.list.append(element("div", {}, element("dt", {}, name), held));
    }
    if (held.textContent !== value) held.textContent = value;
    if (held.className !== kind) held.className = kind;
  }
}

/** Offers text as a file. */
export function save(name: string, text: string, type = "text/plain"): void {
  const link = element("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** A button that saves the figure. */
export function saving(parent: HTMLElement, name: string, picture: () => string): void {
  const row = element("div", { class: "buttons" });
  parent.append(row);
  button(row, "Save picture", () => save(name, picture(), "image/svg+xml"));
}

/** What is told to screen readers when it has settled. */
export function announcer(parent: HTMLElement): (words: string) => void {
  const live = element("p", { class: "unseen", role: "status" });
  parent.append(live);
  let timer = 0;
  return (words) => {
    clearTimeout(timer);
    timer = window.setTimeout(() => (live.textContent = words), 700);
  };
}
