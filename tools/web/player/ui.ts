// The page's panels: what they show, and the actions that their controls request.
import type { Action } from "./keys";
import type { Part } from "./clock";
import { Poster } from "./poster";
import { frameWords, timeWords, type Clip } from "./time_words";

export const RATES = [0.1, 0.25, 0.5, 1, 2, 4];

const IDLE_MS = 3000; // without a pointer or a key, panels of a playing scene fade
const NOTICE_MS = 3000;

export function element<T extends HTMLElement>(id: string): T {
  const found = document.getElementById(id);
  if (found === null) throw new Error(`the page has no #${id}`);
  return found as T;
}

/** Leaves a node alone that has the text already: every change has the page painted anew. */
function setText(node: HTMLElement, text: string): void {
  if (node.textContent !== text) node.textContent = text;
}

export class Panels {
  private readonly timeline = element<HTMLInputElement>("timeline");
  private readonly time = element("time");
  private readonly frame = element("frame");
  private readonly rate = element<HTMLSelectElement>("rate");
  private readonly camera = element<HTMLSelectElement>("camera");
  private readonly loading = element("loading");
  private readonly trouble = element("trouble");
  private readonly help = element<HTMLDialogElement>("help");
  private readonly poster = new Poster(element<HTMLImageElement>("poster"));
  private dismissed: string | null = null;
  private idleTimer = 0;
  private noticeTimer = 0;
  private playing = false;
  private seconds = NaN; // that the time line shows
  private loaded = ""; // width of the bar of loading
  private sound = ""; // what showSound() was told
  private clip: Clip = { duration: 0, fps: null, frames: null };

  constructor(
    act: (action: Action) => void,
    seek: (seconds: number) => void,
    setRate: (rate: number) => void,
    private readonly visible: boolean,
  ) {
    const press = (id: string, action: Action) =>
      element(id).addEventListener("click", () => act(action));
    press("play", { do: "toggle" });
    press("back", { do: "step", frames: -1 });
    press("forward", { do: "step", frames: 1 });
    press("loop", { do: "loop" });
    press("reset", { do: "reset" });
    press("sound", { do: "mute" });
    press("sound-ask", { do: "sound" });
    press("fullscreen", { do: "fullscreen" });
    press("part", { do: "part" });
    press("save", { do: "save" });
    press("embed", { do: "embed" });
    // iPhones let a page have no full screen
    element("fullscreen").hidden = !("requestFullscreen" in document.documentElement);
    press("path", { do: "path" });
    press("compare", { do: "compare" });
    press("vr", { do: "vr" });
    press("share", { do: "share" });
    press("settings-open", { do: "settings" });
    press("help-open", { do: "help" });
    this.timeline.addEventListener("input", () => seek(this.timeline.valueAsNumber));
    this.rate.addEventListener("change", () => setRate(Number(this.rate.value)));
    this.camera.addEventListener("change", () =>
      act({ do: "camera", index: Number(this.camera.value) }),
    );
    element("trouble-close").addEventListener("click", () => {
      this.dismissed = element("trouble-line").textContent;
      this.trouble.hidden = true;
    });
    for (const name of ["pointermove", "pointerdown", "keydown"] as const)
      addEventListener(name, () => this.wake());
  }

  /** Once the scene is known. A clip without a duration has no time line. */
  open(clip: Clip, cameras: string[], about: string, licences: string): void {
    this.clip = clip;
    this.timeline.max = String(clip.duration);
    this.camera.replaceChildren(new Option("Free view", "-1"));
    cameras.forEach((name, i) => this.camera.add(new Option(name, String(i))));
    element("camera-choice").hidden = cameras.length === 0;
    this.showTitle();
    element("about").textContent = about;
    element("licences").textContent = licences;
    element("top").hidden = !this.visible;
    element("bar").hidden = !this.visible || clip.duration === 0;
  }

  /** Of the export, in the page's head; without one there is only the player's own name. */
  private showTitle(): void {
    const title = document.title;
    element("title").textContent = element("help-title").textContent = title;
    element("title").hidden = !this.visible || title === "Tessera";
    const meta = document.querySelector<HTMLMetaElement>('meta[name="description"]');
    element("description").textContent = meta?.content ?? "";
    element("description").hidden = meta === null;
  }

  /** The first image of the scene is on the screen, or will not come. */
  showScene(): void {
    this.poster.leave();
  }

  showTime(seconds: number): void {
    if (seconds === this.seconds) return;
    this.seconds = seconds;
    const words = timeWords(this.clip, seconds);
    setText(this.time, words);
    setText(this.frame, frameWords(this.clip, seconds) ?? "");
    this.timeline.valueAsNumber = seconds;
    this.timeline.setAttribute("aria-valuetext", words);
    this.timeline.style.setProperty("--done", `${(100 * seconds) / (this.clip.duration || 1)}%`);
  }

  showPlaying(playing: boolean): void {
    if (playing === this.playing) return;
    this.wake();
    this.playing = playing;
    const button = element("play");
    button.classList.toggle("playing", playing);
    button.setAttribute("aria-label", playing ? "Pause (space)" : "Play (space)");
  }

  showLoop(loop: boolean): void {
    element("loop").setAttribute("aria-pressed", String(loop));
  }

  showPath(on: boolean): void {
    element("path").setAttribute("aria-pressed", String(on));
  }

  /** `from`: of a part whose end is not chosen yet; null: all is played. */
  showPart(part: Part | { from: number } | null): void {
    element("part").setAttribute("aria-pressed", String(part !== null));
    const share = (seconds: number) => `${(100 * seconds) / (this.clip.duration || 1)}%`;
    const { style } = this.timeline;
    style.setProperty("--part-from", part === null ? "0%" : share(part.from));
    style.setProperty("--part-to", part === null ? "0%" : share("to" in part ? part.to : part.from));
  }

  /** null: they are not wanted. */
  showNumbers(line: string | null): void {
    element("numbers").hidden = line === null;
    if (line !== null) setText(element("numbers"), line);
  }

  /** Where the browser has a headset. */
  offerVr(offered: boolean): void {
    element("vr").hidden = !offered;
  }

  showVr(on: boolean): void {
    element("vr").setAttribute("aria-pressed", String(on));
  }

  showRate(rate: number): void {
    const rates = RATES.includes(rate) ? RATES : [...RATES, rate].sort((a, b) => a - b);
    this.rate.replaceChildren(...rates.map((r) => new Option(`${r}×`, String(r))));
    this.rate.value = String(rate);
  }

  /** `muted`: null where the scene has no sound; `blocked`: the browser waits for a tap. */
  showSound(muted: boolean | null, blocked: boolean): void {
    const state = `${muted} ${blocked}`;
    if (state === this.sound) return;
    this.sound = state;
    const button = element("sound");
    button.hidden = muted === null;
    button.setAttribute("aria-pressed", String(muted === true));
    element("sound-ask").hidden = muted !== false || !blocked;
    for (const line of document.querySelectorAll<HTMLElement>(".of-sound"))
      line.hidden = muted === null;
  }

  /** −1: none of the rig's. */
  showCamera(index: number): void {
    this.camera.value = String(index);
  }

  /** `share`: 0 to 1; null: nothing is awaited. `quiet`: a frame is shown already. */
  showLoading(line: string, share: number | null, quiet: boolean): void {
    this.loading.hidden = share === null;
    this.loading.classList.toggle("quiet", quiet);
    setText(element("loading-line"), line);
    const width = `${100 * Math.min(1, share ?? 0)}%`;
    if (width === this.loaded) return;
    element("loading-bar").style.width = this.loaded = width;
  }

  /** One line, until it is closed or nothing is wrong any more. */
  showTrouble(line: string | null): void {
    if (line === null) this.dismissed = null;
    this.trouble.hidden = line === null || line === this.dismissed;
    if (line !== null) setText(element("trouble-line"), line);
  }

  /** A line that goes by itself. */
  showNotice(line: string): void {
    const notice = element("notice");
    notice.textContent = line;
    notice.hidden = false;
    clearTimeout(this.noticeTimer);
    this.noticeTimer = window.setTimeout(() => (notice.hidden = true), NOTICE_MS);
  }

  toggleHelp(): void {
    if (this.help.open) this.help.close();
    else this.help.showModal();
  }

  toggleFullscreen(): void {
    if (document.fullscreenElement) void document.exitFullscreen();
    else document.documentElement.requestFullscreen?.().catch(() => this.wake());
  }

  private wake(): void {
    document.body.classList.remove("idle");
    clearTimeout(this.idleTimer);
    this.idleTimer = window.setTimeout(() => {
      if (this.playing) document.body.classList.add("idle");
    }, IDLE_MS);
  }
}
