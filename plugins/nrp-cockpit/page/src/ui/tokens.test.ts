import { readFileSync } from "node:fs";
import { expect, it } from "vitest";

/** The contrast that WCAG 2 asks of text (success criterion 1.4.3). */
const LEAST = 4.5;
const TEXTS = ["text", "text-2", "text-3", "accent", "ok", "warn", "bad"];
const FILLS = ["panel", "sunken", "bg", "hover", "accent-soft"];

const css = readFileSync(new URL("./tokens.css", import.meta.url), "utf8");

/** The colours of a theme by their tokens. */
function coloursOf(theme: string): Map<string, string> {
  const [, body = ""] = new RegExp(`\\.theme-${theme} \\{([^}]*)\\}`).exec(css) ?? [];
  const found = body.matchAll(/--([\w-]+):\s*(#[\da-f]{6})/gi);
  return new Map([...found].map(([, token = "", value = ""]) => [token, value]));
}

/** Relative luminance, as WCAG 2 defines it. */
function luminance(colour: string): number {
  const [r = 0, g = 0, b = 0] = [1, 3, 5].map((at) => {
    const share = Number.parseInt(colour.slice(at, at + 2), 16) / 255;
    return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
  });
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

function contrast(a: string, b: string): number {
  const [dark = 0, light = 0] = [luminance(a), luminance(b)].sort((x, y) => x - y);
  return (light + 0.05) / (dark + 0.05);
}

it.each(["light", "dark"])("text is legible on every fill in the %s theme", (theme) => {
  const colours = coloursOf(theme);
  const ratio = (a: string, b: string) => contrast(colours.get(a) ?? "", colours.get(b) ?? "");
  const pairs = [["on-accent", "accent"], ...TEXTS.flatMap((text) => FILLS.map((fill) => [text, fill]))];
  // a token that is not there gives NaN, which is not enough either
  const faint = pairs.filter(([text = "", fill = ""]) => !(ratio(text, fill) >= LEAST));
  expect(faint).toEqual([]);
});
