// The page of several runs: scores side by side, views by name, curves over each other, and options
// that differ.
import { makeCharts } from "./charts";
import type { Report, Run } from "./data";
import {
  filesCard, foldedDecisions, machineCard, runLinks, stagesCard, warningsSection,
} from "./details";
import { details, make, section } from "./elements";
import { summaryOf } from "./run";
import { table, type Column } from "./tables";
import { makeViewer } from "./viewer";
import {
  dateWords, decibels, fixed, optionWords, shortNumber, sizeWords, timeWords, UNKNOWN, wholeNumber,
} from "./words";

/** A score by which runs are ordered; the best is marked. */
function score(
  runs: Run[],
  name: string,
  value: (run: Run) => number | null,
  words: (value: number | null) => string,
  better: "high" | "low" | "",
): Column<Run> | null {
  const known = runs.map(value).filter((number) => number !== null);
  if (known.length === 0) return null;
  const best = better === "high" ? Math.max(...known) : better === "low" ? Math.min(...known) : NaN;
  const differ = new Set(known).size > 1;
  const cell = (run: Run) => {
    const text = words(value(run));
    return differ && value(run) === best ? make("strong", { title: "best" }, text) : text;
  };
  return { name, number: true, order: value, cell };
}

function scoreTable(runs: Run[]): HTMLElement {
  const text = (name: string, value: (run: Run) => string): Column<Run> => ({
    name, order: value, cell: value,
  });
  const columns = [
    text("run", (run) => (run.state === "unfinished" ? `${run.title} (unfinished)` : run.title)),
    text("preset", (run) => run.preset || UNKNOWN),
    score(runs, "steps", (run) => run.steps, (steps) => wholeNumber(steps ?? 0), ""),
    score(runs, "PSNR", (run) => run.scores.psnr, decibels, "high"),
    score(runs, "moving pixels", (run) => run.scores.psnr_dynamic, decibels, "high"),
    score(runs, "static pixels", (run) => run.scores.psnr_static, decibels, "high"),
    score(runs, "SSIM", (run) => run.scores.ssim, (value) => fixed(value, 4), "high"),
    score(runs, "LPIPS", (run) => run.scores.lpips, (value) => fixed(value, 4), "low"),
    score(runs, "lowest timestep", (run) => run.worst && run.worst.psnr, decibels, "high"),
    score(runs, "command", (run) => run.seconds.command, timeWords, "low"),
    score(runs, "player page", (run) => run.size.player_bytes, sizeWords, "low"),
    score(runs, "static", (run) => run.size.static, (count) => shortNumber(count ?? 0), ""),
    score(runs, "dynamic", (run) => run.size.dynamic, (count) => shortNumber(count ?? 0), ""),
    runs.some((run) => runLinks(run).hasChildNodes()) ? { name: "open", cell: runLinks } : null,
  ].filter((column) => column !== null);
  return make("div", { class: "card" }, table("scores of the runs", columns, runs),
    make("p", { class: "soft" }, "Static and dynamic: numbers of Gaussians. Bold: the best."));
}

interface Difference {
  stage: "ingest" | "train";
  name: string;
  values: string[]; // of the runs
}

/** Options of which two runs that have any differ, and what the trainings began with. */
function differences(runs: Run[]): Difference[] {
  const optionsOf = (stage: Difference["stage"], key: "ingest_options" | "options") => {
    const known = runs.filter((run) => Object.keys(run[key]).length > 0);
    const words = (run: Run, name: string) => optionWords(run[key][name]);
    return [...new Set(known.flatMap((run) => Object.keys(run[key])))]
      .filter((name) => new Set(known.map((run) => words(run, name))).size > 1)
      .map((name): Difference => ({ stage, name, values: runs.map((run) => words(run, name)) }));
  };
  const points = runs.map((run) => run.initial_points || UNKNOWN);
  const made = optionsOf("ingest", "ingest_options");
  if (new Set(points).size > 1) made.push({ stage: "train", name: "initial points", values: points });
  return [...made, ...optionsOf("train", "options")];
}

function differingOptions(runs: Run[]): HTMLElement {
  const rows = differences(runs);
  if (rows.length === 0) return make("p", { class: "soft" }, "All options are the same.");
  const columns: Column<Difference>[] = [
    { name: "option", cell: ({ name }) => make("code", {}, name) },
    { name: "of", cell: ({ stage }) => stage },
    ...runs.map((run, i) => ({
      name: run.title,
      cell: ({ values }: Difference) => make("code", {}, values[i]),
    })),
  ];
  return make("div", { class: "card" }, table("options that differ", columns, rows));
}

export function comparisonPage(report: Report): Node[] {
  const { runs } = report;
  const viewer = makeViewer(runs);
  const each = runs.map((run) =>
    details(`${run.title}: ${summaryOf(run)}`, foldedDecisions(run),
      make("div", { class: "pair" }, stagesCard(run), filesCard(run), machineCard(run))));
  return [
    make("header", { class: "top" }, make("h1", {}, report.title),
      make("p", { class: "soft" }, `${runs.length} runs, compared ${dateWords(report.made)}`)),
    section("Scores", scoreTable(runs)),
    warningsSection(runs),
    viewer?.element ?? null,
    makeCharts(runs)?.element ?? null,
    section("Options that differ", differingOptions(runs)),
    section("Runs", ...each),
  ].filter((part) => part !== null);
}
