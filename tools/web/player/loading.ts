// Computes how much of the data of the current image has arrived, and the line of text about it.

export interface Progress {
  bytes: number; // arrived
  needed: number; // 0: not known
}

/** Bytes that have arrived of several files or blocks. */
export class Arrivals {
  private readonly arrived: number[];
  private readonly sizes: (number | null)[];

  /** `sizes`: bytes of each; null: not known before it has arrived. */
  constructor(
    sizes: readonly (number | null)[],
    private readonly onChange: () => void,
  ) {
    this.sizes = [...sizes];
    this.arrived = sizes.map(() => 0);
  }

  /** Nothing of the i-th is here: its transfer begins, perhaps once more. */
  begin(i: number): void {
    this.set(i, 0);
  }

  add(i: number, bytes: number): void {
    this.set(i, this.arrived[i] + bytes);
  }

  end(i: number): void {
    this.sizes[i] ??= this.arrived[i];
    this.set(i, this.sizes[i]!);
  }

  private set(i: number, bytes: number): void {
    this.arrived[i] = bytes;
    this.onChange();
  }

  of(indices: readonly number[]): Progress {
    const known = indices.every((i) => this.sizes[i] !== null);
    const sum = (values: readonly (number | null)[]) =>
      indices.reduce((total, i) => total + (values[i] ?? 0), 0);
    return { bytes: sum(this.arrived), needed: known ? sum(this.sizes) : 0 };
  }
}

function size(bytes: number): string {
  return bytes < 1e6 ? `${Math.ceil(bytes / 1e3)} kB` : `${(bytes / 1e6).toFixed(1)} MB`;
}

/** Before the first image is on the screen. */
export function loadingLine({ bytes, needed }: Progress): string {
  if (needed === 0) return bytes === 0 ? "Loading" : `Loading: ${size(bytes)}`;
  if (bytes >= needed) return "Preparing the first image";
  return `Loading: ${Math.floor((100 * bytes) / needed)} % of ${size(needed)}`;
}

/** Of the bar: 0 to 1. */
export function loadedShare({ bytes, needed }: Progress): number {
  return needed > 0 ? Math.min(1, bytes / needed) : 0;
}
