import { expect, test } from "vitest";
import type { SourceFile } from "../state/types";
import { applied, conflictsOf, edited, following, rebased, type Sources, textOf } from "./sources";

const file = (path: string, source: string): SourceFile => ({
  path,
  source,
  language: "python",
  editable: true,
});
const start: Sources = { files: [file("a.py", "one"), file("b.py", "two")], drafts: {}, bases: {} };

test("a file that was not edited shows what runs", () => {
  expect(textOf(start, "a.py")).toBe("one");
});

test("a file that was edited shows the edited text", () => {
  const sources = edited(start, "a.py", "uno");
  expect(textOf(sources, "a.py")).toBe("uno");
  expect(textOf(sources, "b.py")).toBe("two");
});

test("a text that is edited back to what runs is no draft", () => {
  expect(edited(edited(start, "a.py", "uno"), "a.py", "one").drafts).toEqual({});
});

test("a message that repeats the files changes nothing", () => {
  expect(following(start, [file("a.py", "one"), file("b.py", "two")])).toBe(start);
});

test("a draft outlives a change of another file, and ends when its file goes", () => {
  const sources = edited(start, "a.py", "uno");
  expect(following(sources, [file("a.py", "one"), file("b.py", "dos")]).drafts).toEqual({ "a.py": "uno" });
  expect(following(sources, [file("b.py", "two")]).drafts).toEqual({});
});

test("what was applied runs, and what was typed meanwhile stays a draft", () => {
  const sources = edited(edited(start, "a.py", "uno"), "b.py", "dos");
  const later = applied(edited(sources, "b.py", "dos!"), sources.drafts);
  expect(later.files.map(({ source }) => source)).toEqual(["uno", "dos"]);
  expect(later.drafts).toEqual({ "b.py": "dos!" });
});

test("a file that others changed since it was edited is a conflict until that is decided", () => {
  const sources = edited(edited(start, "a.py", "uno"), "b.py", "dos");
  expect(conflictsOf(sources)).toEqual([]);
  const later = following(edited(sources, "a.py", "uno!"), [file("a.py", "eins"), file("b.py", "two")]);
  expect(conflictsOf(later)).toEqual(["a.py"]);
  expect(conflictsOf(rebased(later))).toEqual([]);
  expect(rebased(later).drafts).toEqual(later.drafts);
  expect(conflictsOf(applied(edited(sources, "b.py", "dos!"), sources.drafts))).toEqual([]);
});
