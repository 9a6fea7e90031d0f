import { CompletionContext } from "@codemirror/autocomplete";
import { python } from "@codemirror/lang-python";
import { EditorState } from "@codemirror/state";
import { expect, test } from "vitest";
import { completing } from "./completion";

const WORDS = [{ label: "/husky/cmd_vel", type: "text" }];

const complete = (text: string, explicit = false) =>
  completing(async () => WORDS)(
    new CompletionContext(EditorState.create({ doc: text, extensions: [python()] }), text.length, explicit),
  );

test("a topic is completed from its first slash on", async () => {
  expect(await complete("Topic('/husky/c")).toMatchObject({ from: 7, options: WORDS });
});

test("a dotted name is completed as a whole", async () => {
  expect((await complete("x = nrp.brain.se"))?.from).toBe(4);
});

test("nothing is offered where nothing was typed, unless it is asked for", async () => {
  expect(await complete("x = ")).toBeNull();
  expect(await complete("x = ", true)).toMatchObject({ from: 4, options: WORDS });
});

test("nothing is offered inside a comment", async () => {
  expect(await complete("x = 1  # nrp.bra")).toBeNull();
});
