// What: the frame of a batch's report: style for light and dark, places in {{braces}}.
// Not: what stands in the places (report_page.cpp).
#pragma once

namespace tessera {

constexpr const char* kReportTemplate = R"html(<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta name="color-scheme" content="light dark">
<title>Tessera: {{title}}</title>
<style>
:root { --ink: #1b1b1b; --paper: #ffffff; --line: #d0d0d0; --faint: #6a6a6a; --bad: #b3261e; --link: #0b57d0; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --paper: #161616; --line: #404040; --faint: #9a9a9a; --bad: #ff8a80; --link: #8ab4f8; }
}
body { margin: 2rem auto; max-width: 80rem; padding: 0 1rem; color: var(--ink); background: var(--paper);
  font: 16px/1.5 system-ui, sans-serif; }
h1 { font-size: 1.5rem; overflow-wrap: anywhere; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
a { color: var(--link); } .faint { color: var(--faint); } .bad { color: var(--bad); }
.wide { overflow-x: auto; }
.charts { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 36rem), 1fr)); gap: 1rem; }
table { border-collapse: collapse; } th, td { padding: .3rem .7rem; text-align: left; vertical-align: top; }
th { border-bottom: 2px solid var(--line); } td { border-bottom: 1px solid var(--line); }
td.number { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
img { max-width: 100%; } img.chart { background: #ffffff; } img.view { display: block; width: 200px; }
code { overflow-wrap: anywhere; }
</style>
</head>
<body>
<h1>{{title}}</h1>
<p>{{summary}}</p>
{{body}}
</body>
</html>
)html";

}  // namespace tessera
