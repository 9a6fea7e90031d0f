import { HighlightStyle, syntaxHighlighting } from "@codemirror/language";
import { EditorView } from "@codemirror/view";
import { tags } from "@lezer/highlight";

/** Findings and notes in the colours of their weights. */
function severities() {
  const colours = { error: "var(--bad)", warning: "var(--warn)", info: "var(--line-strong)" };
  return Object.fromEntries(
    Object.entries(colours).flatMap(([weight, color]) => [
      [`.cm-diagnostic-${weight}`, { borderLeftColor: color }],
      [`.cm-lintRange-${weight}`, { textDecorationColor: color }],
      [`.cm-lineNote-${weight}`, { color: weight === "info" ? "var(--text-3)" : color }],
    ]),
  );
}

/** What a side of a comparison took away or brought. */
const changed = (side: "a" | "b", colour: "bad" | "ok") => ({
  [`&.cm-merge-${side} .cm-changedLine`]: { backgroundColor: `var(--${colour}-soft)` },
  [`&.cm-merge-${side} .cm-changedText`]: {
    background: `color-mix(in srgb, var(--${colour}) 24%, transparent)`,
  },
  [`&.cm-merge-${side} .cm-changedLineGutter`]: { background: `var(--${colour})` },
});

const look = EditorView.theme({
  "&": { height: "100%", fontSize: "13px", color: "var(--text)", backgroundColor: "var(--panel)" },
  "&.cm-focused": { outline: "none" },
  ".cm-scroller": { fontFamily: "var(--mono)", lineHeight: "20px", scrollbarWidth: "thin" },
  ".cm-content": { caretColor: "var(--accent)", padding: "8px 0" },
  ".cm-cursor": { borderLeftColor: "var(--accent)", borderLeftWidth: "2px" },
  ".cm-gutters": { backgroundColor: "var(--panel)", color: "var(--text-3)", border: "0" },
  ".cm-lineNumbers .cm-gutterElement": { minWidth: "36px", fontVariantNumeric: "tabular-nums" },
  ".cm-activeLine, .cm-activeLineGutter": {
    backgroundColor: "color-mix(in srgb, var(--hover) 60%, transparent)",
  },
  "&.cm-focused > .cm-scroller > .cm-selectionLayer .cm-selectionBackground, .cm-selectionBackground": {
    backgroundColor: "color-mix(in srgb, var(--accent) 24%, transparent)",
  },
  ".cm-matchingBracket, &.cm-focused .cm-matchingBracket": { backgroundColor: "var(--accent-soft)" },
  ".cm-selectionMatch": { backgroundColor: "var(--accent-soft)" },
  ".cm-panels": { backgroundColor: "var(--sunken)", color: "var(--text)", borderColor: "var(--line)" },
  ".cm-textfield, .cm-button": {
    backgroundColor: "var(--panel)",
    backgroundImage: "none",
    border: "1px solid var(--line)",
    borderRadius: "var(--r-4)",
  },
  ".cm-tooltip": {
    backgroundColor: "var(--panel)",
    color: "var(--text)",
    border: "1px solid var(--line)",
    borderRadius: "var(--r-6)",
    boxShadow: "var(--shadow-2)",
    overflow: "hidden",
  },
  ".cm-tooltip.cm-tooltip-autocomplete > ul": { fontFamily: "var(--mono)", fontSize: "12px" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li": { padding: "2px 8px", lineHeight: "18px" },
  ".cm-tooltip.cm-tooltip-autocomplete > ul > li[aria-selected]": {
    backgroundColor: "var(--accent-soft)",
    color: "var(--text)",
  },
  ".cm-completionDetail": { color: "var(--text-3)", fontStyle: "normal", fontFamily: "var(--ui)" },
  ".cm-foldPlaceholder": { backgroundColor: "var(--hover)", border: "0", color: "var(--text-2)" },
  ".cm-diagnostic": { padding: "8px 12px", font: "12px/16px var(--ui)", maxWidth: "560px" },
  ".cm-lintRange": {
    backgroundImage: "none",
    textDecoration: "underline wavy 1.5px",
    textUnderlineOffset: "3px",
  },
  ".cm-collapsedLines": {
    background: "var(--sunken)",
    color: "var(--text-2)",
    fontFamily: "var(--ui)",
    fontSize: "12px",
  },
  ".cm-collapsedLines:before, .cm-collapsedLines:after": { content: "'…'" },
  ".cm-lineNote": { paddingLeft: "24px", font: "12px/20px var(--ui)", whiteSpace: "nowrap" },
  ".cm-lineFix": {
    marginLeft: "8px",
    padding: "0 8px",
    font: "inherit",
    lineHeight: "16px",
    color: "var(--accent)",
    background: "var(--panel)",
    border: "1px solid var(--line-strong)",
    borderRadius: "var(--r-4)",
    cursor: "pointer",
  },
  ".cm-lineFix:hover": { background: "var(--hover)" },
  ".cm-diagnosticAction": {
    margin: "4px 0 0",
    padding: "2px 8px",
    font: "inherit",
    color: "var(--accent)",
    background: "var(--panel)",
    border: "1px solid var(--line-strong)",
    borderRadius: "var(--r-4)",
    cursor: "pointer",
  },
  ...severities(),
  ...changed("a", "bad"),
  ...changed("b", "ok"),
});

const colours = HighlightStyle.define([
  { tag: [tags.keyword, tags.operatorKeyword, tags.meta, tags.tagName], color: "var(--k-key)" },
  { tag: [tags.string, tags.special(tags.string), tags.attributeValue], color: "var(--k-str)" },
  { tag: [tags.number, tags.bool, tags.null], color: "var(--k-num)" },
  { tag: [tags.function(tags.definition(tags.variableName)), tags.attributeName], color: "var(--k-fn)" },
  { tag: [tags.className, tags.definition(tags.typeName)], color: "var(--k-fn)" },
  { tag: [tags.comment, tags.processingInstruction], color: "var(--k-com)" },
  { tag: tags.invalid, color: "var(--bad)" },
]);

/** The editor in the page's own colours: custom properties, so that it follows light and dark by itself. */
export const theme = [look, syntaxHighlighting(colours)];
