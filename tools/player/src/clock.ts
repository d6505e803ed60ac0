// What: the time of the clip: wall-clock time times rate, never a count of frames; where there is
//       sound, the sound is the clock.
// Not: drawing, and no timer: whoever wants to know asks.

export interface Sound {
  currentTime: number; // seconds
  playbackRate: number;
  readonly paused: boolean;
  readonly ended: boolean;
  readonly seeking: boolean;
  play(): Promise<void>;
  pause(): void;
}

const SLOWEST = 0.0625; // rates that browsers play sound at
const FASTEST = 16;

export class Clock {
  loop = true;
  private speed = 1;
  private running = false;
  private held = false;
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
      if (this.anchor.seconds >= this.duration) this.wrap();
    }
    this.anchor.wall = wall;
    return this.anchor.seconds;
  }

  private wrap(): void {
    if (this.loop && this.duration > 0) {
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
    else sound.play().catch(() => sound.pause()); // not allowed yet, or no file: the wall clock runs
  }
}
