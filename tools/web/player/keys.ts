// The action of each key of the keyboard.

export type Action =
  | { do: "toggle" | "reset" | "fullscreen" | "loop" | "help" | "start" | "end" | "mute" | "sound" | "share" | "settings" | "fly" | "path" | "compare" | "next" | "vr" | "part" | "save" | "numbers" | "embed" }
  | { do: "step"; frames: number }
  | { do: "rate"; steps: number }
  | { do: "camera"; index: number };

/** `key`: as KeyboardEvent.key; null: none of ours. */
export function actionOf(key: string): Action | null {
  if (/^[1-9]$/.test(key)) return { do: "camera", index: Number(key) - 1 };
  switch (key) {
    case " ":
    case "k":
      return { do: "toggle" };
    case "ArrowLeft":
    case ",":
      return { do: "step", frames: -1 };
    case "ArrowRight":
    case ".":
      return { do: "step", frames: 1 };
    case "Home":
      return { do: "start" };
    case "End":
      return { do: "end" };
    case "[":
      return { do: "rate", steps: -1 };
    case "]":
      return { do: "rate", steps: 1 };
    case "r":
      return { do: "reset" };
    case "f":
      return { do: "fullscreen" };
    case "l":
      return { do: "loop" };
    case "c":
      return { do: "share" };
    case "o":
      return { do: "settings" };
    case "b":
      return { do: "part" };
    case "x":
      return { do: "save" };
    case "i":
      return { do: "numbers" };
    case "v":
      return { do: "fly" };
    case "p":
      return { do: "path" };
    case "t":
      return { do: "compare" };
    case "n":
      return { do: "next" };
    case "m":
      return { do: "mute" };
    case "?":
      return { do: "help" };
    default:
      return null;
  }
}

/** Keys that a focused control needs itself. */
export function isTheirs(target: EventTarget | null, key: string): boolean {
  if (target instanceof HTMLSelectElement) return key !== "f" && key !== "?";
  if (target instanceof HTMLButtonElement || target instanceof HTMLAnchorElement)
    return key === " " || key === "Enter";
  return target instanceof Element && target.closest("dialog") !== null;
}

export function listenToKeys(act: (action: Action) => void): void {
  addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || isTheirs(event.target, event.key)) return;
    const action = actionOf(event.key);
    if (action === null) return;
    event.preventDefault();
    act(action);
  });
}
