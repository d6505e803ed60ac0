// Checked fields of a JSON object: the error of a wrong one names file and key.
import { PlayerError } from "./player_error";

/** Reads fields of one JSON object; every complaint names the file and the key. */
export class Fields {
  private readonly object: Record<string, unknown>;
  constructor(
    value: unknown,
    private readonly file: string,
    private readonly path: string,
  ) {
    if (typeof value !== "object" || value === null || Array.isArray(value))
      throw this.wrong(path || "the manifest", "an object", value);
    this.object = value as Record<string, unknown>;
  }
  wrong(key: string, expected: string, seen: unknown): PlayerError {
    const text = JSON.stringify(seen) ?? "nothing";
    return new PlayerError(
      `${this.file}: ${key} should be ${expected}, saw ${text.slice(0, 40)}; ` +
        `export the scene again`,
    );
  }
  private key(name: string): string {
    return this.path ? `${this.path}.${name}` : name;
  }
  has(name: string): boolean {
    return this.object[name] !== undefined && this.object[name] !== null;
  }
  raw(name: string): unknown {
    return this.object[name];
  }
  number(name: string, fallback?: number): number {
    const value = this.object[name];
    if (value === undefined && fallback !== undefined) return fallback;
    if (typeof value !== "number" || !Number.isFinite(value))
      throw this.wrong(this.key(name), "a number", value);
    return value;
  }
  /** An integer from `least` to `limit`. */
  size(name: string, limit: number, least = 0): number {
    const value = this.object[name];
    if (typeof value !== "number" || !Number.isSafeInteger(value) || value < least || value > limit)
      throw this.wrong(this.key(name), `an integer from ${least} to ${limit}`, value);
    return value;
  }
  text(name: string): string {
    const value = this.object[name];
    if (typeof value !== "string") throw this.wrong(this.key(name), "a string", value);
    return value;
  }
  flag(name: string, fallback: boolean): boolean {
    const value = this.object[name] ?? fallback;
    if (typeof value !== "boolean") throw this.wrong(this.key(name), "true or false", value);
    return value;
  }
  numbers(name: string, count: number): number[] {
    const value = this.object[name];
    if (!Array.isArray(value) || value.length !== count || !value.every(Number.isFinite))
      throw this.wrong(this.key(name), `${count} numbers`, value);
    return value as number[];
  }
  triple(name: string): [number, number, number] {
    return this.numbers(name, 3) as [number, number, number];
  }
  within(name: string): Fields {
    return new Fields(this.object[name], this.file, this.key(name));
  }
  list<T>(name: string, make: (item: Fields, i: number) => T): T[] {
    const value = this.object[name] ?? [];
    if (!Array.isArray(value)) throw this.wrong(this.key(name), "a list", value);
    return value.map((item, i) => make(new Fields(item, this.file, `${this.key(name)}[${i}]`), i));
  }
}
