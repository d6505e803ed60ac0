// The report of a run, of several, of a batch, or of a running training: reads what the program has
// written into the page.
import "uplot/dist/uPlot.min.css";
import "./report.css";
import { batchPage } from "./batch";
import { comparisonPage } from "./comparison";
import { readReport } from "./data";
import { make } from "./elements";
import { livePage } from "./live";
import { runPage } from "./run";
import { dateWords } from "./words";

const report = readReport(document.getElementById("tessera-report")!.textContent ?? "");
const main = document.getElementById("report")!;
if (report === "live") {
  main.append(...livePage());
} else if (typeof report === "string") {
  main.append(make("p", { class: "card", role: "alert" }, report));
} else {
  document.title = `Tessera: ${report.title}`;
  const [first] = report.runs;
  const alone = report.kind === "run" && report.runs.length === 1;
  main.append(
    ...(report.batch !== undefined ? batchPage(report, report.batch)
      : alone ? runPage(first, report.title) : comparisonPage(report)),
    make("footer", {}, `Made by Tessera ${report.version}, ${dateWords(report.made)}.`),
  );
}
