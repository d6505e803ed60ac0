// The sections with details of a run: decisions, stages, files, machine, all views and options.
import type { Decision, Run, View } from "./data";
import { button, card, details, detailsWhenOpened, facts, fileLink, make, section } from "./elements";
import { table, type Column } from "./tables";
import {
  dateWords, fixed, optionWords, shortNumber, sizeWords, timeWords, UNKNOWN, viewsWords,
  wholeNumber,
} from "./words";

export function warningsSection(runs: Run[]): HTMLElement | null {
  const list = warningsList(runs);
  return list && section("Warnings", list);
}

/** Each once, with the runs that have it. */
export function warningsList(runs: Run[]): HTMLElement | null {
  const found = new Map<string, { stage: string; text: string; titles: string[] }>();
  for (const run of runs)
    for (const { stage, text } of run.warnings) {
      const key = `${stage}: ${text}`;
      if (!found.has(key)) found.set(key, { stage, text, titles: [] });
      found.get(key)!.titles.push(run.title);
    }
  if (found.size === 0) return null;
  const items = [...found.values()].map(({ stage, text, titles }) => {
    const whose = titles.length === runs.length ? `all ${runs.length} runs` : titles.join(", ");
    return make("li", {}, make("strong", {}, stage), `: ${text}`,
      runs.length === 1 ? null : make("span", { class: "soft" }, ` (${whose})`));
  });
  return make("div", { class: "card warnings" }, make("ul", {}, ...items));
}

/** Links to the report and to the player of one of several runs. */
export function runLinks(run: Run): HTMLElement {
  const links = ["Report", "Player"].flatMap((name) => {
    const file = run.files.find((other) => other.name === name);
    return file === undefined ? [] : [" ", fileLink(file.path, name.toLowerCase())];
  });
  return make("span", {}, ...links);
}

export function decisionsTable(run: Run): HTMLElement | null {
  const { decisions } = run;
  if (decisions.length === 0) return null;
  const columns: Column<Decision>[] = [
    { name: "step", number: true, cell: ({ step }) => wholeNumber(step) },
    { name: "what", cell: ({ text }) => text },
  ];
  for (const set of ["static", "dynamic"] as const)
    if (decisions.some((decision) => decision[set] !== undefined))
      columns.push({ name: set, number: true,
        cell: (decision) => decision[set]?.map(wholeNumber).join(" → ") ?? UNKNOWN });
  return table("decisions", columns, decisions);
}

export const DECISIONS = "What the training decided";

export function foldedDecisions(run: Run): HTMLElement | null {
  const made = decisionsTable(run);
  return made && details(DECISIONS, made);
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
