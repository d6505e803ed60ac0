// The report of a run, of several, or of a running training: reads what the program has written into
// the page.
import "uplot/dist/uPlot.min.css";
import "./report.css";
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
  const several = report.kind === "comparison" || report.runs.length > 1;
  main.append(
    ...(several ? comparisonPage(report) : runPage(report.runs[0], report.title)),
    make("footer", {}, `Made by Tessera ${report.version}, ${dateWords(report.made)}.`),
  );
}
