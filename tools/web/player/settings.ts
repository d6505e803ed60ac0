// The settings of drawing and camera in the panel of the page, and what the browser stores of them
// for the next visit.

export interface Settings {
  resolution: number; // share of the display's pixels
  shDegree: number; // highest degree of the colours that is drawn, 0 to 3
  frameRate: number; // most images a second; 0: as many as the display shows
  background: string; // "": of the scene; else a colour as in the address
  stay: boolean; // within what the cameras have seen
  numbers: boolean; // images a second and sizes are shown
}

const KEY = "tessera-settings";
const PLAIN: Settings = {
  resolution: 1,
  shDegree: 3,
  frameRate: 0,
  background: "",
  stay: true,
  numbers: false,
};
const BACKGROUNDS = ["", "000000", "808080", "ffffff"];

/** Values of another version or of another page are left out. */
export function settingsOf(text: string | null): Settings {
  let kept: Partial<Record<keyof Settings, unknown>> = {};
  try {
    kept = (JSON.parse(text ?? "{}") ?? {}) as typeof kept;
  } catch {
    // not ours: the plain settings
  }
  const oneOf = (value: unknown, choices: number[], plain: number) =>
    choices.includes(value as number) ? (value as number) : plain;
  return {
    resolution: oneOf(kept.resolution, [0.5, 0.75, 1], PLAIN.resolution),
    shDegree: oneOf(kept.shDegree, [0, 1, 2, 3], PLAIN.shDegree),
    frameRate: oneOf(kept.frameRate, [0, 30, 15], PLAIN.frameRate),
    background: BACKGROUNDS.find((colour) => colour === kept.background) ?? PLAIN.background,
    stay: typeof kept.stay === "boolean" ? kept.stay : PLAIN.stay,
    numbers: typeof kept.numbers === "boolean" ? kept.numbers : PLAIN.numbers,
  };
}

function control(id: string): HTMLInputElement & HTMLSelectElement {
  return document.getElementById(`set-${id}`) as HTMLInputElement & HTMLSelectElement;
}

export class SettingsPanel {
  readonly settings = settingsOf(SettingsPanel.kept());
  /** Told when flight is switched on or off; a page always opens without it. */
  onFly: (on: boolean) => void = () => {};
  private changed: () => void = () => {};

  /** `onChange`: told of every change; `canStay`: whether the scene has cameras to stay with. */
  constructor(onChange: () => void, canStay: boolean) {
    const { settings } = this;
    for (const name of ["resolution", "shDegree", "frameRate"] as const) {
      control(name).value = String(settings[name]);
      control(name).addEventListener("change", () => {
        settings[name] = Number(control(name).value);
        this.keep();
        onChange();
      });
    }
    control("background").value = settings.background;
    control("background").addEventListener("change", () => {
      settings.background = control("background").value;
      this.keep();
      onChange();
    });
    control("stay").disabled = !canStay;
    for (const name of ["stay", "numbers"] as const) {
      control(name).checked = settings[name];
      control(name).addEventListener("change", () => this.setFlag(name, control(name).checked));
    }
    this.changed = onChange;
    this.showFly(false);
    control("fly").addEventListener("change", () => this.onFly(control("fly").checked));
  }

  private setFlag(name: "stay" | "numbers", on: boolean): void {
    this.settings[name] = on;
    this.keep();
    this.changed();
  }

  toggleNumbers(): void {
    control("numbers").checked = !this.settings.numbers;
    this.setFlag("numbers", !this.settings.numbers);
  }

  showFly(on: boolean): void {
    control("fly").checked = on;
  }

  toggle(): void {
    const dialog = document.getElementById("settings") as HTMLDialogElement;
    if (dialog.open) dialog.close();
    else dialog.showModal();
  }

  private static kept(): string | null {
    try {
      return localStorage.getItem(KEY);
    } catch {
      return null; // a page in a sandboxed frame
    }
  }

  private keep(): void {
    try {
      localStorage.setItem(KEY, JSON.stringify(this.settings));
    } catch {
      // a page in a sandboxed frame: until it is closed
    }
  }
}
