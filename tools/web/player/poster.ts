// The export's image of the scene, which covers the canvas until the first image is drawn. It is
// placed as the first rig view will be, and an enlarged copy fills the window around it.

const FADE_MS = 400; // as in style.css

export class Poster {
  private readonly around: HTMLImageElement | null;

  /** `image`: without a source where the page was exported without a poster. */
  constructor(private readonly image: HTMLImageElement) {
    this.around = image.hasAttribute("src") ? (image.cloneNode() as HTMLImageElement) : null;
    if (this.around === null) return;
    this.around.id = "poster-around";
    image.before(this.around);
  }

  leave(): void {
    const images = [this.image, ...(this.around ? [this.around] : [])];
    for (const image of images) image.classList.add("left");
    setTimeout(() => images.forEach((image) => image.remove()), FADE_MS);
  }
}
