// The page: connects scene, clock, camera and panels, and draws when the display requests a frame.
import { Clock, type Part } from "./clock";
import { Comparison, readTruth, type TruthView } from "./comparison";
import { listenToKeys, type Action } from "./keys";
import { LICENCES } from "./licences";
import { loadedShare, loadingLine, type Progress } from "./loading";
import { openSource, readConfig } from "./open_source";
import { lineOf } from "./player_error";
import type { SceneInfo, SceneView, ViewCamera } from "./scene_view";
import { SettingsPanel } from "./settings";
import { imageName, saveImage, share, shareEmbed } from "./share";
import { SparkView } from "./spark_view";
import "./style.css";
import { frameAt, ImageRate } from "./time_words";
import { Panels, RATES } from "./ui";
import { colourOf, readUrl, rememberInUrl, withValues } from "./url_state";
import { Viewpoint } from "./viewpoint";
import { isVrSupported } from "./xr";

const AHEAD_SECONDS = 2.5; // of play, fetched in advance
const FRAME_RATE = 30; // where the capture's is not known
const EARLY_MS = 4; // that an image of a limited rate may come before its time
const LOST = "the graphics device was lost (memory?); close other pages and reload this one";
const FLY_KEYS = "Fly with W A S D, Q down, E up, Shift faster; V ends it";
const MOST_PIXELS_A_PIXEL = 2; // device pixels for a CSS pixel

const canvas = document.getElementById("picture") as HTMLCanvasElement;
const url = readUrl(location.search);

class Page {
  private readonly camera: ViewCamera = {
    position: [0, 0, 0],
    rotation: [1, 0, 0, 0],
    lens: { fx: 1, fy: 1, cx: 0.5, cy: 0.5, width: 1, height: 1 },
    whole: false,
    version: 0,
  };
  private readonly panels = new Panels(
    (action) => this.act(action),
    (seconds) => this.seek(seconds),
    (rate) => this.setRate(rate),
    url.panels,
  );
  private view!: SceneView;
  private info!: SceneInfo;
  private clock!: Clock;
  private viewpoint!: Viewpoint;
  private settings!: SettingsPanel;
  private readonly comparison = new Comparison((view) => this.showTruth(view));
  private loaded: Progress = { bytes: 0, needed: 0 };
  private pictured = false; // whether a first image is on the screen
  private drawn = 0; // ms; when the last image was
  private readonly rate = new ImageRate();
  private part: Part | { from: number } | null = null; // that is repeated, or begun to be chosen
  private lost: string | null = null; // why nothing is drawn any more
  private remembered = true; // whether the address says which time is shown

  async open(): Promise<void> {
    this.view = new SparkView(canvas, this.camera);
    const text = document.getElementById("tessera-config")?.textContent ?? "{}";
    const config = readConfig(text);
    const source = await openSource(config, url.scene, location.href);
    this.info = await this.view.load(source, (progress) => (this.loaded = progress));
    const { time, audio, cameras } = this.info;
    const wall = () => performance.now() / 1000;
    this.clock = new Clock(time.duration, wall, audio === null ? null : new Audio(audio));
    this.clock.loop = url.loop;
    const clip = { ...time, frames: this.info.frames };
    this.panels.open(clip, cameras.map(({ name }) => name), this.about(), LICENCES);
    this.panels.showLoop(this.clock.loop);
    this.setRate(url.rate ?? 1);
    if (url.part !== null && url.part.to <= time.duration) this.setPart(url.part);
    const showCamera = (index: number) => {
      this.panels.showCamera(index);
      this.comparison.end();
    };
    this.viewpoint = new Viewpoint(canvas, this.camera, this.info, this.view, showCamera);
    this.viewpoint.onPath = (on) => this.panels.showPath(on);
    const canStay = cameras.length > 0;
    this.settings = new SettingsPanel(() => this.applySettings(), canStay);
    this.settings.onFly = (on) => this.fly(on);
    this.applySettings();
    this.viewpoint.open(url.camera, url.view, url.path);
    this.clock.seek(url.seconds ?? 0);
    if (url.scene === null) this.comparison.offer(readTruth(config.truth));
    canvas.addEventListener("webglcontextlost", () => (this.lost = LOST));
    addEventListener("resize", () => this.resize());
    this.resize();
    listenToKeys((action) => this.act(action));
    if (!url.paused) this.clock.play();
    this.clock.hold(true);
    void isVrSupported().then((offered) => this.panels.offerVr(offered));
    this.loop();
  }

  /** Another scene of the same time and cameras in the place of this one. */
  private async replace(address: string): Promise<void> {
    const source = await openSource({}, address, location.href);
    this.info = await this.view.load(source, (progress) => (this.loaded = progress));
  }

  private about(): string {
    const { gaussians, time, frames } = this.info;
    const seconds = `${time.duration.toFixed(2)} s, continuous`;
    const length = frames ? `${frames.length} frames` : seconds;
    return `${gaussians.toLocaleString("en")} Gaussians · ${length}`;
  }

  private applySettings(): void {
    this.viewpoint.stay(this.settings.settings.stay);
    this.view.setShDegree(this.settings.settings.shDegree);
    this.view.setBackground(url.background ?? colourOf(this.settings.settings.background));
    if (!this.settings.settings.numbers) this.panels.showNumbers(null);
    this.resize();
  }

  private resize(): void {
    const most = Math.min(devicePixelRatio || 1, MOST_PIXELS_A_PIXEL);
    const dpr = most * this.settings.settings.resolution;
    this.view.resize(canvas.clientWidth, canvas.clientHeight, dpr);
  }

  /** t of a time in seconds. */
  private t(seconds: number): number {
    const { duration } = this.info.time;
    return duration > 0 ? seconds / duration : 0;
  }

  /** Whether the limit of images a second leaves this one out. */
  private isEarly(): boolean {
    const { frameRate } = this.settings.settings;
    const now = performance.now();
    if (frameRate > 0 && now - this.drawn < 1000 / frameRate - EARLY_MS) return true;
    this.drawn = now;
    return false;
  }

  /** For every frame of the display. A headset asks for its frames itself. */
  private loop(): void {
    requestAnimationFrame(() => this.loop());
    if (!this.view.inVr && !this.isEarly()) this.frame();
  }

  private frame(): void {
    if (this.pictured) this.viewpoint.step();
    const seconds = this.clock.now();
    const playing = this.clock.playing;
    const ahead = playing ? this.t(AHEAD_SECONDS * Math.max(1, this.clock.rate)) : 0;
    const play = { ahead, loop: this.clock.loop };
    const { waiting, complete, trouble } = this.view.setTime(this.t(seconds), play);
    if (!this.pictured && (complete || this.lost !== null)) this.showScene();
    // frames of a sequence are left out when they are late; blocks are waited for
    this.clock.hold(!this.pictured || (waiting && this.info.frames === null));
    this.showLoading(waiting);
    this.panels.showTrouble(this.lost ?? trouble);
    this.comparison.keep(this.t(seconds), playing);
    this.showWhole(this.comparison.on);
    if (this.settings.settings.numbers) this.panels.showNumbers(this.numbers());
    this.panels.showTime(seconds);
    this.panels.showPlaying(playing);
    this.panels.showSound(this.clock.muted, this.clock.soundBlocked);
    if (!playing && !this.remembered) rememberInUrl({ t: seconds.toFixed(3), paused: "1" });
    this.remembered = !playing;
  }

  /** A test image lies over all of the lens's image. */
  private showWhole(whole: boolean): void {
    if (whole === this.camera.whole) return;
    this.camera.whole = whole;
    ++this.camera.version;
  }

  private numbers(): string {
    const rate = this.rate.count(performance.now());
    const megabytes = (this.loaded.bytes / 1e6).toFixed(1);
    return `${rate} images/s · ${this.info.gaussians.toLocaleString("en")} Gaussians · ${megabytes} MB`;
  }

  private showScene(): void {
    this.pictured = true;
    this.panels.showScene();
  }

  private showLoading(waiting: boolean): void {
    if (this.pictured) return this.panels.showLoading("Loading", waiting ? 1 : null, true);
    this.panels.showLoading(loadingLine(this.loaded), loadedShare(this.loaded), false);
  }

  seek(seconds: number): void {
    this.clock.seek(seconds);
    this.remembered = false;
  }

  private showTruth(view: TruthView): void {
    this.clock.pause();
    this.viewpoint.look(view.camera);
    this.seek(view.t * this.info.time.duration);
  }

  private setRate(rate: number): void {
    this.clock.setRate(rate);
    this.panels.showRate(rate);
  }

  /** To the next frame of a sequence, or by one of the capture's. */
  private step(frames: number): void {
    this.clock.pause();
    const now = this.clock.now();
    const { duration, fps } = this.info.time;
    if (this.info.frames === null) return this.seek(now + frames / (fps ?? FRAME_RATE));
    const times = this.info.frames.map((t) => t * duration);
    const nearest = frameAt({ duration, fps, frames: this.info.frames }, now)!;
    this.seek(times[Math.min(times.length - 1, Math.max(0, nearest + frames))]);
  }

  private fly(on: boolean): void {
    this.viewpoint.fly(on);
    this.settings.showFly(on);
    this.panels.showNotice(on ? FLY_KEYS : "Drags turn about the scene");
  }

  /** Into the headset, or back to the page. */
  private async toggleVr(): Promise<void> {
    if (this.view.inVr) return this.view.leaveVr();
    this.viewpoint.finish();
    const ended = () => {
      this.panels.showVr(false);
      this.resize(); // the window may have another size than before
    };
    try {
      await this.view.enterVr(() => this.frame(), ended);
      this.panels.showVr(this.view.inVr);
    } catch (error) {
      this.panels.showNotice(`VR cannot start: ${lineOf(error)}`);
    }
  }

  /** The address of this view at this time. */
  private address(): string {
    const values = { t: this.clock.now().toFixed(3), ...this.viewpoint.values };
    rememberInUrl(values);
    return withValues(location.href, values);
  }

  private async share(embed: boolean): Promise<void> {
    const line = await (embed ? shareEmbed : share)(this.address(), document.title);
    if (line !== null) this.panels.showNotice(line);
  }

  private async saveImage(): Promise<void> {
    const image = await this.view.image();
    if (image === null) return this.panels.showNotice("The browser gives no image");
    saveImage(image, imageName(document.title, this.clock.now()));
  }

  private setPart(part: Part | { from: number } | null): void {
    this.part = part;
    const whole = part !== null && "to" in part ? part : null;
    this.clock.setPart(whole);
    this.panels.showPart(part);
    const word = whole && `${whole.from.toFixed(3)}-${whole.to.toFixed(3)}`;
    rememberInUrl({ part: word });
  }

  /** The start of a part, then its end, then all of the clip again. */
  private nextPart(): void {
    const now = this.clock.now();
    if (this.part === null) return this.setPart({ from: now });
    if ("to" in this.part || now === this.part.from) return this.setPart(null);
    const [from, to] = [now, this.part.from].sort((a, b) => a - b);
    this.setPart({ from, to });
  }

  private act(action: Action): void {
    const { clock, panels } = this;
    switch (action.do) {
      case "toggle":
        return clock.playing ? clock.pause() : clock.play();
      case "step":
        return this.step(action.frames);
      case "start":
        return this.seek(0);
      case "end":
        return this.seek(this.info.time.duration);
      case "rate": {
        const index = RATES.findIndex((rate) => rate >= clock.rate);
        const next = Math.min(RATES.length - 1, Math.max(0, index + action.steps));
        return this.setRate(RATES[next]);
      }
      case "loop":
        clock.loop = !clock.loop;
        return panels.showLoop(clock.loop);
      case "settings":
        return this.settings.toggle();
      case "fly":
        return this.fly(!this.viewpoint.flies);
      case "path":
        return this.viewpoint.playPath(!this.viewpoint.playsPath);
      case "compare":
        return this.comparison.toggle();
      case "next":
        return this.comparison.next();
      case "vr":
        return void this.toggleVr();
      case "share":
        return void this.share(false);
      case "embed":
        return void this.share(true);
      case "save":
        return void this.saveImage();
      case "numbers":
        return this.settings.toggleNumbers();
      case "part":
        return this.nextPart();
      case "mute":
        return clock.mute(clock.muted !== true);
      case "sound":
        return clock.startSound();
      case "reset":
        return this.viewpoint.reset();
      case "camera":
        return this.viewpoint.take(action.index);
      case "fullscreen":
        return panels.toggleFullscreen();
      case "help":
        return panels.toggleHelp();
    }
  }

  /** What another page may do with this one, in a frame of its own origin: window.tessera. */
  get handle() {
    return {
      play: () => this.clock.play(),
      pause: () => this.clock.pause(),
      seek: (seconds: number) => this.seek(seconds),
      camera: (name: string) => this.viewpoint.take(this.viewpoint.indexOf(name)),
      truth: (views: TruthView[]) => this.comparison.offer(views),
      replace: (address: string) => this.replace(address),
      view: () => this.viewpoint.word,
      settle: () => {
        this.viewpoint.finish();
        if (!this.view.inVr) this.frame(); // a key or a seek of just now
        return this.view.settle();
      },
      time: () => this.clock.now(),
      duration: () => this.info.time.duration,
    };
  }

  fail(error: unknown): void {
    this.panels.showLoading("", null, false);
    this.panels.showTrouble(lineOf(error));
  }
}

const page = new Page();
page.open().then(
  () => Object.assign(window, { tessera: page.handle }),
  (error: unknown) => page.fail(error),
);
