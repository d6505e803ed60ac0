// The page of a running training, which `tessera view` serves: the model as it is now, numbers and
// curves; it can stop the training, and says how it is resumed.
import { makeCharts, type Charts } from "./charts";
import type { Run } from "./data";
import { DECISIONS, decisionsTable, warningsSection } from "./details";
import { button, card, facts, make } from "./elements";
import { fixed, sizeWords, timeWords, wholeNumber } from "./words";
import "./live.css";

const POLL_MS = 1000;
const REPORT_EVERY = 3; // polls

interface State {
  training: string;
  step: number;
  total: number;
  loss: number | null;
  steps_per_second: number;
  seconds_left: number;
  num_static: number;
  num_dynamic: number;
  device_bytes: number;
  snapshot: number;
  snapshot_step: number;
}

interface Answer {
  name: string;
  alive: boolean;
  state: State | null;
  snapshot: string; // address, or ""
  complete: boolean;
  page: string; // address of the finished player, or ""
  stopped: { step: number; total: number } | null;
  resume: string; // a command, or ""
  views: unknown[]; // to compare with in the player
  scores: [step: number, psnr: number][];
}

/** What the player in the frame offers. */
interface Player {
  replace(address: string): Promise<void>;
  truth(views: unknown[]): void;
}

class LivePage {
  private readonly name = make("h1", { id: "name" }, "Training");
  private readonly status = make("p", { id: "status", role: "status" }, "waiting for the training");
  private readonly stop = button("Stop with a checkpoint", () => this.post(this.stop, "/api/stop"),
    { id: "stop", hidden: true });
  private readonly finished = make("a", { id: "finished", class: "button", hidden: true },
    "Open the finished player");
  private readonly share = make("div");
  private readonly bar = make("div", { id: "bar", role: "progressbar", "aria-label": "steps",
    "aria-valuemin": 0, "aria-valuemax": 100 }, this.share);
  private readonly empty = make("p", { id: "empty" },
    "The first copy of the model arrives some seconds after the first step.");
  private readonly player = make("iframe", { id: "player", title: "model as it is now",
    hidden: true });
  private readonly numbers = make("div", { id: "numbers" });
  private readonly command = make("code");
  private readonly resume = make("p", { id: "resume", hidden: true }, "Resume it with: ",
    this.command);
  private readonly curves = make("div", { id: "charts" });
  private readonly told = make("div");
  private charts: Charts | null = null;
  private shown = 0; // number of the snapshot in the player,
  private shownStep = 0; // its step,
  private training = ""; // and the training that made it
  private loading = false;
  private offered = false; // whether the player has the held-out views

  readonly elements = [
    make("header", { class: "live" }, this.name, this.status, this.stop, this.finished),
    this.bar,
    make("div", { class: "live" }, make("section", { id: "model" }, this.empty, this.player),
      make("aside", {}, this.numbers, this.resume, this.curves, this.told)),
  ];

  async follow(): Promise<never> {
    for (let polls = 0; ; ++polls) {
      try {
        const address = `/api/state?seen=${this.shown}`;
        this.show((await (await fetch(address)).json()) as Answer);
        if (polls % REPORT_EVERY === 0) await this.report();
      } catch {
        this.status.textContent = "tessera view does not answer any more";
      }
      await new Promise((resolve) => setTimeout(resolve, POLL_MS));
    }
  }

  private inside(): Player | undefined {
    return (this.player.contentWindow as (Window & { tessera?: Player }) | null)?.tessera;
  }

  private show(answer: Answer): void {
    document.title = `${answer.name} – Tessera`;
    this.name.textContent = answer.name;
    this.tell(answer);
    if (!this.offered && answer.views.length > 0 && this.inside()) {
      this.inside()!.truth(answer.views);
      this.offered = true;
    }
    const { state } = answer;
    if (state === null) return;
    if (state.training !== this.training) {
      this.training = state.training;
      this.shown = 0;
    }
    this.tellNumbers(state, answer.scores);
    if (answer.snapshot !== "" && state.snapshot > this.shown)
      void this.load(state.snapshot, answer.snapshot, state.snapshot_step);
  }

  /** The player with its first snapshot, or the next one in its place. */
  private async load(number: number, address: string, step: number): Promise<void> {
    if (this.loading) return;
    this.loading = true;
    try {
      if (this.inside()) {
        await this.inside()!.replace(address);
      } else {
        this.player.src = `/api/player?scene=${encodeURIComponent(address)}&paused=1`;
        await new Promise((resolve) => this.player.addEventListener("load", resolve, { once: true }));
        for (let i = 0; i < 600 && !this.inside(); ++i)
          await new Promise((resolve) => setTimeout(resolve, 100));
        this.player.hidden = false;
        this.empty.hidden = true;
      }
      this.shown = number;
      this.shownStep = step;
    } catch (error) {
      this.status.textContent = `the snapshot could not be shown: ${(error as Error).message}`;
    } finally {
      this.loading = false;
    }
  }

  private tellNumbers(state: State, scores: Answer["scores"]): void {
    const psnr = scores.length > 0 ? `${fixed(scores[scores.length - 1][1], 2)} dB` : "–";
    this.numbers.replaceChildren(facts([
      ["PSNR, held out", psnr],
      ["step", `${wholeNumber(state.step)} / ${wholeNumber(state.total)}`],
      ["loss", fixed(state.loss, 4)],
      ["static Gaussians", wholeNumber(state.num_static)],
      ["dynamic Gaussians", wholeNumber(state.num_dynamic)],
      ["speed", `${fixed(state.steps_per_second, 1)} steps/s`],
      ["memory", sizeWords(state.device_bytes)],
      ["model shown", this.shownStep > 0 ? `step ${wholeNumber(this.shownStep)}` : "–"],
    ]));
  }

  private tell({ state, alive, complete, page, stopped, resume }: Answer): void {
    const left = state ? state.seconds_left : NaN;
    const status = alive
      ? `training · ${Number.isFinite(left) ? timeWords(left) : "–"} left`
      : complete ? "the training is complete"
      : stopped
        ? `the training has stopped after ${wholeNumber(stopped.step)} of ` +
          `${wholeNumber(stopped.total)} steps`
      : "the training has stopped";
    const known = state !== null || complete || stopped !== null;
    if (known) this.status.textContent = status;
    else if (alive) this.status.textContent = "training";
    this.stop.hidden = !alive;
    this.finished.hidden = page === "";
    if (page !== "") this.finished.href = page;
    this.resume.hidden = resume === "";
    this.command.textContent = resume;
    if (!alive) this.stop.disabled = false;
    if (!alive && known) this.empty.textContent = `${status[0].toUpperCase()}${status.slice(1)}.`;
    const share = complete ? 100 : state ? (100 * state.step) / Math.max(1, state.total) : 0;
    this.share.style.width = `${share}%`;
    this.bar.setAttribute("aria-valuenow", share.toFixed(0));
  }

  /** Curves, warnings and decisions so far. */
  private async report(): Promise<void> {
    const run = (await (await fetch("/api/report")).json()) as Run | null;
    if (run === null) return;
    if (!this.charts?.show([run])) {
      this.charts = makeCharts([run]);
      this.curves.replaceChildren(...(this.charts ? [this.charts.element] : []));
    }
    const decisions = decisionsTable(run);
    const parts = [warningsSection([run]), decisions && card(DECISIONS, decisions)];
    this.told.replaceChildren(...parts.filter((part) => part !== null));
  }

  private async post(pressed: HTMLButtonElement, address: string): Promise<void> {
    pressed.disabled = true;
    if (!(await fetch(address, { method: "POST" })).ok) pressed.disabled = false;
  }
}

export function livePage(): Node[] {
  const page = new LivePage();
  document.body.classList.add("live");
  void page.follow();
  return page.elements;
}
