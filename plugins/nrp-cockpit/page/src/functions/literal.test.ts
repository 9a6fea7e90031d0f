import { python } from "@codemirror/lang-python";
import { xml } from "@codemirror/lang-xml";
import { ensureSyntaxTree } from "@codemirror/language";
import { EditorState } from "@codemirror/state";
import { expect, test } from "vitest";
import { literalAt, written } from "./literal";

/** The number at the mark | of a text. */
function at(text: string, language = python()) {
  const anchor = text.indexOf("|");
  const doc = text.replace("|", "");
  const state = EditorState.create({ doc, selection: { anchor }, extensions: [language] });
  ensureSyntaxTree(state, doc.length, 5000);
  const found = literalAt(state);
  return found && { ...found, text: doc.slice(found.from, found.to) };
}

test.each([
  ["x = 20| * y", "20", 20, true],
  ["x = |20.5 * y", "20.5", 20.5, false],
  ["\ncolor(-1.|5e-3)", "-1.5e-3", -0.0015, false],
  ["x = a - 3|", "3", 3, true],
  ["x = a[-1|]", "-1", -1, true],
])("the number at the cursor of %j", (text, number, value, whole) => {
  expect(at(text)).toMatchObject({ text: number, value, whole, line: text.split("\n").length });
});

test.each(["x = 0x|10", "x = 2|j", 'x = "20|"', "x2|0 = y", "# 20|", "x = |y"])(
  "%j has no number",
  (text) => {
    expect(at(text)).toBeNull();
  },
);

test("the attributes of a model are numbers, and gains are real ones", () => {
  expect(at('<body type="Scale" factor="2|0"/>', xml())).toMatchObject({
    text: "20",
    value: 20,
    whole: false,
  });
  expect(at('<neurons index="0|"/>', xml())).toMatchObject({ value: 0, whole: true });
  expect(at('<body type="Sc|ale"/>', xml())).toBeNull();
});

test("a number stays of its kind", () => {
  expect([written(3.7, true), written(4, false), written(0.25, false), written(1e-7, false)]).toEqual([
    "4",
    "4.0",
    "0.25",
    "1e-7",
  ]);
});
