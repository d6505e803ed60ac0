"use strict";
const $ = (id) => document.getElementById(id);
const player = $("player");
let shown = 0; // number of the snapshot in the player
let loading = false;
let logged = 0; // bytes of the log that were read
let views = [];
const curves = { loss: [], stat: [], dyn: [] }; // [step, value]

const count = (n) => Math.round(n).toLocaleString("en");
function duration(seconds) {
  if (!isFinite(seconds)) return "–";
  const s = Math.round(seconds);
  if (s < 60) return `${s} s`;
  return s < 3600 ? `${Math.floor(s / 60)} min ${s % 60} s` : `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
}

/** Curves over steps; labels at both ends of the axes. */
function draw(svg, lines, end, digits) {
  const width = svg.clientWidth || 280, height = 96, left = 44, bottom = 16, top = 6;
  const points = lines.flat();
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  if (points.length === 0) return svg.replaceChildren();
  let low = Math.min(...points.map((p) => p[1])), high = Math.max(...points.map((p) => p[1]));
  if (high - low < 1e-9) { low -= 0.5; high += 0.5; }
  const x = (step) => left + ((width - left - 4) * step) / Math.max(1, end);
  const y = (value) => top + ((height - bottom - top) * (high - value)) / (high - low);
  const make = (name, attributes, text) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    if (text !== undefined) element.textContent = text;
    return element;
  };
  const label = (value) => (digits === 0 ? count(value) : value.toFixed(digits));
  svg.replaceChildren(
    make("line", { class: "axis", x1: left, x2: width - 4, y1: height - bottom, y2: height - bottom }),
    make("line", { class: "axis", x1: left, x2: left, y1: top, y2: height - bottom }),
    make("text", { x: left - 4, y: top + 8, "text-anchor": "end" }, label(high)),
    make("text", { x: left - 4, y: height - bottom, "text-anchor": "end" }, label(low)),
    make("text", { x: left, y: height - 3 }, "0"),
    make("text", { x: width - 4, y: height - 3, "text-anchor": "end" }, `${count(end)} steps`),
    ...lines.map((line, i) =>
      make("polyline", { class: i === 1 ? "second" : "", points: line.map((p) => `${x(p[0]).toFixed(1)},${y(p[1]).toFixed(1)}`).join(" ") })),
  );
}

/** The player with its first snapshot, or the next one in its place. */
async function show(number, address) {
  if (loading || number <= shown) return;
  loading = true;
  try {
    const inside = player.contentWindow && player.contentWindow.tessera;
    if (shown > 0 && inside) {
      await inside.replace(address);
    } else {
      player.src = `/api/player?scene=${encodeURIComponent(address)}&paused=1`;
      await new Promise((resolve) => player.addEventListener("load", resolve, { once: true }));
      for (let i = 0; i < 600 && !player.contentWindow.tessera; ++i) await new Promise((r) => setTimeout(r, 100));
      player.hidden = false;
      $("empty").hidden = true;
    }
    shown = number;
  } catch (error) {
    $("status").textContent = `the snapshot could not be shown: ${error.message || error}`;
  } finally {
    loading = false;
  }
}

function choose() {
  const view = views[$("view").value];
  $("slide").hidden = $("truth").hidden = view === undefined;
  if (view === undefined) return;
  $("truth").src = `/api/truth?view=${$("view").value}`;
  const inside = player.contentWindow && player.contentWindow.tessera;
  if (!inside) return;
  inside.pause();
  inside.look(view.camera);
  inside.seek(view.t * inside.duration());
}
function slide() {
  $("truth").style.clipPath = `inset(0 0 0 ${100 - Number($("share").value)}%)`;
}

function numbers(state, scores) {
  const last = scores.length > 0 ? scores[scores.length - 1][1] : null;
  const rows = [
    ["PSNR, held out", last === null ? "–" : `${last.toFixed(2)} dB`],
    ["step", `${count(state.step)} / ${count(state.total)}`],
    ["loss", state.loss === null ? "–" : state.loss.toFixed(4)],
    ["static Gaussians", count(state.num_static)],
    ["dynamic Gaussians", count(state.num_dynamic)],
    ["speed", `${state.steps_per_second.toFixed(1)} steps/s`],
    ["memory", `${(state.device_bytes / 2 ** 20).toFixed(0)} MiB`],
    ["model shown", shown > 0 ? `step ${count(state.snapshot_step)}` : "–"],
  ];
  $("numbers").replaceChildren(...rows.flatMap(([name, value]) => {
    const term = document.createElement("dt"), detail = document.createElement("dd");
    term.textContent = name;
    detail.textContent = value;
    return [term, detail];
  }));
}

async function readLog() {
  const text = await (await fetch(`/api/log?from=${logged}`)).text();
  if (text === "") return;
  logged += new TextEncoder().encode(text).length;
  for (const line of text.split("\n")) {
    if (!line.includes('"event":"steps"')) continue;
    const event = JSON.parse(line);
    if (event.loss !== null) curves.loss.push([event.iteration, event.loss]);
    curves.stat.push([event.iteration, event.num_static]);
    curves.dyn.push([event.iteration, event.num_dynamic]);
  }
}

function tell(answer) {
  const { state, alive, page, resume } = answer;
  const left = state ? (state.total - state.step) / state.steps_per_second : NaN;
  const status = alive
    ? `training · ${duration(left)} left`
    : page ? "the training is complete" : "the training has stopped";
  if (state || alive) $("status").textContent = state ? status : "training";
  $("stop").hidden = !alive;
  $("finished").hidden = !page;
  if (page) $("finished").href = page;
  $("resume").hidden = alive || Boolean(page) || !state;
  $("resume").querySelector("code").textContent = resume;
  const share = state ? (100 * state.step) / Math.max(1, state.total) : 0;
  $("bar").firstElementChild.style.width = `${share}%`;
  $("bar").setAttribute("aria-valuenow", share.toFixed(0));
}

function offer(list) {
  if (views.length > 0 || list.length === 0) return;
  views = list;
  list.forEach((view, i) => $("view").add(new Option(view.name, String(i))));
}

async function poll() {
  try {
    const answer = await (await fetch(`/api/state?seen=${shown}`)).json();
    document.title = `${answer.name} – Tessera`;
    $("name").textContent = answer.name;
    tell(answer);
    offer(answer.views);
    await readLog();
    const { state } = answer;
    if (state) {
      numbers(state, answer.scores);
      draw($("psnr"), [answer.scores], state.step, 1);
      draw($("loss"), [curves.loss], state.step, 3);
      draw($("count"), [curves.stat, curves.dyn], state.step, 0);
      if (answer.snapshot && state.snapshot > shown) show(state.snapshot, answer.snapshot);
    }
  } catch (error) {
    $("status").textContent = "tessera view does not answer any more";
  }
  setTimeout(poll, 1000);
}

$("view").addEventListener("change", choose);
$("share").addEventListener("input", slide);
$("stop").addEventListener("click", async () => {
  $("stop").disabled = true;
  await fetch("/api/stop", { method: "POST" });
});
slide();
poll();
