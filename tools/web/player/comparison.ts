// Compares test images with the model: selects one, and shows both with a line between them, which is
// dragged on the image or by the slider of the panel.
import { Fields } from "./json_fields";
import { readCamera, type Camera } from "./manifest";
import { element } from "./ui";

/** An image of the scene that the model can be compared with. */
export interface TruthView {
  name: string;
  camera: Camera;
  t: number; // 0 to 1
  image: string; // address
}

const SAME_TIME = 1e-6; // of t

/** Those of the page's configuration; of a page that has none: none. Throws PlayerError. */
export function readTruth(list: unknown): TruthView[] {
  return new Fields({ truth: list }, "this page", "").list("truth", (f) => ({
    name: f.text("name"),
    camera: readCamera(f.within("camera")),
    t: f.number("t"),
    image: f.text("image"),
  }));
}

export class Comparison {
  private readonly button = element<HTMLButtonElement>("compare");
  private readonly panel = element("comparison");
  private readonly choice = element<HTMLSelectElement>("truth-view");
  private readonly share = element<HTMLInputElement>("truth-share");
  private readonly image = element<HTMLImageElement>("truth");
  private readonly line = element("truth-line");
  private views: TruthView[] = [];
  private shown: TruthView | null = null;

  /** `look`: shows what the model has for the view, at its time, and holds it. */
  constructor(private readonly look: (view: TruthView) => void) {
    this.choice.addEventListener("change", () => this.show());
    this.share.addEventListener("input", () => this.slide());
    this.line.addEventListener("pointerdown", (event) => this.line.setPointerCapture(event.pointerId));
    this.line.addEventListener("pointermove", (event) => {
      if (this.line.hasPointerCapture(event.pointerId)) this.slideTo(event.clientX / innerWidth);
    });
    // the wheel is not for the line
    this.line.addEventListener("wheel", (event) => {
      element("picture").dispatchEvent(new WheelEvent("wheel", event));
    });
    this.slide();
  }

  /** The images to choose from, in the place of those before. */
  offer(views: TruthView[]): void {
    this.end();
    this.views = views;
    this.choice.replaceChildren(...views.map(({ name }, i) => new Option(name, String(i))));
    this.button.hidden = views.length === 0;
    for (const line of document.querySelectorAll<HTMLElement>(".of-truth"))
      line.hidden = views.length === 0;
  }

  get on(): boolean {
    return this.shown !== null;
  }

  toggle(): void {
    if (this.shown !== null) this.end();
    else if (this.views.length > 0) this.show();
  }

  /** The test image after the one that is shown. */
  next(): void {
    if (this.shown === null) return;
    this.choice.selectedIndex = (this.choice.selectedIndex + 1) % this.views.length;
    this.show();
  }

  /** The camera or the time has left the image. */
  end(): void {
    this.set(null);
  }

  /** To be called for each image: another time than that of the image ends the comparison. */
  keep(t: number, playing: boolean): void {
    if (this.shown !== null && (playing || Math.abs(t - this.shown.t) > SAME_TIME)) this.end();
  }

  private show(): void {
    const view = this.views[Number(this.choice.value)];
    this.look(view); // which ends an earlier comparison
    this.image.src = view.image;
    this.set(view);
  }

  private set(view: TruthView | null): void {
    this.shown = view;
    this.image.hidden = this.panel.hidden = this.line.hidden = view === null;
    this.button.setAttribute("aria-pressed", String(view !== null));
  }

  /** `place`: of the line, from 0 (left) to 1. */
  private slideTo(place: number): void {
    this.share.value = String(100 - 100 * Math.min(1, Math.max(0, place)));
    this.slide();
  }

  private slide(): void {
    const left = 100 - Number(this.share.value);
    this.image.style.clipPath = `inset(0 0 0 ${left}%)`;
    this.line.style.left = `${left}%`;
  }
}
