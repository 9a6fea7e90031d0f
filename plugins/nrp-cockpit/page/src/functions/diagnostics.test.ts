import { Text } from "@codemirror/state";
import { expect, test } from "vitest";
import type { Finding } from "../state/types";
import { diagnosticsOf, findingsOf, newIn } from "./diagnostics";

const finding = (file: string | null, line: number | null, summary = "wrong"): Finding => ({
  code: "NRP240",
  weight: "error",
  summary,
  why: "",
  fix: "",
  file,
  line,
  column: null,
  count: 1,
  instead: null,
});
const doc = Text.of(["def f(t):", "    eye.rates = 1", ""]);
const placeOf = (one: Finding) => {
  const [mark] = diagnosticsOf([one], doc);
  return [mark?.from, mark?.to];
};

test("a finding marks the text of its line, not the indent", () => {
  expect(placeOf(finding("a.py", 2))).toEqual([14, 27]);
});

test("a finding without a line marks the first one", () => {
  expect(placeOf(finding("a.py", null))).toEqual([0, 9]);
});

test("a finding beyond the end of the text marks the last line", () => {
  expect(placeOf(finding("a.py", 99))).toEqual([28, 28]);
});

test("an edited file shows what was found in its draft, another what was found in the run", () => {
  const checked = [finding("/home/x/a.py", 1, "draft")];
  const ofRun = [finding("a.py", 1, "run"), finding("b.py", 1, "run"), finding(null, null)];
  const drafts = { "a.py": "" };
  expect(findingsOf("a.py", drafts, checked, ofRun).map(({ summary }) => summary)).toEqual(["draft"]);
  expect(findingsOf("b.py", drafts, checked, ofRun).map(({ summary }) => summary)).toEqual(["run"]);
});

test("a file is not taken for another one whose name ends the same", () => {
  expect(findingsOf("a.py", {}, [], [finding("/home/x/aa.py", 1)])).toEqual([]);
});

test("what a check finds in the run as it is says nothing about the edit", () => {
  const known = finding("a.py", 1);
  const fresh = finding("a.py", 2);
  expect(newIn([known, fresh], [{ ...known }])).toEqual([fresh]);
});
