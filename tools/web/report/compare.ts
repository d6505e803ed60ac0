// Two images of one view over each other, with a dividing line that pointer, touch and keys move.
import { make } from "./elements";

export interface Side {
  label: string;
  address: string | null; // null: not rendered
}

const KEY_STEPS: Record<string, number> = {
  ArrowLeft: -2,
  ArrowDown: -2,
  ArrowRight: 2,
  ArrowUp: 2,
  PageDown: -10,
  PageUp: 10,
  Home: -100,
  End: 100,
};

class Layer {
  readonly image = make("img", { draggable: "false", alt: "" });
  readonly label = make("span");

  constructor(side: string) {
    this.image.className = side;
    this.label.className = side;
  }

  show({ label, address }: Side, view: string): void {
    this.image.hidden = address === null;
    if (address !== null && this.image.getAttribute("src") !== address) this.image.src = address;
    this.image.alt = `${label} of ${view}`;
    this.label.textContent = address === null ? `${label}: not rendered` : label;
  }
}

export class Compare {
  readonly element: HTMLElement;
  private readonly left = new Layer("left");
  private readonly right = new Layer("right");
  private readonly divider = make("div", {
    class: "divider",
    role: "slider",
    tabindex: 0,
    "aria-valuemin": 0,
    "aria-valuemax": 100,
    "aria-label": "dividing line between left and right image",
  });
  private percent = 50;

  constructor() {
    const layers = [this.left.image, this.right.image, this.left.label, this.right.label];
    this.element = make("div", { class: "compare" }, ...layers, this.divider);
    this.element.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      event.preventDefault();
      this.element.setPointerCapture(event.pointerId);
      this.divider.focus({ preventScroll: true });
      this.follow(event);
    });
    this.element.addEventListener("pointermove", (event) => {
      if (this.element.hasPointerCapture(event.pointerId)) this.follow(event);
    });
    this.divider.addEventListener("keydown", (event) => {
      const step = KEY_STEPS[event.key];
      if (step === undefined) return;
      event.preventDefault();
      this.moveTo(this.percent + step);
    });
    this.moveTo(50);
  }

  show(view: string, left: Side, right: Side, width: number, height: number): void {
    this.element.style.setProperty("--aspect", String(width / height));
    this.element.style.setProperty("--width", `${width}px`);
    this.left.show(left, view);
    this.right.show(right, view);
  }

  private follow(event: PointerEvent): void {
    const box = this.element.getBoundingClientRect();
    this.moveTo((100 * (event.clientX - box.left)) / box.width);
  }

  private moveTo(percent: number): void {
    this.percent = Math.min(100, Math.max(0, percent));
    this.element.style.setProperty("--at", `${this.percent}%`);
    this.divider.setAttribute("aria-valuenow", String(Math.round(this.percent)));
  }
}
