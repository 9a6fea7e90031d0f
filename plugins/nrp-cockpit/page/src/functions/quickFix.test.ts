import { Text } from "@codemirror/state";
import { expect, test } from "vitest";
import type { Finding } from "../state/types";
import { difference, editOf } from "./quickFix";

const finding = (written: string, meant: string, line: number | null, column: number | null): Finding => ({
  code: "NRP240",
  weight: "error",
  summary: "wrong",
  why: "",
  fix: "",
  file: "a.py",
  line,
  column,
  count: 1,
  instead: { written, meant },
});

function fixed(text: string, one: Finding): string | null {
  const doc = Text.of(text.split("\n"));
  const edit = editOf(one, doc);
  if (!edit) return null;
  const { from, to, insert } = edit.changes;
  return text.slice(0, from) + insert + text.slice(to);
}

test("the name is replaced where it stands as a whole", () => {
  expect(fixed("f\nrates_a = eye.rates", finding("rates", "rate", 2, null))).toBe("f\nrates_a = eye.rate");
  expect(fixed('T("/odo/x", "/odo")', finding("/odo", "/odom", 1, null))).toBe('T("/odo/x", "/odom")');
});

test("of several the one at the column of the finding is meant", () => {
  expect(fixed("a.rates = b.rates", finding("rates", "rate", 1, 11))).toBe("a.rates = b.rate");
  expect(fixed("a.rates = b.rates", finding("rates", "rate", 1, 1))).toBe("a.rate = b.rates");
});

test("a name that is not in its line, or a finding without a line, has no fix", () => {
  expect(fixed("a.rate", finding("rates", "rate", 1, 1))).toBeNull();
  expect(fixed("a.rates", finding("rates", "rate", 9, 1))).toBeNull();
  expect(fixed("a.rates", finding("rates", "rate", null, null))).toBeNull();
  expect(fixed("a.rates", { ...finding("rates", "rate", 1, 1), instead: null })).toBeNull();
});

test("only what differs between two texts is replaced", () => {
  expect(difference("a.rates = 1", "a.rate = 1")).toEqual({ from: 6, to: 7, insert: "" });
  expect(difference("aa", "aaa")).toEqual({ from: 2, to: 2, insert: "a" });
  expect(difference("same", "same")).toEqual({ from: 4, to: 4, insert: "" });
});
