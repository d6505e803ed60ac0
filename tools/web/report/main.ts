// The report of a run: reads the data that the program has written into the page.
import "uplot/dist/uPlot.min.css";
import "./report.css";

const data = JSON.parse(document.getElementById("tessera-report")!.textContent!);
document.getElementById("report")!.textContent = data === null ? "No report." : data.title;
