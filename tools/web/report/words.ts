// Numbers, sizes, durations and dates as texts.
import type { Run } from "./data";

export const UNKNOWN = "–";

/** 12345 → "12.3k", 1234 → "1,234", 0.12345 → "0.1235". */
export function shortNumber(value: number): string {
  const size = Math.abs(value);
  const digits = (scaled: number, count: number) => String(Number(scaled.toPrecision(count)));
  if (size >= 1e10) return `${digits(value / 1e9, 3)}G`;
  if (size >= 1e6) return `${digits(value / 1e6, 3)}M`;
  if (size >= 1e4) return `${digits(value / 1e3, 3)}k`;
  if (size >= 1e3) return wholeNumber(value);
  return digits(value, 4);
}

export function wholeNumber(value: number): string {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, ",");
}

export function fixed(value: number | null, digits: number): string {
  return value === null ? UNKNOWN : value.toFixed(digits);
}

export function decibels(value: number | null, digits = 2): string {
  return value === null ? UNKNOWN : `${value.toFixed(digits)} dB`;
}

export function sizeWords(bytes: number | null): string {
  if (bytes === null) return UNKNOWN;
  if (bytes < 1e3) return `${bytes} B`;
  if (bytes < 1e6) return `${(bytes / 1e3).toFixed(1)} kB`;
  if (bytes < 1e9) return `${(bytes / 1e6).toFixed(1)} MB`;
  return `${(bytes / 1e9).toFixed(2)} GB`;
}

export function timeWords(seconds: number | null): string {
  if (seconds === null) return UNKNOWN;
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  const two = (value: number) => String(value).padStart(2, "0");
  if (whole < 3600) return `${Math.floor(whole / 60)}:${two(whole % 60)} min`;
  return `${Math.floor(whole / 3600)}:${two(Math.floor(whole / 60) % 60)}:${two(whole % 60)} h`;
}

/** "2026-11-24 09:30 UTC" of an ISO time in UTC; other text as it is. */
export function dateWords(time: string): string {
  return /^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d(\.\d+)?Z$/.test(time)
    ? `${time.slice(0, 10)} ${time.slice(11, 16)} UTC`
    : time;
}

export function viewsWords(split: Run["split"]): string {
  if (split === "train") return "training views, as nothing is held out";
  return split === "val" ? "validation views" : "test views";
}

export function optionWords(value: unknown): string {
  if (value === undefined || value === null) return UNKNOWN;
  return typeof value === "string" ? value : JSON.stringify(value);
}
