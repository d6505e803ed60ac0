// One large view with a dividing line, and strips of thumbnails over time by which it is chosen.
import { Compare, type Side } from "./compare";
import type { Run, View } from "./data";
import { button, make, section, setPressed } from "./elements";
import { shotsOf, type Shot } from "./shots";
import { decibels, fixed } from "./words";

const ROLES = ["worst", "median", "best"] as const;
const TRUTH = -1; // as a side; others are indices of runs

class Viewer {
  readonly element: HTMLElement;
  private readonly shots: Shot[];
  private shot: Shot;
  private sides: [number, number];
  private errors = false;
  private readonly large = new Compare();
  private readonly full = new Compare();
  private readonly dialog: HTMLDialogElement;
  private readonly caption = make("p", { class: "caption", "aria-live": "polite" });
  private readonly roleButtons = new Map<string, HTMLButtonElement>();
  private readonly thumbnails = new Map<Shot, HTMLButtonElement>();
  private readonly scale = errorScale();

  constructor(private readonly runs: Run[], shots: Shot[]) {
    this.shots = shots;
    const inAll = shots.filter((shot) => !shot.views.includes(null));
    this.shot = inAll.find((shot) => shot.role === "worst") ?? inAll[0] ?? shots[0];
    this.sides = runs.length > 1 ? [0, 1] : [TRUTH, 0];
    this.dialog = this.makeDialog();
    this.element = section(
      "Views",
      make("div", { class: "card viewer" }, this.controls(), this.large.element, this.caption,
        this.scale, ...this.strips(), this.dialog),
    );
    this.show(this.shot);
  }

  /** Whether there are images of the view of this name, which is then shown. */
  select(name: string): boolean {
    const shot = this.shots.find((other) => other.name === name);
    if (shot === undefined) return false;
    this.show(shot);
    this.element.scrollIntoView({ block: "start" });
    return true;
  }

  private controls(): HTMLElement {
    const roles = ROLES.flatMap((role) => {
      const shot = this.shots.find((other) => other.role === role);
      if (shot === undefined) return [];
      const node = button(role, () => this.show(shot));
      this.roleButtons.set(role, node);
      return node;
    });
    const errors = button("Error map", () => {
      this.errors = !this.errors;
      setPressed(errors, this.errors);
      this.show(this.shot);
    });
    setPressed(errors, false);
    const full = button("Full size", () => this.dialog.showModal());
    const choices = this.runs.length > 1 ? [this.sideChoice(0), this.sideChoice(1)] : [];
    const group = { class: "choice", role: "group", "aria-label": "views by their PSNR" };
    const byRole = roles.length > 0 ? make("div", group, ...roles) : null;
    return make("div", { class: "bar" }, byRole, ...choices, errors, full);
  }

  private sideChoice(side: 0 | 1): HTMLElement {
    const names = ["truth", ...this.runs.map((run) => run.title)];
    const options = names.map((name, i) => make("option", { value: i - 1 }, name));
    const name = side === 0 ? "left" : "right";
    const select = make("select", { "aria-label": `${name} side` }, ...options);
    select.value = String(this.sides[side]);
    select.addEventListener("change", () => {
      this.sides[side] = Number(select.value);
      this.show(this.shot);
    });
    return make("label", {}, `${name} `, select);
  }

  private makeDialog(): HTMLDialogElement {
    const close = button("Close", () => dialog.close());
    const dialog = make("dialog", { "aria-label": "view at full size" }, close,
      make("div", { class: "scroll" }, this.full.element));
    return dialog;
  }

  private strips(): HTMLElement[] {
    const inStrips = this.shots.filter((shot) => shot.strip);
    return [...new Set(inStrips.map((shot) => shot.camera))].map((camera) => {
      const shots = inStrips.filter((shot) => shot.camera === camera);
      const nodes = shots.map((shot) => this.thumbnail(shot));
      const group = { class: "strip", role: "group", "aria-label": `over time, ${camera}` };
      const strip = make("div", group, ...nodes);
      strip.addEventListener("keydown", (event) => {
        const step = event.key === "ArrowRight" ? 1 : event.key === "ArrowLeft" ? -1 : 0;
        const focused = nodes.indexOf(document.activeElement as HTMLButtonElement);
        if (step === 0 || focused < 0) return;
        event.preventDefault();
        const next = Math.min(nodes.length - 1, Math.max(0, focused + step));
        nodes[next].focus();
        this.show(shots[next]);
      });
      return make("div", {}, make("h3", {}, camera), strip);
    });
  }

  private thumbnail(shot: Shot): HTMLButtonElement {
    const view = shot.views.find((other) => other !== null)!;
    const image = make("img", { alt: "", src: view.result ?? shot.truth, loading: "lazy" });
    image.style.aspectRatio = String(shot.width / shot.height);
    const words = `time ${fixed(shot.time, 2)}, ${decibels(view.psnr)}`;
    const node = make("button", {
      type: "button", "aria-label": `${shot.name}, ${words}`, click: () => this.show(shot),
    }, image, make("span", {}, words));
    this.thumbnails.set(shot, node);
    return node;
  }

  private side(run: number): Side {
    if (run === TRUTH) return { label: "truth", address: this.shot.truth };
    const view = this.shot.views[run];
    const name = this.runs.length > 1 ? this.runs[run].title : "result";
    if (!this.errors) return { label: name, address: view?.result ?? null };
    const label = this.runs.length > 1 ? `error of ${name}` : "error";
    return { label, address: view?.error ?? null };
  }

  private show(shot: Shot): void {
    this.shot = shot;
    const [left, right] = this.sides.map((run) => this.side(run));
    for (const compare of [this.large, this.full])
      compare.show(shot.name, left, right, shot.width, shot.height);
    this.caption.replaceChildren(make("strong", {}, shot.name), ` ${this.scores()}`);
    this.scale.hidden = !this.errors;
    for (const [role, node] of this.roleButtons) setPressed(node, shot.role === role);
    for (const [other, node] of this.thumbnails) {
      setPressed(node, other === shot);
      if (other === shot) revealIn(node);
    }
  }

  private scores(): string {
    const words = (view: View | null) => {
      if (view === null) return "not rendered";
      let text = `PSNR ${decibels(view.psnr)}`;
      if (view.psnr_dynamic !== null) text += `, moving pixels ${decibels(view.psnr_dynamic, 1)}`;
      if (view.psnr_static !== null) text += `, static pixels ${decibels(view.psnr_static, 1)}`;
      return text;
    };
    const place = `${this.shot.camera}, time ${fixed(this.shot.time, 2)}`;
    if (this.runs.length === 1) return `${place}: ${words(this.shot.views[0])}`;
    const shown = [...new Set(this.sides)].filter((run) => run !== TRUTH);
    const each = shown.map((run) => `${this.runs[run].title}: ${words(this.shot.views[run])}`);
    return [place, ...each].join("; ");
  }
}

/** Scrolls the strip alone, not the page. */
function revealIn(node: HTMLElement): void {
  const strip = node.parentElement;
  if (strip === null) return;
  const left = node.offsetLeft - strip.offsetLeft;
  if (left < strip.scrollLeft) strip.scrollLeft = left;
  const right = left + node.offsetWidth - strip.clientWidth;
  if (right > strip.scrollLeft) strip.scrollLeft = right;
}

/** The colours of error maps: the mean absolute difference of the channels. */
function errorScale(): HTMLElement {
  return make("div", { class: "scale" }, make("span", {}, "error 0"), make("i"),
    make("span", {}, "32/255 and more"));
}

export function makeViewer(runs: Run[]): Viewer | null {
  const shots = shotsOf(runs);
  return shots.length > 0 ? new Viewer(runs, shots) : null;
}
