// Chooses which blocks are loaded: those of the current time first, then those ahead in the
// direction of play. Fetches without a use are cancelled, and the least recently used block is
// freed first. A block is fetched by `load`, kept as an R and freed by `release`.
import { isAbort, lineOf, PlayerError } from "./player_error";

export interface Span {
  visible: [number, number]; // t
  /** Where its window is drawn, without the end; absent or null: always. */
  drawn?: [number, number] | null;
}

export interface Resident {
  memory: number; // bytes
}

export interface BlockHooks<R extends Resident> {
  load(index: number, signal: AbortSignal): Promise<R>;
  release(resident: R): void;
  /** A block has come, gone or failed. */
  onChange(): void;
}

export interface Look {
  t: number;
  /** How far ahead is fetched, in t; negative when time runs backwards, 0 when it stands. */
  ahead: number;
  /** Whether time continues at the other end. */
  loop: boolean;
}

type Slot<R> =
  | { state: "absent" }
  | { state: "loading"; abort: AbortController }
  | { state: "resident"; resident: R; used: number }
  | { state: "failed"; line: string; retryAt: number };

function isSeen({ visible, drawn }: Span, t: number): boolean {
  if (t < visible[0] || t > visible[1]) return false;
  return !drawn || (drawn[0] <= t && t < drawn[1]);
}

const AT_ONCE = 4; // fetches in flight
const RETRY_MS = 5000; // after a network's failure; what is damaged is not asked for again

export class BlockCache<R extends Resident> {
  private readonly slots: Slot<R>[];
  private look: Look = { t: 0, ahead: 0, loop: false };
  private uses = 0;
  private disposed = false;

  constructor(
    private readonly spans: readonly Span[],
    private readonly budget: number, // bytes
    private readonly hooks: BlockHooks<R>,
  ) {
    this.slots = spans.map(() => ({ state: "absent" }));
  }

  /** Indices of the blocks that are drawn at t. */
  at(t: number): number[] {
    return [...this.spans.keys()].filter((i) => isSeen(this.spans[i], t));
  }

  get(index: number): R | undefined {
    const slot = this.slots[index];
    return slot.state === "resident" ? slot.resident : undefined;
  }

  /** Whether a block of t is on its way. */
  waiting(t: number): boolean {
    return this.at(t).some((i) => ["loading", "absent"].includes(this.slots[i].state));
  }

  /** Why blocks of t are not here and will not come soon; null when none is missing. */
  trouble(t: number): string | null {
    for (const i of this.at(t)) {
      const slot = this.slots[i];
      if (slot.state === "failed") return slot.line;
    }
    return null;
  }

  /** Fetches, cancels and frees what this time requires. */
  update(look: Look): void {
    this.look = look;
    const now = this.at(look.t);
    const wanted = [...now, ...this.later(now)];
    const order = new Set(wanted);
    this.slots.forEach((slot, i) => {
      if (slot.state === "loading" && !order.has(i)) {
        slot.abort.abort();
        this.slots[i] = { state: "absent" };
      }
    });
    for (const i of now) {
      const slot = this.slots[i];
      if (slot.state === "resident") slot.used = ++this.uses;
    }
    this.start(wanted, now.length);
    this.evict(order);
  }

  /** Blocks that play will need, the soonest first. */
  private later(now: number[]): number[] {
    const { t, ahead, loop } = this.look;
    const known = new Set(now);
    const later: { i: number; distance: number }[] = [];
    this.spans.forEach(({ visible }, i) => {
      if (known.has(i)) return;
      const distance = this.distance(visible, t, ahead, loop);
      if (distance <= Math.abs(ahead)) later.push({ i, distance });
    });
    later.sort((a, b) => a.distance - b.distance);
    return later.map(({ i }) => i);
  }

  /** How far play must go from t until the span is seen. */
  private distance([from, to]: [number, number], t: number, ahead: number, loop: boolean): number {
    if (ahead >= 0) {
      if (from >= t) return from - t;
      return loop ? 1 - t + Math.max(0, from) : Infinity;
    }
    if (to <= t) return t - to;
    return loop ? t + 1 - Math.min(1, to) : Infinity;
  }

  /** The first `urgent` at any price, the rest within the budget. */
  private start(wanted: number[], urgent: number): void {
    let inFlight = this.slots.filter((slot) => slot.state === "loading").length;
    // others make room
    const full = this.memory(wanted) >= this.budget;
    for (const [place, i] of wanted.entries()) {
      if (inFlight >= AT_ONCE || (full && place >= urgent)) return;
      const slot = this.slots[i];
      const again = slot.state === "failed" && Date.now() >= slot.retryAt;
      if (slot.state !== "absent" && !again) continue;
      this.fetch(i);
      ++inFlight;
    }
  }

  private fetch(i: number): void {
    const slot: Slot<R> = { state: "loading", abort: new AbortController() };
    this.slots[i] = slot;
    this.hooks.load(i, slot.abort.signal).then(
      (resident) => {
        if (this.disposed || this.slots[i] !== slot) return this.hooks.release(resident);
        this.slots[i] = { state: "resident", resident, used: ++this.uses };
        this.settled();
      },
      (error: unknown) => {
        if (this.disposed || this.slots[i] !== slot) return;
        if (isAbort(error)) {
          this.slots[i] = { state: "absent" };
        } else {
          const network = error instanceof PlayerError && error.trouble === "network";
          const retryAt = network ? Date.now() + RETRY_MS : Infinity;
          this.slots[i] = { state: "failed", line: lineOf(error), retryAt };
        }
        this.settled();
      },
    );
  }

  private settled(): void {
    this.update(this.look);
    this.hooks.onChange();
  }

  /** Bytes of these blocks, as far as they are here. */
  private memory(indices: Iterable<number>): number {
    let sum = 0;
    for (const i of indices) sum += this.get(i)?.memory ?? 0;
    return sum;
  }

  private evict(keep: Set<number>): void {
    const here: { i: number; resident: R; used: number }[] = [];
    this.slots.forEach((slot, i) => {
      if (slot.state === "resident") here.push({ i, resident: slot.resident, used: slot.used });
    });
    let memory = this.memory(this.slots.keys());
    here.sort((a, b) => a.used - b.used);
    for (const { i, resident } of here) {
      if (memory <= this.budget) return;
      if (keep.has(i)) continue;
      memory -= resident.memory;
      this.slots[i] = { state: "absent" };
      this.hooks.release(resident);
    }
  }

  dispose(): void {
    this.disposed = true;
    for (const slot of this.slots) {
      if (slot.state === "loading") slot.abort.abort();
      if (slot.state === "resident") this.hooks.release(slot.resident);
    }
    this.slots.fill({ state: "absent" });
  }
}
