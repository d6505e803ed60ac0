"use strict";
// The page of a running training: polls its state, and shows the latest snapshot, scores and curves.
const $ = (id) => document.getElementById(id);
const player = $("player");
const CHARTS_EVERY = 3; // polls
let shown = 0; // number of the snapshot in the player,
let shownStep = 0; // its step,
let training = ""; // and the training that made it
let loading = false;
let polls = 0;
let offered = false; // whether the player has the held-out views

const count = (n) => Math.round(n).toLocaleString("en");
function duration(seconds) {
  if (!isFinite(seconds)) return "–";
  const s = Math.round(seconds);
  if (s < 60) return `${s} s`;
  return s < 3600 ? `${Math.floor(s / 60)} min ${s % 60} s` : `${Math.floor(s / 3600)} h ${Math.floor((s % 3600) / 60)} min`;
}

/** The player with its first snapshot, or the next one in its place. */
async function show(number, address, step) {
  if (loading || number <= shown) return;
  loading = true;
  try {
    const inside = player.contentWindow && player.contentWindow.tessera;
    if (inside) {
      await inside.replace(address);
    } else {
      player.src = `/api/player?scene=${encodeURIComponent(address)}&paused=1`;
      await new Promise((resolve) => player.addEventListener("load", resolve, { once: true }));
      for (let i = 0; i < 600 && !player.contentWindow.tessera; ++i) await new Promise((r) => setTimeout(r, 100));
      player.hidden = false;
      $("empty").hidden = true;
    }
    shown = number;
    shownStep = step;
  } catch (error) {
    $("status").textContent = `the snapshot could not be shown: ${error.message || error}`;
  } finally {
    loading = false;
  }
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
    ["model shown", shownStep > 0 ? `step ${count(shownStep)}` : "–"],
  ];
  $("numbers").replaceChildren(...rows.flatMap(([name, value]) => {
    const term = document.createElement("dt"), detail = document.createElement("dd");
    term.textContent = name;
    detail.textContent = value;
    return [term, detail];
  }));
}

async function showCharts() {
  const html = await (await fetch("/api/charts")).text();
  if (html !== "") $("charts").innerHTML = html;
}

function tell(answer) {
  const { state, alive, complete, page, stopped, resume } = answer;
  const left = state ? (state.total - state.step) / state.steps_per_second : NaN;
  const status = alive
    ? `training · ${duration(left)} left`
    : complete ? "the training is complete"
    : stopped ? `the training has stopped after ${count(stopped.step)} of ${count(stopped.total)} steps`
    : "the training has stopped";
  if (state || complete || stopped) $("status").textContent = status;
  else if (alive) $("status").textContent = "training";
  $("stop").hidden = !alive;
  $("finished").hidden = !page;
  if (page) $("finished").href = page;
  $("resume").hidden = resume === "";
  $("resume").querySelector("code").textContent = resume;
  if (alive) $("go").disabled = false;
  else $("stop").disabled = false;
  if (!alive && (state || complete || stopped)) $("empty").textContent = `${status[0].toUpperCase()}${status.slice(1)}.`;
  const share = complete ? 100 : state ? (100 * state.step) / Math.max(1, state.total) : 0;
  $("bar").firstElementChild.style.width = `${share}%`;
  $("bar").setAttribute("aria-valuenow", share.toFixed(0));
}

/** The held-out views, to be compared with in the player, once both are there. */
function offer(views) {
  const inside = player.contentWindow && player.contentWindow.tessera;
  if (offered || !inside || views.length === 0) return;
  inside.truth(views);
  offered = true;
}

async function poll() {
  try {
    const answer = await (await fetch(`/api/state?seen=${shown}`)).json();
    document.title = `${answer.name} – Tessera`;
    $("name").textContent = answer.name;
    tell(answer);
    offer(answer.views);
    if (polls++ % CHARTS_EVERY === 0) await showCharts();
    const { state } = answer;
    if (state && state.training !== training) {
      training = state.training;
      shown = 0;
    }
    if (state) {
      numbers(state, answer.scores);
      if (answer.snapshot && state.snapshot > shown) show(state.snapshot, answer.snapshot, state.snapshot_step);
    }
  } catch (error) {
    $("status").textContent = "tessera view does not answer any more";
  }
  setTimeout(poll, 1000);
}

$("stop").addEventListener("click", async () => {
  $("stop").disabled = true;
  if (!(await fetch("/api/stop", { method: "POST" })).ok) $("stop").disabled = false;
});
$("go").addEventListener("click", async () => {
  $("go").disabled = true;
  if (!(await fetch("/api/resume", { method: "POST" })).ok) $("go").disabled = false;
});
poll();
