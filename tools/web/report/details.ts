// The sections with details of a run: decisions, stages, files, machine, all views and options.
import type { Run, View } from "./data";
import { button, card, details, detailsWhenOpened, facts, fileLink, make, section } from "./elements";
import { table, type Column } from "./tables";
import {
  dateWords, fixed, optionWords, shortNumber, sizeWords, timeWords, viewsWords, wholeNumber,
} from "./words";

export function warningsSection(runs: Run[]): HTMLElement | null {
  const items = runs.flatMap((run) =>
    run.warnings.map(({ stage, text }) => {
      const from = runs.length > 1 ? `${run.title}, ${stage}` : stage;
      return make("li", {}, make("strong", {}, from), `: ${text}`);
    }),
  );
  if (items.length === 0) return null;
  return section("Warnings", make("div", { class: "card warnings" }, make("ul", {}, ...items)));
}

export function decisionsCard(run: Run): HTMLElement | null {
  if (run.decisions.length === 0) return null;
  const items = run.decisions.map(({ step, text }) =>
    make("li", {}, make("strong", {}, `Step ${wholeNumber(step)}.`), ` ${text}`),
  );
  return make("div", { class: "card" }, make("ol", { class: "decisions" }, ...items));
}

export function stagesCard(run: Run): HTMLElement | null {
  const longest = Math.max(0, ...run.stages.map((stage) => stage.seconds));
  if (longest <= 0) return null;
  const all = run.stages.reduce((sum, stage) => sum + stage.seconds, 0);
  const bars = run.stages.flatMap((stage) => {
    const bar = make("i");
    bar.style.width = `${((100 * stage.seconds) / longest).toFixed(1)}%`;
    return [make("span", {}, stage.name), bar, make("b", {}, timeWords(stage.seconds))];
  });
  return card(`Time, ${timeWords(all)} in all`, make("div", { class: "bars" }, ...bars));
}

export function filesCard(run: Run): HTMLElement | null {
  if (run.files.length === 0) return null;
  return card("Files", facts(run.files.map(({ name, path, bytes }) => [name, make("span", {},
    fileLink(path, path), bytes === null ? null : ` (${sizeWords(bytes)})`)])));
}

export function machineCard(run: Run): HTMLElement {
  return card("Command and machine", facts([
    ["version", run.version],
    ["preset", run.preset],
    ["seed", run.seed === null ? null : String(run.seed)],
    ["started", dateWords(run.started)],
    ["training", run.seconds.training === null ? null : timeWords(run.seconds.training)],
    ["peak memory", run.size.peak_bytes === null ? null : sizeWords(run.size.peak_bytes)],
    ["device", run.device],
    ["processor", run.cpu],
    ["host", run.host],
    ["command", run.command === "" ? null : make("code", {}, run.command)],
  ]));
}

/** `select` shows a view where it has images. */
export function viewsTable(run: Run, select: ((name: string) => void) | null): HTMLElement | null {
  if (run.views.length === 0) return null;
  const number = (name: string, value: (view: View) => number | null): Column<View> => ({
    name, number: true, order: value, cell: (view) => fixed(value(view), 2),
  });
  const nameCell = (view: View) =>
    select === null || (view.truth === null && view.result === null)
      ? view.name
      : button(view.name, () => select(view.name), { class: "plain" });
  const columns: Column<View>[] = [
    { name: "view", order: (view) => view.name, cell: nameCell },
    { name: "camera", order: (view) => view.camera, cell: (view) => view.camera },
    number("time", (view) => view.time),
    number("PSNR [dB]", (view) => view.psnr),
    number("moving pixels [dB]", (view) => view.psnr_dynamic),
    number("static pixels [dB]", (view) => view.psnr_static),
  ];
  const summary = `${run.views.length} ${viewsWords(run.split)} with their scores`;
  return detailsWhenOpened(summary, () => table("all views", columns, run.views));
}

export function optionsTable(run: Run): HTMLElement | null {
  const options = Object.entries(run.options);
  if (options.length === 0) return null;
  return details(`${shortNumber(options.length)} options of the training`, facts(
    options.map(([name, value]) => [name, make("code", {}, optionWords(value))])));
}
