// Makes elements of the page. Text becomes text nodes, so that none of it is read as HTML.
export type Child = Node | string | null;
type Value = string | number | boolean | null | ((event: never) => void);

/** An element; functions among the attributes listen to the event of that name. */
export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  attributes: Record<string, Value> = {},
  ...children: Child[]
): HTMLElementTagNameMap[K] {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(name, value as EventListener);
    else if (value !== null && value !== false)
      node.setAttribute(name, value === true ? "" : String(value));
  }
  node.append(...children.filter((child) => child !== null));
  return node;
}

export function section(title: string, ...children: Child[]): HTMLElement {
  return make("section", {}, make("h2", {}, title), ...children);
}

export function card(title: string, ...children: Child[]): HTMLElement {
  return make("div", { class: "card" }, make("h3", {}, title), ...children);
}

export function button(text: string, click: () => void, attributes: Record<string, Value> = {}) {
  return make("button", { type: "button", click, ...attributes }, text);
}

export function setPressed(node: HTMLElement, pressed: boolean): void {
  node.setAttribute("aria-pressed", String(pressed));
}

/** Buttons of which one is pressed, at first the first. */
export function choice(
  label: string,
  names: string[],
  choose: (index: number) => void,
  first = 0,
): HTMLElement {
  const buttons = names.map((name, index) =>
    button(name, () => {
      buttons.forEach((other, k) => setPressed(other, k === index));
      choose(index);
    }),
  );
  buttons.forEach((other, k) => setPressed(other, k === first));
  return make("div", { class: "choice", role: "group", "aria-label": label }, ...buttons);
}

/** Names and what is known of them; those of empty text are left out. */
export function facts(rows: [string, Child][]): HTMLElement {
  const known = rows.filter(([, value]) => value !== null && value !== "");
  return make(
    "dl",
    { class: "facts" },
    ...known.flatMap(([name, value]) => [make("dt", {}, name), make("dd", {}, value)]),
  );
}

export function details(summary: string, ...children: Child[]): HTMLDetailsElement {
  return make("details", {}, make("summary", {}, summary), ...children);
}

/** The same with what is made when it is opened: a table of thousands of rows takes seconds. */
export function detailsWhenOpened(summary: string, content: () => Child): HTMLDetailsElement {
  const made = details(summary);
  made.addEventListener("toggle", () => made.append(content() ?? ""), { once: true });
  return made;
}

/** A file of the page's folder, whose path may have any letters. */
export function fileLink(path: string, text: string, attributes: Record<string, Value> = {}) {
  const href = path.split("/").map(encodeURIComponent).join("/");
  return make("a", { href, ...attributes }, text);
}

/** A variable of the style, which differs between light and dark. */
export function style(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Has the browser save a file. */
export function save(name: string, content: Blob): void {
  const address = URL.createObjectURL(content);
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 1000);
}
