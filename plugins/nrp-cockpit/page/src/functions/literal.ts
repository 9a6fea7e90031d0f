import { ensureSyntaxTree, syntaxTree } from "@codemirror/language";
import type { EditorState } from "@codemirror/state";

/** A number that is written in a text. */
export interface Literal {
  from: number;
  to: number;
  /** Counted from 1. */
  line: number;
  value: number;
  /** Whether only integers can stand there. */
  whole: boolean;
}

type Node = ReturnType<ReturnType<typeof syntaxTree>["resolveInner"]>;

const NUMBER = /^-?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?$/i;
/** Attributes of models that are real numbers, also where an integer is written. */
const REAL = new Set(["factor", "value"]);

/** The editor parses a text in pieces, and may not have come to the cursor. */
const PARSE_MS = 100;

/** The number at the cursor: a literal of Python with its sign, or an attribute of XML; null: there is none. */
export function literalAt(state: EditorState): Literal | null {
  const { head } = state.selection.main;
  const tree = ensureSyntaxTree(state, head, PARSE_MS) ?? syntaxTree(state);
  for (const side of [1, -1] as const) {
    const found = literalOf(tree.resolveInner(head, side), state);
    if (found) return found;
  }
  return null;
}

function literalOf(node: Node, { doc }: EditorState): Literal | null {
  const [from, to] = node.name === "AttributeValue" ? [node.from + 1, node.to - 1] : [fromOf(node), node.to];
  if (node.name !== "Number" && node.name !== "AttributeValue") return null;
  const text = doc.sliceString(from, to).replace(/^-\s+/, "-");
  if (!NUMBER.test(text)) return null;
  const name = node.parent?.getChild("AttributeName");
  const isReal = name ? REAL.has(doc.sliceString(name.from, name.to)) : false;
  return {
    from,
    to,
    line: doc.lineAt(from).number,
    value: Number(text),
    whole: !isReal && /^-?\d+$/.test(text),
  };
}

/** Where a literal of Python begins, with its sign. */
function fromOf(node: Node): number {
  const { parent } = node;
  const sign = parent?.name === "UnaryExpression" ? parent.firstChild : null;
  return sign?.name === "ArithOp" && sign.nextSibling?.from === node.from ? sign.from : node.from;
}

/** A number as it is written in place of another. */
export function written(value: number, whole: boolean): string {
  if (whole) return String(Math.round(value));
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}
