// The page of a batch: failures first, then scene by scene its variants side by side.
import { makeCharts } from "./charts";
import type { Batch, Report, Run, SceneScores } from "./data";
import { runLinks, warningsList } from "./details";
import { details, facts, fileLink, make, section } from "./elements";
import { qualityChart } from "./quality_chart";
import { table } from "./tables";
import { pointsTable, scenesTable } from "./variants";
import { makeViewer } from "./viewer";
import { dateWords, decibels, fixed, optionWords, sizeWords, timeWords, wholeNumber } from "./words";

const MANY_SCENES = 3; // above, each is folded, and built when it is opened

function failuresSection(batch: Batch): HTMLElement | null {
  if (batch.failures.length === 0) return null;
  const items = batch.failures.map(({ line, log }) =>
    make("li", {}, line, log === "" ? null : make("span", {}, " (", fileLink(log, "log"), ")")));
  return section("Failures", make("div", { class: "card warnings" }, make("ul", {}, ...items)));
}

function runsOf(runs: Run[]): HTMLElement {
  return details(`${runs.length} runs`, table("runs", [
    { name: "run", cell: (run) => run.title, order: (run) => run.title },
    { name: "state", cell: (run) => run.error ?? run.state },
    { name: "steps", number: true, cell: (run) => wholeNumber(run.steps) },
    { name: "PSNR", number: true, cell: (run) => decibels(run.scores.psnr),
      order: (run) => run.scores.psnr },
    { name: "training", number: true, cell: (run) => timeWords(run.seconds.training),
      order: (run) => run.seconds.training },
    { name: "open", cell: runLinks },
  ], runs));
}

function sceneContent(scene: SceneScores, report: Report, batch: Batch): Node[] {
  const runs = report.runs.filter((run) => run.scene === scene.scene);
  const scored = runs.filter((run) => run.scores.psnr !== null);
  const shown = scored.filter((run) => run.views.length > 0)
    .map((run) => ({ ...run, title: run.variant ?? run.title }));
  const notes = new Set(runs.map((run) => run.image_note).filter((note) => note !== null));
  return [
    scene.split === "train"
      ? make("p", { class: "soft" }, "Scored on training views, as nothing is held out.") : null,
    warningsList(runs),
    pointsTable(scene, batch),
    qualityChart(scene, batch),
    makeViewer(shown)?.element ?? null,
    ...[...notes].map((note) => make("p", { class: "soft" }, note)),
    makeCharts(scored, (run) => run.variant ?? run.title)?.element ?? null,
    make("div", { class: "card" }, runsOf(runs)),
  ].filter((part) => part !== null);
}

function sceneSections(report: Report, batch: Batch): Node[] {
  if (batch.scenes.length <= MANY_SCENES)
    return batch.scenes.map((scene) => section(scene.scene, ...sceneContent(scene, report, batch)));
  const folded = batch.scenes.map((scene) => {
    const node = details(scene.scene);
    node.addEventListener("toggle", () => {
      if (node.childElementCount === 1) node.append(...sceneContent(scene, report, batch));
    });
    return node;
  });
  return [section("Scene by scene", ...folded)];
}

/** Finished runs that the batch does not request any more: their scores, and nothing made of them. */
function earlierSection(batch: Batch): HTMLElement | null {
  if (batch.earlier.length === 0) return null;
  const columns = table("runs of an earlier request", [
    { name: "run", cell: (run: Run) => run.id },
    { name: "steps", number: true, cell: (run: Run) => wholeNumber(run.steps) },
    { name: "PSNR", number: true, cell: (run: Run) => decibels(run.scores.psnr) },
    { name: "SSIM", number: true, cell: (run: Run) => fixed(run.scores.ssim, 4) },
    { name: "training", number: true, cell: (run: Run) => timeWords(run.seconds.training) },
    { name: "model", number: true, cell: (run: Run) => sizeWords(run.size.model_bytes) },
  ], batch.earlier);
  return section("Runs of an earlier request", make("p", { class: "soft" },
    "They are in the folder, but batch.yaml does not request them any more. No table, mean or " +
    "count above includes them."), details(`${batch.earlier.length} runs`, columns));
}

/** By which it can be repeated. */
function settings(batch: Batch): HTMLElement {
  const code = (text: string) => make("code", {}, text);
  return section("Versions, devices, options", make("div", { class: "card" }, facts([
    ["folder", code(batch.folder)],
    ["versions", batch.versions.join(", ")],
    ["devices", batch.devices.join("; ")],
    ...batch.variants.map((variant): [string, Node] => [
      `preset ${variant.name ?? ""}`,
      code([variant.preset ?? "", ...Object.entries(variant.options ?? {}).map(
        ([key, value]) => `${key}=${optionWords(value)}`)].join(" "))]),
    ...batch.captures.map((capture): [string, Node] => [
      `capture ${capture.name ?? ""}`,
      code([capture.path ?? "", ...(capture.ingest ?? [])].join(" "))]),
  ])), ...batch.notes.map((note) => make("p", { class: "soft" }, note)));
}

export function batchPage(report: Report, batch: Batch): Node[] {
  const { counts } = batch;
  const links = [fileLink("report.csv", "report.csv"), fileLink("report.json", "report.json")];
  const nothing = counts.done === 0 && counts.failed === 0 && batch.failures.length === 0;
  return [
    make("header", { class: "top" }, make("h1", {}, report.title),
      make("p", { class: "soft" }, `${batch.summary}. ${dateWords(report.made)}` +
        (batch.devices.length > 0 ? `, ${batch.devices.join("; ")}` : "")),
      make("nav", { class: "links", "aria-label": "files" }, ...links)),
    nothing ? make("p", { class: "card" },
      "Nothing is done yet. Run the batch, then make this report again.") : null,
    failuresSection(batch),
    batch.scenes.length > 1 ? section("All scenes", scenesTable(batch)) : null,
    ...sceneSections(report, batch),
    earlierSection(batch),
    settings(batch),
  ].filter((part) => part !== null);
}
