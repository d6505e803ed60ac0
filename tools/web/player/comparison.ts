// Compares test images with the model: selects one, and shows a slider between the two.
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
  private views: TruthView[] = [];
  private shown: TruthView | null = null;

  /** `look`: shows what the model has for the view, at its time, and holds it. */
  constructor(private readonly look: (view: TruthView) => void) {
    this.choice.addEventListener("change", () => this.show());
    this.share.addEventListener("input", () => this.slide());
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

  toggle(): void {
    if (this.shown !== null) this.end();
    else if (this.views.length > 0) this.show();
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
    this.image.hidden = this.panel.hidden = view === null;
    this.button.setAttribute("aria-pressed", String(view !== null));
  }

  private slide(): void {
    this.image.style.clipPath = `inset(0 0 0 ${100 - Number(this.share.value)}%)`;
  }
}
