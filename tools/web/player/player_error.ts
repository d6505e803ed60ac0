// An error that the user of the page can act on: one line with the file and the remedy. Errors of
// the program itself stay ordinary errors.

export type Trouble = "network" | "data" | "device";

export class PlayerError extends Error {
  constructor(
    message: string,
    /** network: try again; data: the file is what it is; device: nothing can be drawn. */
    readonly trouble: Trouble = "data",
  ) {
    super(message);
    this.name = "PlayerError";
  }
}

/** The line to show for anything that was thrown. */
export function lineOf(error: unknown): string {
  return error instanceof Error ? error.message : String(error);
}

/** Whether a fetch was given up on purpose. */
export function isAbort(error: unknown): boolean {
  return error instanceof Error && error.name === "AbortError";
}
