// The page of one run: its sections, from the most important to the details.
import { camerasSection } from "./cameras";
import { makeCharts } from "./charts";
import type { Run } from "./data";
import {
  filesCard, foldedDecisions, machineCard, optionsTable, stagesCard, viewsTable, warningsSection,
} from "./details";
import { fileLink, make, section } from "./elements";
import { makeViewer } from "./viewer";
import { windowsSection, windowTiles, type Tile } from "./windows";
import {
  dateWords, decibels, fixed, shortNumber, sizeWords, timeWords, viewsWords, wholeNumber,
} from "./words";

const MOST_OBJECTS = 3; // that a tile names
const TILES_A_ROW: [string, number][] = [["wide", 5], ["middle", 3], ["narrow", 2]]; // of report.css

export function summaryOf(run: Run): string {
  const windows = run.windows?.length ?? 0;
  const parts = [`${wholeNumber(run.steps)} steps${windows > 0 ? ` in ${windows} windows` : ""}`];
  if (run.preset !== "") parts.push(`preset ${run.preset}`);
  if (run.started !== "") parts.push(`started ${dateWords(run.started)}`);
  if (run.state === "unfinished") parts.push("unfinished");
  return parts.join(", ");
}

function head(run: Run, title: string): HTMLElement {
  const links = run.files.map((file, i) =>
    fileLink(file.path, file.name, i === 0 ? { class: "first" } : {}),
  );
  return make("header", { class: "top" }, make("h1", {}, title),
    make("p", { class: "soft" }, summaryOf(run)),
    links.length > 0 ? make("nav", { class: "links", "aria-label": "files" }, ...links) : null);
}

function objectTile(objects: Run["objects"]): Tile {
  const sorted = [...objects].sort((a, b) => a.psnr - b.psnr);
  const named = sorted.slice(0, MOST_OBJECTS).map(({ name, psnr }) => `${name} ${fixed(psnr, 1)}`);
  const others = sorted.length - named.length;
  if (others > 0) named.push(`${others} more`);
  return ["Lowest object", decibels(sorted[0].psnr), named.join(", ")];
}

/** Tiles whose value is known. */
function tiles(run: Run): Tile[] {
  const { scores, size, worst } = run;
  const made: Tile[] = [];
  const add = (name: string, known: number | null, value: string, more = "") => {
    if (known !== null) made.push([name, value, more]);
  };
  const fit = scores.psnr_fit === null ? "" : `after the gains of cameras ${decibels(scores.psnr_fit)}`;
  add("PSNR", scores.psnr, decibels(scores.psnr), fit);
  const still = scores.psnr_static === null ? "" : `static pixels ${decibels(scores.psnr_static)}`;
  add("Moving pixels", scores.psnr_dynamic, decibels(scores.psnr_dynamic), still);
  add("SSIM", scores.ssim, fixed(scores.ssim, 4));
  add("LPIPS", scores.lpips, fixed(scores.lpips, 4));
  add("Lowest timestep", worst && worst.psnr, decibels(worst && worst.psnr),
    worst === null ? "" : `frame ${wholeNumber(worst.frame_number)}`);
  if (run.objects.length > 0) made.push(objectTile(run.objects));
  made.push(...windowTiles(run));
  const training = run.seconds.training;
  add("Whole command", run.seconds.command, timeWords(run.seconds.command),
    training === null ? "" : `training ${timeWords(training)}`);
  add("Player page", size.player_bytes, sizeWords(size.player_bytes),
    size.model_bytes === null ? "" : `model ${sizeWords(size.model_bytes)}`);
  if (size.player_bytes === null) add("Model", size.model_bytes, sizeWords(size.model_bytes));
  made.push(["Gaussians", shortNumber(size.static + size.dynamic),
    `${shortNumber(size.static)} static + ${shortNumber(size.dynamic)} dynamic`]);
  return made;
}

/** Of the tile `index` of `count`, where rows of at most `most` are as even as can be. */
export function tilesBeside(index: number, count: number, most: number): number {
  const rows = Math.ceil(count / most);
  const fewer = Math.floor(count / rows);
  const longer = count - rows * fewer; // rows, the first ones, of one tile more
  return index < longer * (fewer + 1) ? fewer + 1 : fewer;
}

function scores(run: Run): HTMLElement {
  const made = tiles(run);
  const nodes = made.map(([name, value, more], i) => {
    const tile = make("div", {}, make("dt", {}, name), make("dd", {}, value),
      more === "" ? null : make("dd", { class: "more" }, more));
    for (const [width, most] of TILES_A_ROW)
      tile.style.setProperty(`--${width}`, String(tilesBeside(i, made.length, most)));
    return tile;
  });
  const count = run.views.length;
  const seen = run.verdict && `${run.verdict[0].toUpperCase()}${run.verdict.slice(1)}. `;
  const note = count === 0 ? null : `${seen}Scores are means over ${count} ${viewsWords(run.split)}.`;
  return make("div", {}, make("dl", { class: "scores" }, ...nodes),
    note === null ? null : make("p", { class: "soft" }, note));
}

export function runPage(run: Run, title: string): Node[] {
  const viewer = makeViewer([run]);
  const noImages = run.image_note === null ? null
    : section("Views", make("p", { class: "soft" }, run.image_note));
  const decisions = foldedDecisions(run);
  const views = viewsTable(run, viewer && ((name) => viewer.select(name)));
  const options = optionsTable(run);
  const facts = [stagesCard(run), filesCard(run), machineCard(run)];
  return [
    head(run, title),
    scores(run),
    warningsSection([run]),
    windowsSection(run),
    viewer?.element ?? noImages,
    makeCharts([run])?.element ?? null,
    decisions && make("div", { class: "card after" }, decisions),
    camerasSection(run),
    section("Run", make("div", { class: "pair" }, ...facts)),
    views && section("All views", make("div", { class: "card" }, views)),
    options && section("Options", make("div", { class: "card" }, options)),
  ].filter((part) => part !== null);
}
