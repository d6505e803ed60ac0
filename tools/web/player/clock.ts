// The time of the clip: wall-clock time times rate, never a count of frames; with audio, the audio
// is the clock. There is no timer: callers read the time.

export interface Sound {
  currentTime: number; // seconds
  playbackRate: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  muted: boolean;
  play(): Promise<void>;
  pause(): void;
}

const SLOWEST = 0.0625; // rates that browsers play sound at
const FASTEST = 16;

/** A part of the clip that is played over and over, seconds. */
export interface Part {
  from: number;
  to: number;
}

export class Clock {
  loop = true;
  private part: Part | null = null;
  private speed = 1;
  private running = false;
  private held = false;
  private refused = false; // the browser plays no sound before the page is touched
  private anchor = { seconds: 0, wall: 0 };

  /** `duration`: seconds; `wall`: seconds of any steady clock. */
  constructor(
    readonly duration: number,
    private readonly wall: () => number,
    private readonly sound: Sound | null = null,
  ) {
    this.anchor.wall = wall();
  }

  get playing(): boolean {
    return this.running;
  }

  get rate(): number {
    return this.speed;
  }

  /** null: there is no sound. */
  get muted(): boolean | null {
    return this.sound === null ? null : this.sound.muted;
  }

  /** Whether the browser has refused to play the sound until the page is tapped. */
  get soundBlocked(): boolean {
    return this.refused;
  }

  private get ticking(): boolean {
    return this.running && !this.held;
  }

  private get sounding(): boolean {
    const { sound } = this;
    return sound !== null && !sound.paused && !sound.ended && !sound.seeking;
  }

  /** Seconds since the start of the clip. Stops at the end, or starts again. */
  now(): number {
    const wall = this.wall();
    if (this.ticking) {
      this.anchor.seconds =
        this.sounding && this.sound !== null
          ? this.sound.currentTime
          : this.anchor.seconds + (wall - this.anchor.wall) * this.speed;
      if (this.anchor.seconds >= this.end) this.wrap();
    }
    this.anchor.wall = wall;
    return this.anchor.seconds;
  }

  private get end(): number {
    return this.part?.to ?? this.duration;
  }

  /** null: all of the clip. A time outside of the part goes to its start. */
  setPart(part: Part | null): void {
    this.part = part;
    const now = this.now();
    if (part !== null && (now < part.from || now > part.to)) this.seek(part.from);
  }

  private wrap(): void {
    if (this.part !== null) {
      this.anchor.seconds = this.part.from;
      this.tellSound();
    } else if (this.loop && this.duration > 0) {
      this.anchor.seconds %= this.duration;
      this.tellSound();
    } else {
      this.anchor.seconds = this.duration;
      this.pause();
    }
  }

  seek(seconds: number): void {
    this.now();
    this.anchor.seconds = Math.min(Math.max(0, seconds), this.duration);
    this.tellSound();
  }

  play(): void {
    if (this.now() >= this.duration) this.anchor.seconds = 0;
    this.running = this.duration > 0;
    this.tellSound();
  }

  pause(): void {
    if (this.running) this.running = false;
    this.sound?.pause();
  }

  setRate(rate: number): void {
    this.now();
    this.speed = rate;
    this.tellSound();
  }

  mute(muted: boolean): void {
    if (this.sound !== null) this.sound.muted = muted;
  }

  /** Tries again to play a sound that the browser refused; to be called from a tap. */
  startSound(): void {
    this.now();
    this.tellSound();
  }

  /** Time stands while data is awaited. */
  hold(held: boolean): void {
    if (held === this.held) return;
    this.now();
    this.held = held;
    this.tellSound();
  }

  /** The sound goes where the clock is. */
  private tellSound(): void {
    const { sound } = this;
    if (sound === null) return;
    sound.currentTime = this.anchor.seconds;
    sound.playbackRate = Math.min(FASTEST, Math.max(SLOWEST, this.speed));
    if (!this.ticking) sound.pause();
    else
      sound.play().then(
        () => (this.refused = false),
        (error: unknown) => this.soundFailed(sound, error),
      );
  }

  /** Not allowed yet, no file, or paused before it began: the wall clock runs. */
  private soundFailed(sound: Sound, error: unknown): void {
    if ((error as { name?: string }).name === "AbortError") return;
    this.refused = (error as { name?: string }).name === "NotAllowedError";
    sound.pause();
  }
}
